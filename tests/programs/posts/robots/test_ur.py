import math
import re
from dataclasses import replace
from itertools import pairwise

import pytest
from installations import WASH, small_cell
from robot_programs import PROGRAMS, joints_of
from robot_steps import line, pose, program, turn

from programs.errors import ProgramError
from programs.export import export
from programs.motion.installation import Installation
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import Event, Line, MotionProgram, Reach, Step, UseBoard, UseTool
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import IDENTITY
from programs.posts.proving.compare import compare
from programs.posts.robots.ur import DIALECT
from programs.posts.robots.ur_watcher import QUEUE

READY: tuple[Step, ...] = (UseBoard("", IDENTITY, ""), UseTool(1, "ring60", "s"), Reach(pose(0), (), "s"))


def written(motion: MotionProgram, cell: Installation | None = None) -> list[str]:
    (text,) = DIALECT.render(lower(motion, DIALECT.capability), cell or small_cell("universal-robots")).values()
    return [each.strip() for each in text.splitlines()]


def statements(lines: list[str], *words: str) -> list[str]:
    """Of the functions: not the one that raises the orifice first."""
    return [each for each in lines if each.startswith(words) and "p_start" not in each.removeprefix("if ")[:16]]


def test_the_example_of_the_four_dialects_in_metres_from_the_start() -> None:
    """On 8 mm after the start, off 8 mm before the end, 40 ms to open and 20 ms to shut, 100 mm/s, 100 mm."""
    stroke = line(pose(0), pose(100), 100.0)
    requests = [SwitchRequest(3, 0.08, True, "ring60", "s"), SwitchRequest(3, 0.92, False, "ring60", "s")]
    steps, _ = open_valves((*READY, stroke), requests, small_cell("universal-robots"))
    lines = written(program(*steps))
    ends = "p[0,0,0.05,3.141593,0,0], p[0.1,0,0.05,3.141593,0,0]"
    assert statements(lines, "arm(", "movel(", "settle()") == [
        f"arm({ends}, 0.004, 0, 1, 1)",
        f"arm({ends}, 0.09, 0, 1, 0)",
        "movel(pose_trans(board, p[0.1,0,0.05,3.141593,0,0]), a=1.2, v=0.1, r=0)",
        "settle()",
    ]


def test_a_turn_on_the_spot_is_given_its_time() -> None:
    lines = written(program(*READY, turn(pose(0), math.pi / 2, 1.0)))
    (move,) = statements(lines, "movel(")
    assert move.endswith("a=1.2, t=1.000, r=0)")


def test_no_output_waits_on_a_way_whose_ends_are_written_alike() -> None:
    """The thread would have no direction in which to measure the way done."""
    event = Event(WASH, 1.0, "start", 0.0002, 0.0, 0.5, 2e-5, 10.0, "s")
    lines = written(program(*READY, line(pose(0), pose(0.0004), 10.0, events=(event,))))
    assert statements(lines, "arm(p", "set_out(0", "movel(", "settle()")[2] == "set_out(0, 1, 1)"
    assert not statements(lines, "arm(p", "settle()")


def test_an_output_during_a_turn_on_the_spot_divides_it() -> None:
    steps, _ = open_valves(
        (*READY, turn(pose(0), math.pi / 2, 1.0)),
        [SwitchRequest(3, 0.54, True, "ring60", "s")],
        small_cell("universal-robots"),
    )
    _, _, _, *moves = statements(written(program(*steps)), "movel(", "set_out(0")  # the first shut the valves
    assert [each[:8] for each in moves] == ["set_out(", "movel(po", "set_out(", "movel(po"]


@pytest.mark.slow
@pytest.mark.parametrize("made", list(PROGRAMS))
def test_blends_never_meet(made: str) -> None:
    motion = make_motion(PROGRAMS[made](), small_cell("universal-robots"))
    lowered = lower(motion, DIALECT.capability)
    texts = DIALECT.render(lowered, small_cell("universal-robots")).values()
    entry = re.compile(r"^( *)if n_start == .*?^\1end$", re.DOTALL | re.MULTILINE)
    radii = [1000.0 * float(r) for text in texts for r in re.findall(r"movel\(.*r=([\d.]+)\)", entry.sub("", text))]
    lines = lowered.motion.lines
    assert len(radii) == len(lines)
    for (one, first), (other, second) in pairwise(zip(lines, radii, strict=True)):
        if other.length_mm > 0.01 and one.blend_mm > 0.0:
            assert first + second <= other.length_mm


def test_no_more_outputs_wait_than_the_queue_holds() -> None:
    """Those of a line, and of the line before, whose blend has begun."""
    assert 2 * DIALECT.capability.most_events <= QUEUE


def test_with_known_joints_the_arm_is_led_to_its_configuration() -> None:
    made = PROGRAMS["two_tools"]()
    (text,) = export(made, small_cell("universal-robots"), "ur", joints_of(made)).files.values()
    lines = [each.strip() for each in text.splitlines()]
    led = [at for at, each in enumerate(lines) if each.startswith("movej([")]
    assert len(led) == 3 + 2
    assert all(lines[at + 1].endswith("a=0.5, v=0.25)") for at in led[:-2])
    assert not statements(lines, "movej(pose_trans")


def test_frames_are_named_and_declared_once() -> None:
    (text,) = export(PROGRAMS["bottom"](), small_cell("universal-robots"), "ur").files.values()
    lines = [each.strip() for each in text.splitlines()]
    assert "global board_as_mounted = p[0.4,-0.1205,0.03525,0,0,0.523599]" in lines
    assert "global board_flip_to_bottom = p[0.4,0.12,0.06,3.141593,0,0]" in lines
    assert len(statements(lines, "global tcp_ring60 = p[0,0.03,0.1425,0,0.785398,0]")) == 1


@pytest.mark.slow
def test_every_block_has_its_end() -> None:
    for made in PROGRAMS:
        for text in export(PROGRAMS[made](), small_cell("universal-robots"), "ur").files.values():
            lines = [each.strip() for each in text.splitlines()]
            blocks = ("def ", "thread ", "while ", "if ")
            opened = [each for each in lines if each.startswith(blocks) and each.endswith(":")]
            assert len(opened) == lines.count("end")


@pytest.mark.slow
def test_a_long_program_is_divided_into_files_of_functions() -> None:
    lines: list[Line] = []
    for number in range(2 * DIALECT.most_steps):
        blend_mm = 0.03 if number % 50 else 0.0
        lines.append(line(pose(0.1 * number), pose(0.1 * number + 0.1), 50.0, blend_mm=blend_mm))
    motion = program(*READY, *lines)
    files = DIALECT.render(lower(motion, DIALECT.capability), small_cell("universal-robots"))
    assert list(files) == [f"tiny__smt_aqueous{ending}.script" for ending in ("", "_00", "_01", "_02", "_03")]
    assert "thread watch():" in files["tiny__smt_aqueous_00.script"]
    assert files["tiny__smt_aqueous.script"].endswith(
        "\nend\ntiny__smt_aqueous()\n"
    )  # in a Script node a function is defined, and not called
    assert compare(DIALECT.read(files), motion, small_cell("universal-robots")) == ()


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("sleep(", "slip("),
        ("arm(p[0", "arm(p[1"),
        ("if way > ev_way[i]", "if way < ev_way[i]"),
        ("set_tcp(tcp_ring60)", "set_tcp(tcp_ring6)"),
        (", v=", ", w="),
        ("def clean_01():", "clean_01():"),
    ],
)
def test_the_reader_refuses_what_is_not_urscript_as_we_write_it(right: str, wrong: str) -> None:
    files = dict(export(PROGRAMS["three_speeds"](), small_cell("universal-robots"), "ur").files)
    assert any(right in text for text in files.values())
    with pytest.raises(ProgramError):
        DIALECT.read({name: text.replace(right, wrong) for name, text in files.items()})


def test_a_loop_asks_the_sensor_after_its_first_turn() -> None:
    (text,) = export(PROGRAMS["loop"](), small_cell("universal-robots"), "ur").files.values()
    assert "while n_loop_1 < 4 and (n_loop_1 == 0 or 2*get_standard_analog_in(1)+0 < 1):" in text
    (counted,) = export(PROGRAMS["loop"](), replace(small_cell("universal-robots"), sensors={}), "ur").files.values()
    assert "while n_loop_1 < 4:" in counted
