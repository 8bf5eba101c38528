"""Where the model of the spray does not hold, the process has no verdict, and the reason is said."""

import numpy as np
import pytest
from analysed import board_of
from jet_references import footprint
from small_sprays import CONE, FAN, KNIFE, RING, downward, samples_of, stage_of

from cleaning.verdicts.process_rules import judge_range
from recipes.nozzles import HollowCone

BOARD = board_of("U1")


def judged(height=50.0, tilt=0.0, nozzle=RING, turn=0.0, use="wash", side="top"):
    axes, z = downward(tilt, turn), height
    if side == "bottom":
        axes, z = np.diag([1.0, -1.0, -1.0]) @ axes, BOARD.bottom_z_mm - height
    samples = samples_of([[20.0, 15.0, z]] * 4, np.stack([axes] * 4))
    return judge_range([stage_of(samples, nozzle, use)], BOARD)


@pytest.mark.parametrize("side", ["top", "bottom"])
@pytest.mark.parametrize(
    ("height", "says"),
    [(19.0, "nearer than 20 mm"), (19.95, ""), (20.5, ""), (200.05, ""), (201.0, "farther than 200 mm")],
)
def test_a_nozzle_that_is_too_near_or_too_far_has_no_verdict(height, says, side):
    found = judged(height, side=side)
    assert [each.verdict for each in found] == (["no verdict"] if says else [])
    assert all(each.rule.id == "R14" and says in each.because and "100 %" in each.because for each in found)


@pytest.mark.parametrize("turn", [0.0, 37.0, 210.0])
@pytest.mark.parametrize("half_angle", [10.0, 30.0, 50.0, 80.0])
@pytest.mark.parametrize("short", [-5.0, -0.01, 0.01, 5.0])
def test_a_cone_has_no_verdict_just_where_its_footprint_is_open(half_angle, short, turn):
    tilt = 90.0 - half_angle - short
    nozzle = HollowCone(half_angle_deg=half_angle, flow_lpm=2.0)
    found = judged(tilt=tilt, nozzle=nozzle, turn=turn)
    assert bool(found) == (not footprint(np.radians(half_angle), np.radians(tilt), 50.0).closed)
    assert all("does not close" in each.because for each in found)


def test_a_fan_may_lean_across_its_sheet_farther_than_along_it():
    assert judged(tilt=55.0, nozzle=FAN)  # the sheet lies along the tool's x, which leans
    across = downward(55.0) @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    samples = samples_of([[20.0, 15.0, 50.0]], across[None])
    assert judge_range([stage_of(samples, FAN)], BOARD) == []


def test_gas_and_a_moment_outside_are_not_held_against_a_process():
    assert judged(5.0, nozzle=KNIFE, use="dry") == []
    heights = np.column_stack([np.full((40, 2), 20.0), np.where(np.arange(40) < 1, 10.0, 50.0)])
    assert judge_range([stage_of(samples_of(heights), CONE)], BOARD) == []
