"""Strokes become items that follow each other without a gap, and the jet opens at speed."""

from itertools import pairwise

import numpy as np
import pytest
from small_boards import board_of, part

from programs.plan import Dwell, Jet, Origin, Plan, SprayPass, Transfer
from programs.program import MoveTo, SetNozzle
from recipes.recipe import Limits
from rulesengine.planning.board_job import BoardWays, lay
from rulesengine.planning.pipeline import Assembly
from rulesengine.strokes.laid import Ordered, stroke_items
from rulesengine.strokes.safe_height import floors
from rulesengine.strokes.stroke import Stroke
from rulesengine.timing.time_plan import time_plan
from specs.source import Source

JET = Jet("clean", "ring60", "water", 2.0, liquid=True)
ORIGIN = Origin("boxes", "0" * 64, "test", "0" * 64)
LIMITS = Limits()


def stroke(*places, **changes):
    tcp = np.array(places, dtype=float)
    known = {"delays": np.zeros(len(tcp)), "speed_mm_s": 40.0, "made_by": Source(0, "line")} | changes
    down, along = np.tile([0.0, 0.0, -1.0], (len(tcp), 1)), np.tile([1.0, 0.0], (len(tcp), 1))
    return Stroke(tcp=tcp, approach=down, azimuth=along, **known)


def ways_over(board, side="top"):
    return BoardWays(board, LIMITS, side, floors(board, side, LIMITS.clearance_mm))


def sprayed(board, *strokes, retract="corridor"):
    ways = ways_over(board)
    made = Assembly(ways.parked)
    made.spray(Ordered(tuple(lay(each, retract) for each in strokes), ways), JET, 200.0)
    return made


def items_of(board, side, path):
    return stroke_items(ways_over(board, side), lay(path, "corridor"), JET)


def check_joined(items):
    moving = [item for item in items if isinstance(item, SprayPass | Transfer)]
    for before, after in pairwise(moving):
        np.testing.assert_allclose(before.tcp[-1], after.tcp[0], atol=1e-6)
        np.testing.assert_allclose(before.approach[-1], after.approach[0], atol=1e-6)
        np.testing.assert_allclose(before.reference[-1], after.reference[0], atol=1e-6)


def test_strokes_are_joined_by_transfers_that_clear_what_stands_between():
    board = board_of(part("J1", 45, 20, 10, 20, 60))
    made = sprayed(board, stroke((10, 30, 20), (35, 30, 20)), stroke((65, 30, 20), (90, 30, 20)))
    kinds = [type(item) for item in made.items]
    assert kinds == [Transfer, SprayPass, Transfer, SprayPass]
    check_joined(made.items)
    assert made.items[2].tcp[:, 2].max() >= 65
    assert [str(item.made_by) for item in made.items[1:3]] == ["sequence[0]/line", "sequence[0]/line/transfer"]


def test_pauses_cut_a_stroke_and_say_who_asked():
    path = stroke((0, 0, 20), (10, 0, 20), (20, 0, 20), delays=np.array([0, 0.3, 0.5]), pauses=("", "U1", ""))
    items = items_of(board_of(), "top", path)
    assert [type(item) for item in items] == [SprayPass, Dwell, SprayPass, Dwell]
    assert [str(item.made_by) for item in items if isinstance(item, Dwell)] == [
        "sequence[0]/line/U1",
        "sequence[0]/line",
    ]
    assert [item.duration_s for item in items if isinstance(item, Dwell)] == [0.3, 0.5]


def test_two_pauses_at_one_place_are_two_dwells_without_a_pass_between():
    path = stroke((0, 0, 20), (10, 0, 20), (10, 0, 20), (20, 0, 20), delays=np.array([0, 0.3, 0.4, 0]))
    items = items_of(board_of(), "top", path)
    assert [type(item) for item in items] == [SprayPass, Dwell, Dwell, SprayPass]


def test_the_bottom_side_is_sprayed_from_below():
    board = board_of(surface_z=5.0)
    (item,) = items_of(board, "bottom", stroke((0, 0, 20), (10, 0, 20)))
    assert item.tcp[:, 2] == pytest.approx(5.0 - 1.6 - 20)
    assert item.approach.tolist() == [[0, 0, 1], [0, 0, 1]]


def test_lead_in_is_timed_as_one_run_and_the_jet_opens_at_speed():
    made = sprayed(board_of(), stroke((30, 30, 20), (80, 30, 20), lead_in_mm=15.0))
    run_up, spray = made.items[-2:]
    assert isinstance(run_up, Transfer)
    assert isinstance(spray, SprayPass)
    np.testing.assert_allclose(run_up.tcp, [[15, 30, 20], [30, 30, 20]])
    program = time_plan(Plan(ORIGIN, tuple(made.items), ()), LIMITS)
    (opened,) = (i for i, each in enumerate(program.instructions) if isinstance(each, SetNozzle) and each.spraying)
    before = program.instructions[opened - 1]
    after = next(each for each in program.instructions[opened:] if isinstance(each, MoveTo))
    assert before.position == pytest.approx((30, 30, 20), abs=0.01)  # the moment is rounded to 0.1 ms
    assert before.speed_mm_s == pytest.approx(40, rel=0.02)
    assert after.speed_mm_s == pytest.approx(40, rel=0.02)


def test_a_run_up_without_room_is_left_out_and_said_with_its_place():
    board = board_of(part("J1", 10, 20, 10, 20, 60))
    made = sprayed(board, stroke((30, 30, 20), (80, 30, 20), lead_in_mm=15.0))
    (finding,) = made.findings
    assert finding.rule.id == "lead-in-blocked"
    assert str(finding.made_by) == "sequence[0]/line"
    assert finding.where == (30.0, 30.0, 20.0)
    np.testing.assert_allclose(made.items[0].tcp[-1], [30, 30, 20])


def test_strokes_that_meet_keep_the_jet_on():
    made = sprayed(board_of(), stroke((10, 30, 20), (35, 30, 20)), stroke((35, 30, 20), (35, 50, 20)))
    assert [type(item) for item in made.items] == [Transfer, SprayPass, SprayPass]


def test_turning_over_parks_calls_and_goes_around():
    board = board_of(part("J1", 45, 20, 10, 20, 60))
    made = sprayed(board, stroke((10, 30, 20), (35, 30, 20)))
    made.park(200.0, Source(0, motion="park"))
    (park,) = made.items[-1:]
    assert isinstance(park, Transfer)
    around = ways_over(board, "bottom").turn_over(made.ways, made.pose, 200.0, Source(1, motion="turn"))
    made.items.append(around)
    assert around.tcp[0, 2] == pytest.approx(110)
    assert around.tcp[-1, 2] == pytest.approx(-1.6 - 110)
    check_joined(made.items)
