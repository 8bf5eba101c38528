import math
from dataclasses import replace

import pytest
from installations import small_cell
from robot_programs import PROGRAMS, joints_of
from robot_steps import line, pose, program, turn

from programs.errors import ProgramError
from programs.export import export
from programs.motion.lower import lower
from programs.motion.steps import Call, Line, MotionProgram, Note, Pause, Reach, Step, UseBoard, UseTool
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import IDENTITY
from programs.posts.proving.compare import compare
from programs.posts.robots.denso import DIALECT

READY: tuple[Step, ...] = (UseBoard("", IDENTITY, ""), UseTool(1, "ring60", "s"), Reach(pose(0), (), "s"))


def written(motion: MotionProgram) -> list[str]:
    (text,) = DIALECT.render(lower(motion, DIALECT.capability), small_cell("denso")).values()
    return [line.strip() for line in text.splitlines()]


def sprayed(*lines: Line, on: float = 0.08, off: float = 0.92) -> list[str]:
    """The statements from the first line on."""
    requests = [SwitchRequest(3, on, True, "ring60", "s"), SwitchRequest(3, off, False, "ring60", "s")]
    steps, _ = open_valves((*READY, *lines), requests, small_cell("denso"))
    text = written(program(*steps))
    return text[text.index("' s/line") + 1 : text.index("End Sub", text.index("' s/line"))]


def test_the_example_of_the_four_dialects() -> None:
    """On 8 mm after the start, off 8 mm before the end, 40 ms to open and 20 ms to shut, 100 mm/s, 100 mm."""
    assert sprayed(line(pose(0), pose(100), 100.0)) == [
        "Move L, @0 P(100.000, 0.000, 50.000, 180.0000, 0.0000, 0.0000, -1), Speed = 100.0 * PER_MM_S, Next",
        "Arrive 4",
        "Set IO[1]",
        "Arrive 90",
        "Reset IO[1]",
        "WaitMotion 4, 0",
    ]


def test_what_changes_where_a_line_begins_waits_for_no_percent() -> None:
    """The last moment of a line that is passed is the first of the next: no percent is waited for at its end."""
    told = sprayed(line(pose(0), pose(100), 100.0, blend_mm=1.0), line(pose(100), pose(150), 100.0), on=0.5, off=1.0199)
    words = ["Move L", "Arrive 46", "Set IO[1]", "Move L", "Reset IO[1]", "WaitMotion 4"]
    assert [said.split(",")[0] for said in told] == words


def test_a_passing_move_says_how_early_in_whole_mm() -> None:
    one = [line(pose(0), pose(100), 100.0, blend_mm=size) for size in (0.3, 2.7, 0.0)]
    text = [each for each in written(program(*READY, *one)) if each.startswith("Move L") and "pStart" not in each]
    assert [said.split()[2] for said in text] == ["@1", "@2", "@0"]


def test_a_turn_on_the_spot_goes_at_its_rate() -> None:
    text = written(program(*READY, turn(pose(0), math.pi / 2, 1.0)))
    assert any(said.endswith("Speed = 90.0 * PER_DEG_S") for said in text)


def test_with_known_joints_the_arm_is_led_to_its_configuration() -> None:
    made = PROGRAMS["two_tools"]()
    (text,) = export(made, small_cell("denso"), "denso", joints_of(made)).files.values()
    lines = [line.strip() for line in text.splitlines()]
    joints = [at for at, said in enumerate(lines) if said.startswith("Move P, @0 J(") and "home" not in said]
    assert len(joints) == 3
    assert all(lines[at + 1].startswith("Move L, @0 P(") for at in joints)


def test_a_loop_asks_the_sensor_after_its_first_turn() -> None:
    (text,) = export(PROGRAMS["loop"](), small_cell("denso"), "denso").files.values()
    assert "If 0.002 * IOW[1] + 0 >= 1 Then Exit For" in text
    counted = export(PROGRAMS["loop"](), replace(small_cell("denso"), sensors={}), "denso")
    assert "Exit For" not in next(iter(counted.files.values()))


def test_a_call_keeps_its_name_and_our_subprograms_take_others() -> None:
    steps = (*READY, Note("function clean", "s"), Call("tiny__smt_aqueous_01", "s"), line(pose(0), pose(9), 10.0))
    text = written(program(*steps))
    assert "Call tiny__smt_aqueous_01" in text
    assert "Sub tiny__smt_aqueous_01" not in text
    assert "Sub tiny__smt_aqueous_01_2" in text


@pytest.mark.slow
def test_a_long_program_is_divided_into_files_that_run_alone() -> None:
    lines: list[Line] = []
    for number in range(2 * DIALECT.most_steps):
        blend_mm = 0.3 if number % 50 else 0.0
        lines.append(line(pose(0.1 * number), pose(0.1 * number + 0.1), 50.0, blend_mm=blend_mm))
    motion = program(*READY, *lines, Pause(0.1, "s"))
    files = DIALECT.render(lower(motion, DIALECT.capability), small_cell("denso"))
    assert list(files) == [
        "tiny__smt_aqueous.pcs",
        "tiny__smt_aqueous_01.pcs",
        "tiny__smt_aqueous_02.pcs",
        "tiny__smt_aqueous_03.pcs",
    ]
    assert all("#Define PER_MM_S" in text and "Sub Main" in text for text in files.values())
    assert compare(DIALECT.read(files), motion, small_cell("denso")) == ()


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        (", Next", ""),
        ("Arrive ", "Arrives "),
        ("ChangeWork 1", "ChangeWork 2"),
        ("Set IO[1]", "Set IO"),
        ("Sub Main", "Sub Mine"),
    ],
)
def test_the_reader_refuses_what_is_not_written_so(right: str, wrong: str) -> None:
    (text,) = export(PROGRAMS["three_speeds"](), small_cell("denso"), "denso").files.values()
    assert right in text
    with pytest.raises(ProgramError):
        DIALECT.read({"tiny__smt_aqueous.pcs": text.replace(right, wrong)})
