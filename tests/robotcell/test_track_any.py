from typing import TypeAlias

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_programs import DOWN, program_of, programs
from tracked import moves_of

from programs import native
from programs.errors import ProgramError
from programs.program import Command, MoveTo, SetNozzle, TimedProgram
from robotcell.cell.load import read_cell
from robotcell.robot.robot import flange_poses
from robotcell.track import Terms, track
from specs.errors import JobError

Turn: TypeAlias = tuple[float, float, float, float]


def shrunk(program: TimedProgram) -> TimedProgram:
    """The same where a robot may reach it: over the board, the jet more or less down."""
    items = []
    for item in program.instructions:
        if isinstance(item, MoveTo):
            x, y, z = item.position
            w, i, j, k = np.array([0.0, 1.0, 0.0, 0.0]) + 0.15 * np.array(item.quaternion)
            length = float(np.sqrt(w * w + i * i + j * j + k * k))
            turn = (w / length, i / length, j / length, k / length)
            items.append(MoveTo(item.time_s, (80 + 0.1 * x, 50 + 0.1 * y, 90 + 0.05 * z), turn, 10.0, item.made_by))
        elif isinstance(item, Command) and item.keyword == "NOZZLE":
            items.append(Command(item.time_s, "NOZZLE", (item.arguments[0], "TOOL", "1"), item.made_by))
        else:
            items.append(item)
    return program_of(*items)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ur5e-bench", "gantry"])
@settings(max_examples=12)
@given(program=programs(), near=st.booleans())
def test_any_program_is_done_or_refused_with_reasons(name: str, program: TimedProgram, near: bool) -> None:
    loaded = read_cell(name)
    requested = shrunk(program) if near else program
    try:
        report = track(requested, loaded.cell, None, terms=Terms())
    except JobError:
        return
    if not report.possible:
        assert any(finding.severity == "error" for finding in report.findings)
        return
    moves = moves_of(report.program)
    assert report.joints.shape == (len(moves), loaded.cell.robot.dof)
    assert np.isfinite(report.joints).all()
    low = np.array([joint.lowest for joint in loaded.cell.robot.joints])
    high = np.array([joint.highest for joint in loaded.cell.robot.joints])
    assert ((report.joints >= low - 1e-6) & (report.joints <= high + 1e-6)).all()
    times = np.array([item.time_s for item in report.program.instructions])
    assert (np.diff(times) >= -1e-9).all()
    poses = loaded.cell.T_cell_base @ flange_poses(loaded.cell.robot, report.joints) @ loaded.cell.tools[0].T_flange_tcp
    places = (np.linalg.inv(loaded.cell.T_cell_board) @ poses)[:, :3, 3] * 1e3
    np.testing.assert_allclose(places, [move.position for move in moves], atol=1e-3)
    others = [item for item in report.program.instructions if not isinstance(item, MoveTo)]
    assert len(others) == sum(not isinstance(item, MoveTo) for item in requested.instructions)
    if not any(isinstance(item, Command) and item.keyword == "ENDREPEAT" for item in others):
        assert native.render(report.program)


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [0.0, 1e-8, 1e-4])
@pytest.mark.parametrize("turn", [(-1.0, 0.0, 0.0, 0.0), DOWN], ids=["turning", "along"])
def test_a_move_in_no_time_takes_the_time_that_the_joints_need(
    turn: tuple[float, float, float, float], seconds: float
) -> None:
    requested = program_of(
        MoveTo(0.0, (0.0, 0.0, 110.0), turn, 0.0, ""),
        MoveTo(seconds, (0.0, 0.0, 0.0), DOWN, 0.0, ""),
        SetNozzle(seconds, False, ""),
    )
    cell = read_cell("ur5e-bench").cell
    report = track(requested, cell, None)
    times = np.array([move.time_s for move in moves_of(report.program)])
    fastest = np.abs(np.diff(report.joints, axis=0)) / np.diff(times)[:, None]
    assert (fastest <= 1.03 * cell.robot.speed).all()
    arrives_s = float(times[np.isfinite(report.clock)][-1])
    assert SetNozzle(arrives_s, False, "") in report.program.instructions
    assert native.render(report.program)


@pytest.mark.slow
def test_poses_that_need_a_tilt_keep_it_when_others_are_tilted() -> None:
    """The end is out of reach of an upright tool; what stands near it is tilted because it collides."""
    requested = program_of(
        MoveTo(0.0, (0.0, 0.0, 110.0), DOWN, 0.0, ""), MoveTo(1.0, (-325.9, 0.0, 0.0), DOWN, 0.0, "")
    )
    report = track(requested, read_cell("ur5e-bench").cell, None)
    assert report.possible
    assert np.isfinite(report.joints).all()


def test_a_program_without_a_move_is_refused() -> None:
    with pytest.raises(ProgramError, match="no MOVE"):
        track(program_of(Command(0.0, "FUNCTION", ("clean",), "")), read_cell("gantry").cell, None)


def test_a_program_that_only_stands_still_is_done() -> None:
    report = track(
        program_of(MoveTo(0.0, (80.0, 50.0, 90.0), (0.0, 1.0, 0.0, 0.0), 0.0, "start")), read_cell("gantry").cell, None
    )
    assert np.isfinite(report.clock).sum() == 1
    assert report.joints.shape[1] == 5
    added_s = report.added.from_home + report.added.to_home
    assert report.program.totals.duration_s == pytest.approx(added_s, abs=1e-6)
