import dataclasses

import numpy as np
import pytest
from small_programs import program_of
from tracked import MADE_BY, line_program, moves_of, rates, reached_mm

from geometry.arrays import Indices
from programs import native
from programs.playback import playback
from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait
from robotcell.cell.cell import Cell
from robotcell.cell.load import read_cell
from robotcell.collision.clearance import Clearance
from robotcell.errors import CellError
from robotcell.motion.cell_queries import CellQueries
from robotcell.robot.robot import Body, Box, Joints, pose
from robotcell.track import CellReport, Terms, terms_of, track

ROUND = Terms(round_nozzles=frozenset({"ring60"}))
ARMS = ["ur5e-bench", "kr6-bench", "gantry"]


def cell_of(name: str) -> Cell:
    return read_cell(name).cell


def with_board(cell: Cell, *xyz: float, rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Cell:
    return dataclasses.replace(cell, T_cell_board=pose(xyz, (0, 0, 0)) @ cell.T_cell_board @ pose((0, 0, 0), rpy))


def rules(report: CellReport) -> set[str]:
    return {finding.rule.id for finding in report.findings}


def message(report: CellReport, rule: str) -> str:
    return next(finding.message for finding in report.findings if finding.rule.id == rule)


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_the_joints_bring_the_orifice_where_the_program_says(name: str) -> None:
    program = line_program()
    report = track(program, cell_of(name), None, terms=ROUND)
    assert report.possible
    assert rules(report) <= {"board-not-checked", "speed-not-held"}
    moves = moves_of(report.program)
    assert report.joints.shape == (len(moves), report.cell.robot.dof)
    places, jets = reached_mm(report)
    np.testing.assert_allclose(places, [move.position for move in moves], atol=1e-4)
    jets = jets[np.isfinite(report.clock)]
    np.testing.assert_allclose(jets, np.tile([0.0, 0.0, -1.0], (len(jets), 1)), atol=1e-6)


def test_asked_places_are_kept_and_others_lie_between_them() -> None:
    program = line_program()
    report = track(program, cell_of("ur5e-bench"), None, terms=ROUND)
    places = [move.position for move in moves_of(report.program)]
    at = 0
    for move in moves_of(program):
        at += next(index for index, place in enumerate(places[at:]) if np.allclose(place, move.position, atol=1e-5))
    others = [item for item in report.program.instructions if not isinstance(item, MoveTo)]
    requested = [item for item in program.instructions if not isinstance(item, MoveTo)]
    assert [dataclasses.replace(item, time_s=0.0) for item in others] == [
        dataclasses.replace(item, time_s=0.0) for item in requested
    ]


def test_the_clearance_is_measured_when_it_is_asked_for_and_once(monkeypatch: pytest.MonkeyPatch) -> None:
    measured, measure = list[int](), CellQueries.clearance

    def counted(queries: CellQueries, q: Joints, tool: Indices, placement: Indices) -> Clearance:
        measured.append(len(q))
        return measure(queries, q, tool, placement)

    monkeypatch.setattr(CellQueries, "clearance", counted)
    report = track(line_program(), cell_of("gantry"), None, terms=ROUND)
    assert measured == []
    assert len(report.clearance.distances) == len(report.clearance_at) > 0
    assert report.clearance is report.clearance
    assert measured == [len(report.clearance_at)]


def test_a_robot_that_is_quick_enough_keeps_the_programs_own_time() -> None:
    program = line_program(speed=20.0, accelerate=200.0)
    report = track(program, cell_of("kr6-bench"), None, terms=ROUND)
    added_s = report.added.from_home + report.added.to_home
    assert report.program.totals.duration_s - added_s == pytest.approx(program.totals.duration_s, abs=1e-6)


@pytest.mark.slow
def test_a_program_begins_and_ends_at_home_through_the_height_of_its_transfers() -> None:
    """A program that begins at the height at which it sprays as well: the way there leads down, and up again."""
    whole = line_program(speed=20.0, accelerate=200.0)
    low = MoveTo(0.0, (80.0, 50.0, 60.0), (0.0, 1.0, 0.0, 0.0), 0.0, "sequence[0]")
    begins_low = program_of(low, *(dataclasses.replace(i, time_s=i.time_s + 3.0) for i in whole.instructions))
    cell = cell_of("kr6-bench")
    for program, lifts in ((whole, 0), (begins_low, 1)):
        report = track(program, cell, None, terms=ROUND)
        np.testing.assert_allclose(report.joints[[0, -1]], [cell.home, cell.home], atol=1e-9)
        own = np.flatnonzero(np.isfinite(report.clock))
        assert report.corner[: own[0]].sum() == 1 + lifts
        assert report.program.instructions[-1].time_s == pytest.approx(report.program.totals.duration_s)
        moves = [item for item in report.program.instructions if isinstance(item, MoveTo)]
        assert moves[own[0]].time_s == pytest.approx(report.added.from_home)
        assert moves[-1].time_s - moves[own[-1]].time_s == pytest.approx(report.added.to_home)
        if lifts:
            assert moves[own[0] - 1].position[2] > 60.0
            up = moves[int(np.flatnonzero(report.corner[: own[0]])[-1])]
            highest = max(item.position[2] for item in program.instructions if isinstance(item, MoveTo))
            assert up.position == pytest.approx((80.0, 50.0, highest), abs=1e-3)
    assert "speed-not-held" not in rules(report)


def slow(cell: Cell, share: float) -> Cell:
    joints = tuple(
        dataclasses.replace(joint, speed=joint.speed * share, acceleration=joint.acceleration * share)
        for joint in cell.robot.joints
    )
    return dataclasses.replace(cell, robot=dataclasses.replace(cell.robot, joints=joints))


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.2, 0.05])
def test_a_slow_robot_takes_longer_keeps_its_limits_and_is_reported(share: float) -> None:
    program = line_program(speed=120.0)
    cell = slow(cell_of("ur5e-bench"), share)
    report = track(program, cell, None, terms=ROUND)
    assert report.program.totals.duration_s > program.totals.duration_s + 0.01
    speed, acceleration = rates(report)
    assert (np.abs(speed) <= np.array([joint.speed for joint in cell.robot.joints]) * 1.01).all()
    assert (np.abs(acceleration) <= np.array([joint.acceleration for joint in cell.robot.joints]) * 1.06).all()
    found = [finding for finding in report.findings if finding.rule.id == "speed-not-held"]
    assert found
    assert str(found[0].made_by) == MADE_BY
    assert found[0].severity == "warning"
    assert any(joint.name in found[0].message for joint in cell.robot.joints)


def test_the_jet_goes_on_and_off_at_the_same_places() -> None:
    program = line_program(speed=120.0)
    report = track(program, slow(cell_of("ur5e-bench"), 0.1), None, terms=ROUND)

    def switched(items: TimedProgram) -> np.ndarray:
        times = np.array([item.time_s for item in items.instructions if isinstance(item, SetNozzle)])
        return playback(items, times).tcp

    np.testing.assert_allclose(switched(report.program), switched(program), atol=1e-3)
    wait = next(item for item in report.program.instructions if isinstance(item, Wait))
    after = next(move for move in moves_of(report.program) if move.time_s > wait.time_s + 1e-9)
    assert after.time_s >= wait.time_s + 0.3 - 1e-6


def test_what_the_robot_does_is_a_sound_program() -> None:
    report = track(line_program(speed=120.0), slow(cell_of("ur5e-bench"), 0.1), None, terms=ROUND)
    text = native.render(report.program)
    assert native.render(native.parse(text)) == text
    litres = dict(report.program.totals.liquid_l)["clean"]
    assert litres == pytest.approx(report.program.totals.spray_s / report.requested.totals.spray_s)


@pytest.mark.slow
def test_the_same_input_gives_the_same_result() -> None:
    first, second = (track(line_program(), cell_of("ur5e-bench"), None, terms=ROUND) for _ in range(2))
    assert first.joints.tobytes() == second.joints.tobytes()
    assert first.program == second.program
    assert first.findings == second.findings


@pytest.mark.slow
def test_cell_and_board_moved_together_change_nothing() -> None:
    cell = cell_of("ur5e-bench")
    moved = pose((3.0, -2.0, 0.5), (0.0, 0.0, 0.7))
    fixtures = tuple(dataclasses.replace(body, T_carrier_shape=moved @ body.T_carrier_shape) for body in cell.fixtures)
    other = dataclasses.replace(
        cell, T_cell_base=moved @ cell.T_cell_base, T_cell_board=moved @ cell.T_cell_board, fixtures=fixtures
    )
    one, two = (track(line_program(), each, None, terms=ROUND) for each in (cell, other))
    np.testing.assert_allclose(two.joints, one.joints, atol=1e-8)


def test_a_nozzle_that_is_not_round_keeps_its_azimuth() -> None:
    report = track(line_program(nozzle="knife", tool=2), cell_of("ur5e-bench"), None, terms=ROUND)
    spraying = False
    checked = 0
    for item in report.program.instructions:
        if isinstance(item, SetNozzle):
            spraying = item.spraying
        elif isinstance(item, MoveTo) and spraying:
            assert item.quaternion == pytest.approx((0.0, 1.0, 0.0, 0.0), abs=1e-7)
            checked += 1
    assert checked > 100


def test_a_change_of_tool_is_a_joint_move_at_rest() -> None:
    first = line_program()
    end = first.instructions[-1].time_s
    back = [
        Command(end, "NOZZLE", ("knife", "TOOL", "2"), "sequence[1]"),
        MoveTo(end + 1.0, (40.0, 40.0, 110.0), (0.0, 1.0, 0.0, 0.0), 40.0, "sequence[1]"),
    ]
    program = dataclasses.replace(
        first,
        instructions=(*first.instructions, *back),
        totals=dataclasses.replace(first.totals, duration_s=end + 1.0, moves=first.totals.moves + 1),
    )
    report = track(program, cell_of("ur5e-bench"), None, terms=ROUND)
    assert report.possible
    change = next(
        index
        for index, item in enumerate(report.program.instructions)
        if isinstance(item, Command) and item.arguments[0] == "knife"
    )
    moves_before = sum(isinstance(item, MoveTo) for item in report.program.instructions[:change])
    np.testing.assert_allclose(report.joints[moves_before], report.joints[moves_before - 1], atol=1e-9)
    steps = np.abs(np.diff(report.joints, axis=0)).max()
    assert steps < 0.25
    assert native.render(report.program)


@pytest.mark.slow
def test_too_far_says_how_far_and_where_the_board_would_have_to_be() -> None:
    report = track(line_program(), with_board(cell_of("ur5e-bench"), 0.5, 0.0, 0.0), None, terms=ROUND)
    assert not report.possible
    assert report.program is report.requested
    worst = next(finding for finding in report.findings if finding.rule.id == "out-of-reach")
    assert worst.severity == "error"
    assert worst.where is not None
    assert "nearer to the robot" in worst.message
    assert "board moved by -" in message(report, "cell-remedy")


@pytest.mark.slow
def test_a_wall_in_the_way_is_named() -> None:
    cell = cell_of("ur5e-bench")
    wall = Body("wall", Box((0.02, 0.6, 0.6)), pose((0.44, 0.0, 0.47), (0, 0, 0)))
    report = track(line_program(), dataclasses.replace(cell, fixtures=(*cell.fixtures, wall)), None, terms=ROUND)
    assert "wall" in message(report, "collision")
    assert any(finding.severity == "error" for finding in report.findings)


@pytest.mark.slow
def test_a_tcp_turned_by_half_a_turn_is_recognised() -> None:
    cell = cell_of("ur5e-bench")
    tools = tuple(
        dataclasses.replace(tool, T_flange_tcp=tool.T_flange_tcp @ pose((0, 0, 0), (np.pi, 0, 0)))
        for tool in cell.tools
    )
    report = track(line_program(), dataclasses.replace(cell, tools=tools), None, terms=ROUND)
    assert "with the TCP turned by 180 degrees" in message(report, "cell-remedy")


@pytest.mark.slow
def test_one_tcp_of_two_turned_by_half_a_turn_is_recognised() -> None:
    cell = cell_of("ur5e-bench")
    first, *others = cell.tools
    turned = dataclasses.replace(first, T_flange_tcp=first.T_flange_tcp @ pose((0, 0, 0), (np.pi, 0, 0)))
    plain = line_program()
    change = Command(plain.totals.duration_s, "NOZZLE", ("knife", "TOOL", "2"), "s")
    last = moves_of(plain)[-1]
    again = [dataclasses.replace(last, time_s=last.time_s + k, position=(20.0 + 10 * k, 20.0, 60.0)) for k in (1, 2)]
    program = dataclasses.replace(plain, instructions=(*plain.instructions, change, *again))
    report = track(program, dataclasses.replace(cell, tools=(turned, *others)), None, terms=ROUND)
    assert "with the TCP of tool 1 (cone) turned by 180 degrees" in message(report, "cell-remedy")
    assert message(report, "tcp-turned").startswith("the jet of cone points back at the flange")


@pytest.mark.slow
def test_metres_for_millimetres_are_recognised() -> None:
    cell = cell_of("ur5e-bench")
    wrong = cell.T_cell_board.copy()
    wrong[:3, 3] *= 1e-3
    report = track(line_program(), dataclasses.replace(cell, T_cell_board=wrong), None, terms=ROUND)
    assert "metres were written for millimetres" in message(report, "cell-remedy")


@pytest.mark.slow
def test_a_board_upside_down_is_recognised() -> None:
    report = track(
        line_program(), with_board(cell_of("ur5e-bench"), 0.0, 0.1, 0.0, rpy=(np.pi, 0, 0)), None, terms=ROUND
    )
    assert "turned over" in message(report, "cell-remedy")


@pytest.mark.slow
def test_joint_limits_are_told_apart_from_reach() -> None:
    cell = cell_of("ur5e-bench")
    joints = list(cell.robot.joints)
    joints[2] = dataclasses.replace(joints[2], lowest=-0.3, highest=0.3)
    robot = dataclasses.replace(cell.robot, joints=tuple(joints))
    report = track(line_program(), dataclasses.replace(cell, robot=robot), None, terms=ROUND)
    found = message(report, "joint-limit")
    assert joints[2].name in found
    assert "degrees" in found


def test_a_tool_that_the_cell_does_not_have_is_an_error() -> None:
    with pytest.raises(CellError, match="needs tool 7"):
        track(line_program(tool=7), cell_of("ur5e-bench"), None)


def test_a_board_that_is_turned_over_needs_a_place() -> None:
    program = line_program()
    flip = Command(program.instructions[-1].time_s, "CALL", ("flip_to_bottom",), "sequence[1]/turn")
    with pytest.raises(CellError, match=r"placements\.flip_to_bottom"):
        track(dataclasses.replace(program, instructions=(*program.instructions, flip)), cell_of("ur5e-bench"), None)


def test_terms_come_from_the_cells_file() -> None:
    loaded = read_cell("ur5e-bench")
    terms = terms_of(loaded, tilt_band=0.1)
    assert "ring60" in terms.round_nozzles
    assert "knife" not in terms.round_nozzles
    assert terms.tilt_band == 0.1


def test_without_a_board_the_report_says_so() -> None:
    report = track(line_program(), cell_of("ur5e-bench"), None, terms=ROUND)
    assert "--board" in message(report, "board-not-checked")


@pytest.mark.slow
def test_a_collision_between_two_samples_alone_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """No sample touches the sheet; the way from one to the next does."""
    program, cell = line_program(), cell_of("gantry")
    done = track(program, cell, None, terms=ROUND)
    assert "collision" not in rules(done)
    monkeypatch.setattr(CellQueries, "collide", lambda *_: np.zeros(len(_[1]), dtype=np.bool_))
    monkeypatch.setattr(CellQueries, "first_touch", lambda *_: None)
    wall = Body("sheet", Box((0.02, 0.6, 0.6)), pose((-0.03, 0.0, 0.47), (0, 0, 0)))
    report = track(program, dataclasses.replace(cell, fixtures=(*cell.fixtures, wall)), None, terms=ROUND)
    assert "sheet" in message(report, "collision")
