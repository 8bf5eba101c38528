"""Turns on the spot over the vertical: laps with a tilted jet that would wind a gantry's C beyond its hose."""

import math
from functools import lru_cache

import numpy as np
import pytest
from small_programs import program_of

from programs.program import Command, Instruction, MoveTo, SetNozzle, TimedProgram, Wait
from robotcell.cell.load import cell_library, read_cell, read_cell_text
from robotcell.robot.robot import flange_poses
from robotcell.track import CellReport, Terms, track

ROUND = Terms(round_nozzles=frozenset({"ring60"}))
MADE_BY = "sequence[0]/around/U1"


def tilting(azimuth: float) -> tuple[float, float, float, float]:
    """Jet tilted by 35 degrees towards a direction."""
    half = -math.radians(35) / 2
    w, i, j = math.cos(half), -math.sin(azimuth) * math.sin(half), math.cos(azimuth) * math.sin(half)
    return (-i, w, 0.0, -j)


@lru_cache
def square_laps(count: int) -> TimedProgram:
    """Round a square with the jet on; at each corner it rests, and turns by the shortest way to the next direction."""
    found: list[Instruction] = [Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "sequence[0]")]
    now, corners = 0.0, [(70.0, 40.0), (90.0, 40.0), (90.0, 60.0), (70.0, 60.0)]
    for number in range(4 * count):
        (x0, y0), (x1, y1) = corners[number % 4], corners[(number + 1) % 4]
        azimuth = 0.5 * math.pi * (number + 1)
        for share in np.linspace(0.0, 1.0, 5).tolist():
            place = (x0 + share * (x1 - x0), y0 + share * (y1 - y0), 50.0)
            found.append(MoveTo(round(now, 4), place, tilting(azimuth), 20.0, MADE_BY))
            now += 0.2
        found.append(Wait(round(now - 0.2, 4), 0.2, MADE_BY))
        if number == 0:
            found.append(SetNozzle(0.0, True, MADE_BY))
        now += 0.4
    found.append(SetNozzle(round(now, 4), False, MADE_BY))
    return program_of(*found)


@lru_cache
def tracked(count: int, hose_turns: float) -> CellReport:
    text = (
        cell_library()["gantry"].read_text("utf-8").replace("\nhome_deg_mm", f"\nhose_turns: {hose_turns}\nhome_deg_mm")
    )
    return track(square_laps(count), read_cell_text(text).cell, None, terms=ROUND)


def test_within_the_hose_the_jet_turns_as_programmed() -> None:
    report = tracked(1, 1.5)
    assert report.possible
    assert not [finding for finding in report.findings if finding.rule.id == "jet-tilted"]


def test_more_laps_than_the_hose_allows_turn_over_the_vertical_on_the_spot() -> None:
    report = tracked(3, 1.0)
    assert report.possible
    assert np.abs(report.joints[:, 3]).max() <= 2.0 * math.pi + 1e-9
    assert np.abs(np.diff(report.joints[:, 3:], axis=0)).max() <= math.radians(15.0)  # no jump
    own = report.joints[report.clearance_at]  # without joint moves
    tips = flange_poses(report.cell.robot, own) @ report.cell.tools[0].T_flange_tcp
    places = 1e3 * (np.linalg.inv(report.cell.T_cell_board) @ report.cell.T_cell_base @ tips)[:, :3, 3]
    off = np.maximum(np.abs(places[:, 0] - 80.0), np.abs(places[:, 1] - 50.0)) - 10.0
    np.testing.assert_allclose(off, 0.0, atol=1e-3)
    np.testing.assert_allclose(places[:, 2], 50.0, atol=1e-3)
    (found,) = (finding for finding in report.findings if finding.rule.id == "jet-tilted")
    assert "or the hose would wind up" in found.message


@pytest.mark.slow
def test_a_nozzle_that_is_not_round_cannot_do_that() -> None:
    cell = read_cell("gantry").cell
    report = track(square_laps(4), cell, None, terms=Terms())
    assert not report.possible


def test_the_hose_bounds_joints_that_turn_farther_and_no_others() -> None:
    joints = {joint.name: joint for joint in read_cell("gantry").cell.robot.joints}
    assert (joints["C"].lowest, joints["C"].highest) == pytest.approx((-3.0 * math.pi, 3.0 * math.pi))
    assert joints["B"].highest == pytest.approx(math.radians(60.0))
    assert joints["X"].highest == pytest.approx(0.3)
