from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from brief_recipe import BRIEF

from boards.load import load_board
from programs import native
from programs.program import MoveTo
from robotcell.cell.load import LoadedCell, hold_board, read_cell
from robotcell.track import terms_of, track
from rulesengine.planning.cell_plan import plan_for_cell
from rulesengine.planning.pipeline import Run, run
from specs.finding_rules import ROBOT_LIMITS


@pytest.fixture(scope="module")
def tiny() -> Run:
    return run(BRIEF, load_board(Path("tiny")))


def slower(loaded: LoadedCell, share: float) -> LoadedCell:
    """The same cell with a robot that accelerates less."""
    joints = tuple(replace(joint, acceleration=share * joint.acceleration) for joint in loaded.cell.robot.joints)
    return replace(loaded, cell=replace(loaded.cell, robot=replace(loaded.cell.robot, joints=joints)))


@pytest.mark.slow
def test_the_planned_time_is_the_robots(tiny: Run) -> None:
    pytest.importorskip("coal")
    cell = slower(hold_board(read_cell("kr6-bench"), tiny.board), 0.25)
    planned = plan_for_cell(tiny, cell)
    timing = planned.robot
    assert timing is not None
    assert timing.planned_s > 1.05 * timing.free_s  # else this test would show nothing
    assert timing.free_s == tiny.program.totals.duration_s
    assert sum(seconds for _, seconds in timing.price_s) == pytest.approx(timing.planned_s - timing.free_s, abs=0.01)
    report = track(planned.program, cell.cell, tiny.board, terms=terms_of(cell))
    added = report.added.from_home + report.added.tool_changes + report.added.to_home
    assert report.program.totals.duration_s - added <= 1.03 * planned.program.totals.duration_s
    assert [each.severity for each in planned.findings if each.rule == ROBOT_LIMITS] == ["info"]
    assert _path_of(planned) == pytest.approx(_path_of(tiny), rel=1e-3)
    again = native.parse(native.render(planned.program))
    assert again.origin.cell == "kr6-bench"
    assert again.totals.spray_s > tiny.program.totals.spray_s  # a slower robot gives more dose


@pytest.mark.slow
def test_a_robot_that_cannot_carry_it_out_leaves_the_times(tiny: Run) -> None:
    pytest.importorskip("coal")
    loaded = hold_board(read_cell("ur5e-bench"), tiny.board)
    away = loaded.cell.T_cell_board.copy()
    away[0, 3] += 5.0
    planned = plan_for_cell(tiny, replace(loaded, cell=replace(loaded.cell, T_cell_board=away)))
    assert native.render(planned.program) == native.render(tiny.program)
    assert planned.robot is None
    found = [each for each in planned.findings if each.rule == ROBOT_LIMITS]
    assert [each.severity for each in found] == ["warning"]
    assert "cannot carry out" in found[0].message


def _path_of(done: Run) -> float:
    places = np.array([item.position for item in done.program.instructions if isinstance(item, MoveTo)])
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
