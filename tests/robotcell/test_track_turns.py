"""Turning boards over, repeating, multi-turn joints, tilting: what a robot has to do besides going along."""

import dataclasses
import math

import numpy as np
import pytest
from small_programs import program_of
from tracked import line_program, moves_of, reached_mm, tilted

from programs.errors import ProgramError
from programs.program import Command, Instruction, MoveTo, SetNozzle, TimedProgram
from robotcell.cell.cell import Cell
from robotcell.cell.load import read_cell
from robotcell.robot.robot import Body, Box, Capsule, Joints, flange_poses, pose
from robotcell.track import CellReport, Terms, track

ROUND = Terms(round_nozzles=frozenset({"ring60"}))


def tilting(azimuth: float, tilt: float = math.radians(35)) -> tuple[float, float, float, float]:
    """Jet tilted towards a direction, the tool's azimuth kept: down, then tipped about a level axis."""
    x, y = -math.sin(azimuth), math.cos(azimuth)  # axis of the tip: at right angles to the direction
    half = -tilt / 2
    w, i, j = math.cos(half), x * math.sin(half), y * math.sin(half)
    # (w, i, j, 0) times the half turn about x (0, 1, 0, 0)
    return (-i, w, 0.0, -j)


def laps(count: int, strokes: int = 1) -> TimedProgram:
    """Round a circle with the jet tilted inwards, lap after lap with the jet on, in one stroke or several."""
    found: list[Instruction] = [Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "sequence[0]")]
    now = 0.0
    for stroke in range(strokes):
        if stroke:
            found.append(SetNozzle(now, False, "sequence[0]/around/U1"))
            top = next(item for item in reversed(found) if isinstance(item, MoveTo))
            for height in (*np.linspace(0, 30, 16)[1:], *np.linspace(30, 0, 16)[1:]):
                now += 0.05
                x, y, z = top.position
                found.append(
                    MoveTo(now, (x, y, z + float(height)), top.quaternion, 40.0, "sequence[0]/around/U1/transfer")
                )
        for step in range(count * 120 + 1):
            angle = 2 * math.pi * step / 120
            place = (80 + 20 * math.cos(angle), 50 + 20 * math.sin(angle), 50.0)
            found.append(MoveTo(now, place, tilting(angle + math.pi), 21.0, "sequence[0]/around/U1"))
            if step == 0:
                found.append(SetNozzle(now, True, "sequence[0]/around/U1"))
            now += 0.05
        now -= 0.05
    found.append(SetNozzle(now, False, "sequence[0]/around/U1"))
    return program_of(*found)


def limited(cell: Cell, name: str, turns: float) -> Cell:
    joints = tuple(
        dataclasses.replace(joint, lowest=-2 * math.pi * turns, highest=2 * math.pi * turns)
        if joint.name == name
        else joint
        for joint in cell.robot.joints
    )
    return dataclasses.replace(cell, robot=dataclasses.replace(cell.robot, joints=joints))


def test_the_helper_leans_the_jet_where_it_says() -> None:
    w, x, y, z = tilting(0.3)
    jet = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
    across = math.sin(math.radians(35))
    assert jet == pytest.approx((across * math.cos(0.3), across * math.sin(0.3), -math.cos(math.radians(35))))


@pytest.mark.slow
def test_an_arm_goes_round_without_winding_up_where_the_nozzle_is_round() -> None:
    report = track(laps(4), read_cell("ur5e-bench").cell, None, terms=ROUND)
    assert report.possible
    assert np.ptp(report.joints, axis=0).max() < 2 * math.pi


def test_a_gantry_that_turns_without_end_turns_with_each_lap() -> None:
    cell = read_cell("gantry").cell
    report = track(laps(3), cell, None, terms=ROUND)
    assert report.possible
    turning = [joint.name for joint in cell.robot.joints].index("C")
    on_path = np.isfinite(report.clock)
    assert np.ptp(report.joints[on_path, turning]) == pytest.approx(3 * 2 * math.pi, abs=0.3)


@pytest.mark.slow
def test_too_many_laps_with_the_jet_on_turn_over_the_vertical_within_the_laps() -> None:
    """Four turns of C where two are allowed; the orifice stays on its circle, and no joint jumps."""
    report = track(laps(4), limited(read_cell("gantry").cell, "C", 1.0), None, terms=ROUND)
    assert report.possible, report.findings
    assert np.abs(report.joints[:, 3]).max() <= 2.0 * math.pi + 1e-9
    own = report.joints[report.clearance_at]
    assert np.abs(np.diff(own[:, 3:], axis=0)).max() <= math.radians(15.0)
    tips = flange_poses(report.cell.robot, own) @ report.cell.tools[0].T_flange_tcp
    places = 1e3 * (np.linalg.inv(report.cell.T_cell_board) @ report.cell.T_cell_base @ tips)[:, :3, 3]
    apart = np.hypot(places[:, 0] - 80.0, places[:, 1] - 50.0)
    assert 20.0 * math.cos(math.pi / 120) - 1e-3 <= apart.min()
    assert apart.max() <= 20.0 + 1e-3
    (found,) = (finding for finding in report.findings if finding.rule.id == "jet-tilted")
    assert str(found.made_by) == "sequence[0]/around/U1"
    assert "or the hose would wind up" in found.message


@pytest.mark.slow
def test_laps_with_the_jet_on_cannot_be_done_with_a_head_that_hardly_turns_half_way() -> None:
    report = track(laps(1), limited(read_cell("gantry").cell, "C", 0.255), None, terms=ROUND)
    assert not report.possible
    found = next(finding for finding in report.findings if finding.rule.id == "configuration-jump")
    assert found.severity == "error"
    assert str(found.made_by) == "sequence[0]/around/U1"


@pytest.mark.slow
def test_a_limited_head_unwinds_while_the_jet_is_off() -> None:
    cell = limited(read_cell("gantry").cell, "C", 1.0)
    report = track(laps(1, strokes=4), cell, None, terms=ROUND)
    assert report.possible, report.findings
    turning = [joint.name for joint in cell.robot.joints].index("C")
    assert np.abs(report.joints[:, turning]).max() <= 2 * math.pi + 1e-6
    spraying = False
    before: np.ndarray | None = None
    for item, q in zip(moves_with_jet(report.program), report.joints, strict=True):
        if spraying and before is not None:
            assert np.abs(q - before).max() < 0.3  # nothing jumps while it sprays
        spraying, before = item, q


def moves_with_jet(program: TimedProgram) -> list[bool]:
    """Whether the jet is on after each move."""
    found: list[bool] = []
    on = False
    for item in program.instructions:
        if isinstance(item, SetNozzle):
            on = item.spraying
            if found:
                found[-1] = on
        elif isinstance(item, MoveTo):
            found.append(on)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ur5e-bench", "gantry"])
def test_a_loop_ends_with_all_joints_where_it_begins(name: str) -> None:
    """The controller goes from the end of a turn of the loop to its begin in no time."""
    program = line_program()
    end = program.instructions[-1].time_s
    x, y, z = moves_of(program)[0].position
    last = moves_of(program)[-1].position
    back: list[Instruction] = []
    for share in np.linspace(0, 1, 30)[1:]:
        place = tuple(float(a + share * (b - a)) for a, b in zip(last, (x, y, z), strict=True))
        back.append(MoveTo(end + share, (place[0], place[1], place[2]), (0.0, 1.0, 0.0, 0.0), 60.0, "sequence[0]/park"))
    begin = Command(0.0, "REPEAT", ("4", "UNTIL", "resistivity_mohm_cm", ">=", "1.0"), "sequence[0]")
    instructions = list(program.instructions)
    first = next(index for index, item in enumerate(instructions) if isinstance(item, MoveTo))
    looped = program_of(
        *instructions[: first + 1],
        begin,
        *instructions[first + 1 :],
        *back,
        Command(end + 1.0, "ENDREPEAT", (), "sequence[0]"),
    )
    report = track(looped, read_cell(name).cell, None, terms=ROUND)
    begun, ended = loop_joints(report)
    assert np.abs(begun - report.joints[0]).max() > 0.1  # home is elsewhere
    np.testing.assert_allclose(ended, begun, atol=1e-6)


def loop_joints(report: CellReport) -> tuple[Joints, Joints]:
    """The joints (dof,) where a program's loop begins, and where it ends."""
    moves = np.cumsum([isinstance(item, MoveTo) for item in report.program.instructions])
    words = {item.keyword: row for row, item in enumerate(report.program.instructions) if isinstance(item, Command)}
    return report.joints[moves[words["REPEAT"]] - 1], report.joints[moves[words["ENDREPEAT"]] - 1]


def test_a_loop_that_begins_between_two_choices_of_the_configuration_is_closed() -> None:
    """A lap with the jet tilted turns the tool; the loop begins on the way there, where the robot does not rest."""
    nozzle, *lap = laps(1).instructions
    x, y, z = next(item for item in lap if isinstance(item, MoveTo)).position
    down = (0.0, 1.0, 0.0, 0.0)
    before = [MoveTo(0.02 * k, (x, y + 0.5 * k, z + 20.0), down, 40.0, "sequence[0]/park") for k in range(4)]
    top = before[-1]
    lap = [dataclasses.replace(item, time_s=item.time_s + 1.0) for item in lap]
    end = lap[-1].time_s + 1.0
    program = program_of(
        nozzle,
        *before,
        Command(top.time_s, "REPEAT", ("4", "UNTIL", "resistivity_mohm_cm", ">=", "1.0"), "sequence[0]"),
        *lap,
        dataclasses.replace(top, time_s=end),
        Command(end, "ENDREPEAT", (), "sequence[0]"),
        MoveTo(end + 0.5, (x + 30.0, y, z + 20.0), down, 60.0, "sequence[0]/park"),
    )
    begun, ended = loop_joints(track(program, read_cell("kr6-bench").cell, None, terms=ROUND))
    np.testing.assert_allclose(ended, begun, atol=1e-6)


def test_a_board_that_is_turned_over_is_sprayed_where_it_then_is() -> None:
    cell = read_cell("ur5e-bench").cell
    first = line_program()
    end = first.instructions[-1].time_s
    below = -61.6
    around = [(40.0, 40.0, 110.0), (40.0, 180.0, 110.0), (40.0, 180.0, -110.0), (40.0, 40.0, -110.0)]
    turning: list[Instruction] = [Command(end, "CALL", ("flip_to_bottom",), "sequence[1]/turn")]
    turning += [
        MoveTo(
            end + 1.0 + step,
            place,
            (1.0, 0.0, 0.0, 0.0) if step > 1 else (0.0, 1.0, 0.0, 0.0),
            100.0,
            "sequence[1]/turn",
        )
        for step, place in enumerate(around)
    ]
    now = end + 4.0
    spray = [
        MoveTo(now + 0.5 + 0.1 * k, (40.0 + k, 40.0, below), (1.0, 0, 0, 0), 50.0, "sequence[1]/sweep")
        for k in range(9)
    ]
    program = program_of(*first.instructions, *turning, *spray)
    turned = cell.T_cell_board @ pose((0.0, 0.09, -0.0016), (math.pi, 0.0, 0.0))
    terms = dataclasses.replace(ROUND, placements={"flip_to_bottom": turned})
    report = track(program, cell, None, terms=terms)
    assert report.possible, report.findings
    from robotcell.robot.robot import flange_poses

    last = report.joints[np.isfinite(report.clock)][-1:]
    tip = (cell.T_cell_base @ flange_poses(cell.robot, last) @ cell.tools[0].T_flange_tcp)[0]
    np.testing.assert_allclose(tip[:3, 3], (turned @ [0.048, 0.04, below * 1e-3, 1.0])[:3], atol=1e-6)
    assert tip[2, 2] == pytest.approx(-1.0, abs=1e-6)  # down onto the side that is up now
    assert tip[2, 3] > cell.T_cell_board[2, 3]


def with_straight_lance(cell: Cell) -> Cell:
    """A cone that cannot be turned out of the way about its jet."""
    cone, *others = cell.tools
    lance = Body("lance", Capsule(0.009, 0.115), pose((0, 0, 0.0975), (0, 0, 0)))
    nozzle = Body("nozzle", Capsule(0.007, 0.018), pose((0, 0, 0.164), (0, 0, 0)))
    kept = [body for body in cone.bodies if body.name in ("changer", "hose")]
    straight = dataclasses.replace(cone, T_flange_tcp=pose((0, 0, 0.18), (0, 0, 0)), bodies=(*kept, lance, nozzle))
    return dataclasses.replace(cell, tools=(straight, *others))


def granting(program: TimedProgram, degrees: str) -> TimedProgram:
    grant = Command(0.0, "SET", ("tilt_band_deg", degrees), "sequence[0]")
    return dataclasses.replace(program, instructions=(grant, *program.instructions))


@pytest.mark.parametrize("degrees", ["wide", "-1", "46"])
def test_a_tilt_band_that_is_none_is_refused(degrees: str) -> None:
    with pytest.raises(ProgramError, match="SET tilt_band_deg needs a number from 0 to 45"):
        track(granting(line_program(), degrees), read_cell("ur5e-bench").cell, None, terms=ROUND)


@pytest.mark.slow
def test_the_jet_leans_within_the_band_only_where_it_must() -> None:
    cell = read_cell("kr6-bench").cell
    blocked = Body("post", Box((0.006, 0.012, 0.19)), cell.T_cell_board @ pose((0.05, -0.015, 0.125), (0, 0, 0)))
    cell = with_straight_lance(dataclasses.replace(cell, fixtures=(*cell.fixtures, blocked)))
    straight = track(line_program(), cell, None, terms=ROUND)
    assert any(finding.rule.id == "collision" for finding in straight.findings)
    tilted_ = track(line_program(), cell, None, terms=dataclasses.replace(ROUND, tilt_band=math.radians(20)))
    assert not any(finding.rule.id == "collision" for finding in tilted_.findings), tilted_.findings
    granted = granting(line_program(), "20.000")
    np.testing.assert_array_equal(track(granted, cell, None, terms=ROUND).joints, tilted_.joints)
    found = next(finding for finding in tilted_.findings if finding.rule.id == "jet-tilted")
    assert "degrees" in found.message
    jets = np.array([move.quaternion for move in moves_of(tilted_.program)])
    tilt = np.degrees(np.arccos(np.clip(2 * (jets[:, 1] ** 2 + jets[:, 2] ** 2) - 1, -1, 1)))
    assert tilt.max() <= 41.0
    assert (tilt < 0.1).any()


@pytest.mark.parametrize("beside_deg", [0.1, 2.0])
def test_a_jet_that_is_off_may_pass_close_by_the_axis_that_turns_it(beside_deg: float) -> None:
    """A gantry's C would have to make half a turn at once there."""
    begin, end = tilted(20.0), tilted(20.0, 180.0 - beside_deg)
    program = program_of(
        Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), ""),
        MoveTo(0.0, (0.0, 0.0, 60.0), begin, 0.0, ""),
        SetNozzle(0.0, True, ""),
        MoveTo(1.0, (20.0, 0.0, 60.0), begin, 20.0, ""),
        SetNozzle(1.0, False, ""),
        MoveTo(2.0, (20.0, 20.0, 60.0), end, 20.0, ""),
        SetNozzle(2.0, True, ""),
        MoveTo(3.0, (0.0, 20.0, 60.0), end, 20.0, ""),
        SetNozzle(3.0, False, ""),
    )
    report = track(program, read_cell("gantry").cell, None, terms=ROUND)
    assert report.possible
    places, jets = reached_mm(report)
    sprayed = [at for at, on in enumerate(moves_with_jet(report.program)) if on]
    assert len(sprayed) > 10
    np.testing.assert_allclose(places[sprayed], [moves_of(report.program)[at].position for at in sprayed], atol=1e-4)
    np.testing.assert_allclose(np.degrees(np.arccos(-jets[sprayed, 2])), 20.0, atol=0.01)
