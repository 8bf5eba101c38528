"""Times of candidates on a robot: exact where they are analysed, estimated elsewhere."""

from dataclasses import replace
from pathlib import Path

import pytest

from boards.load import load_board
from cleaning.parameters.load import load_parameters
from cleaning.prepared_board import PreparedBoard, prepare
from recipes.load import parse_recipe, recipe_library
from robotcell.cell.load import LoadedCell, hold_board, read_cell
from rulesengine.planning import cell_plan
from rulesengine.planning.cell_plan import plan_for_cell
from rulesengine.planning.pipeline import run
from rulesengine.tuning.trial.outcome import ProgramTimes, robot_ratios
from rulesengine.tuning.trial.record import MemoryStore
from rulesengine.tuning.trial.trial_runner import TrialRunner
from specs.errors import JobError

FILE = recipe_library()["smt-aqueous"].with_name("own.yaml")
TEXT = """recipe: short
extends: smt-aqueous
sequence:
  - {function: clean, nozzle: ring60, paths: [around]}
"""
SLOWER = "templates:\n  around: {speed_mm_s: 20}\n"
A, B, NEW = ("sequence[0]", "around"), ("sequence[0]", "sweep"), ("sequence[1]", "edge")


@pytest.fixture(scope="module")
def prepared() -> PreparedBoard:
    return prepare(load_board(Path("tiny")), load_parameters(), lambda *_: None)


def slow_cell(prepared: PreparedBoard, away_m: float = 0.0) -> LoadedCell:
    """A robot that accelerates less than the recipe allows, and its board perhaps out of its reach."""
    loaded = hold_board(read_cell("kr6-bench"), prepared.board)
    joints = tuple(replace(joint, acceleration=0.25 * joint.acceleration) for joint in loaded.cell.robot.joints)
    place = loaded.cell.T_cell_board.copy()
    place[0, 3] += away_m
    robot = replace(loaded.cell.robot, joints=joints)
    return replace(loaded, cell=replace(loaded.cell, robot=robot, T_cell_board=place))


def test_the_recipe_that_was_compared_takes_what_its_robot_takes() -> None:
    free = ProgramTimes(100.0, 4.0, {A: 40.0, B: 20.0})
    robot = ProgramTimes(150.0, 6.0, {A: 70.0, B: 20.0})
    assert robot_ratios(free, robot).estimate(free) == robot


def test_each_template_takes_as_much_longer_as_it_did() -> None:
    ratios = robot_ratios(ProgramTimes(100.0, 4.0, {A: 40.0, B: 20.0}), ProgramTimes(150.0, 6.0, {A: 70.0, B: 20.0}))
    found = ratios.estimate(ProgramTimes(90.0, 4.0, {A: 20.0, B: 20.0, NEW: 10.0}))
    assert found.sprayed == pytest.approx({A: 35.0, B: 20.0, NEW: 15.0})
    assert found.seconds == pytest.approx(70.0 + 1.5 * 40.0)
    assert found.litres == pytest.approx(4.0 * 70.0 / 50.0)


def test_without_a_cell_times_are_those_of_the_plan(prepared: PreparedBoard) -> None:
    runner = TrialRunner(FILE, prepared, "clean", 4)
    candidate, planned = runner.candidate(TEXT), run(parse_recipe(TEXT, file=FILE), prepared.board)
    assert candidate is not None
    assert candidate.seconds == round(planned.program.totals.duration_s, 3)
    assert runner.robot is None


@pytest.mark.slow
def test_what_is_analysed_is_planned_for_the_robot_and_a_candidate_is_estimated_well(
    prepared: PreparedBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("coal")
    cell, store = slow_cell(prepared), MemoryStore()
    runner = TrialRunner(FILE, prepared, "clean", 4, cell=cell)
    runner.keep_in(store)
    first = runner.first(TEXT)
    planned = plan_for_cell(run(parse_recipe(TEXT, file=FILE), prepared.board), cell)
    assert planned.robot is not None
    assert planned.robot.planned_s > 1.05 * planned.robot.free_s  # else this test would show nothing
    assert first.seconds == round(planned.robot.robot_s, 3)
    estimate = runner.candidate(TEXT + SLOWER)
    exact = runner.outcome(TEXT + SLOWER)
    assert estimate is not None
    assert exact is not None
    assert estimate.seconds == pytest.approx(exact.seconds, rel=0.1)
    again = runner.candidate(TEXT + SLOWER)
    assert again is not None
    assert again.seconds == exact.seconds

    def refuse(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr(cell_plan, "plan_for_cell", refuse)  # what an earlier tuning planned is not planned again
    resumed = TrialRunner(FILE, prepared, "clean", 4, cell=cell)
    resumed.keep_in(store)
    assert resumed.first(TEXT).figures == first.figures
    assert resumed.candidate(TEXT + SLOWER) == estimate
    restored = resumed.outcome(TEXT + SLOWER)
    assert restored is not None
    assert restored.figures == exact.figures
    assert resumed.candidate(TEXT + SLOWER) == again


def test_what_the_robot_cannot_carry_out_is_no_candidate(prepared: PreparedBoard) -> None:
    pytest.importorskip("coal")
    store, cell = MemoryStore(), slow_cell(prepared, away_m=5.0)
    planned, runner = (TrialRunner(FILE, prepared, "clean", 4, cell=cell) for _ in range(2))
    for each in (planned, runner):  # then by the record
        each.keep_in(store)
        with pytest.raises(JobError, match=r"cannot carry it out: .*kr6-bench cannot carry out the program"):
            each.first(TEXT)
    assert runner.outcome(TEXT) is None
    assert runner.candidate(TEXT) is None
    assert runner.robot is not None
    assert runner.robot.infeasible == 1
    assert runner.used == 0
