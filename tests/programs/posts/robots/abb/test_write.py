import math
from dataclasses import replace

import pytest
from installations import small_cell
from robot_programs import PROGRAMS, joints_of
from robot_steps import line, pose, program, turn

from programs.errors import ProgramError
from programs.export import export
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import Call, Line, MotionProgram, Note, Pause, Reach, Step, UseBoard, UseTool
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import IDENTITY
from programs.posts.proving.compare import compare
from programs.posts.robots.abb.read import DIALECT
from programs.posts.writing.vocabulary import RAPID

READY: tuple[Step, ...] = (UseBoard("", IDENTITY, ""), UseTool(1, "ring60", "s"), Reach(pose(0), (), "s"))


def written(motion: MotionProgram) -> str:
    (text,) = DIALECT.render(lower(motion, DIALECT.capability), small_cell("abb")).values()
    return text


def statements(text: str, word: str) -> list[str]:
    """Of the parts: not the one that raises the orifice first."""
    return [line.strip() for line in text.splitlines() if line.strip().startswith(word) and "pStart" not in line]


def test_the_example_of_the_four_dialects() -> None:
    """On 8 mm after the start, off 8 mm before the end, 40 ms to open and 20 ms to shut, 100 mm/s."""
    stroke = line(pose(0), pose(100), 100.0, blend_mm=1.0)
    requests = [SwitchRequest(3, 0.08, True, "ring60", "s"), SwitchRequest(3, 0.92, False, "ring60", "s")]
    steps, _ = open_valves((*READY, stroke), requests, small_cell("abb"))
    text = written(program(*steps))
    assert statements(text, "TriggEquip") == [
        "TriggEquip ev1,8.000\\Start,0.040\\DOp:=doWash,1;",
        "TriggEquip ev2,8.000,0.020\\DOp:=doWash,0;",
    ]
    assert statements(text, "TriggL") == ["TriggL p2,s100,ev1\\T2:=ev2,z1,t_ring60\\WObj:=w_board;"]


def test_a_turn_on_the_spot_goes_at_its_rate() -> None:
    text = written(program(*READY, turn(pose(0), math.pi / 2, 1.0)))
    assert statements(text, "MoveL") == ["MoveL p2,s100_r90,fine,t_ring60\\WObj:=w_board;"]
    assert "CONST speeddata s100_r90:=[100,90,5000,1000];" in text


@pytest.mark.parametrize(("blend_mm", "zone"), [(0.0, "fine"), (0.05, "z0"), (1.2, "z1"), (5.0, "z5")])
def test_a_zone_is_never_wider_than_planned(blend_mm: float, zone: str) -> None:
    stroke = line(pose(0), pose(100), 100.0, blend_mm=blend_mm)
    assert statements(written(program(*READY, stroke)), "MoveL") == [f"MoveL p2,s100,{zone},t_ring60\\WObj:=w_board;"]


def test_with_known_joints_the_arm_is_led_to_its_configuration() -> None:
    made = PROGRAMS["two_tools"]()
    (text,) = export(made, small_cell("abb"), "abb", joints_of(made)).files.values()
    moves = [line for line in statements(text, "Move") if "jHome" not in line]
    for at, move in enumerate(moves):
        if move.startswith("MoveAbsJ"):
            assert moves[at + 1].startswith("MoveL")
    assert len(statements(text, "MoveAbsJ [[")) == 3
    assert not statements(text, "MoveJ")


def test_a_cell_without_a_home_goes_nowhere_before_the_start() -> None:
    cell = replace(small_cell("abb"), home=())
    (text,) = export(PROGRAMS["loop"](), cell, "abb").files.values()
    assert "MoveAbsJ" not in text
    assert "jHome" not in text


def test_a_loop_asks_the_sensor_after_its_first_turn() -> None:
    (text,) = export(PROGRAMS["loop"](), small_cell("abb"), "abb").files.values()
    condition = "WHILE nLoop1<4 AND (nLoop1=0 OR 2*AInput(aiResistivity)+0<1) DO"
    assert statements(text, "WHILE") == [condition]
    counted = export(PROGRAMS["loop"](), replace(small_cell("abb"), sensors={}), "abb")
    assert statements(next(iter(counted.files.values())), "WHILE") == ["WHILE nLoop1<4 DO"]
    assert "no-sensor" in {finding.rule.id for finding in counted.findings}


def test_a_call_keeps_its_name_and_our_routines_take_others() -> None:
    steps = (*READY, Note("function clean", "s"), Call("clean_01", "s"), line(pose(0), pose(9), 10.0))
    text = written(program(*steps))
    assert "clean_01;" in statements(text, "clean_01")
    assert "PROC clean_01()" not in text
    assert "PROC clean_01_2()" in text


@pytest.mark.slow
def test_a_long_program_is_divided_into_modules_that_a_list_names() -> None:
    lines: list[Line] = []
    for number in range(2 * DIALECT.most_steps):
        blend_mm = 0.3 if number % 50 else 0.0
        lines.append(line(pose(0.1 * number), pose(0.1 * number + 0.1), 50.0, blend_mm=blend_mm))
    motion = program(*READY, *lines, Pause(0.1, "s"))
    files = DIALECT.render(lower(motion, DIALECT.capability), small_cell("abb"))
    assert list(files) == [
        "tiny__smt_aqueous.pgf",
        "tiny__smt_aqueous.mod",
        "tiny__smt_aqueous_01.mod",
        "tiny__smt_aqueous_02.mod",
        "tiny__smt_aqueous_03.mod",
    ]
    assert all(len(text.splitlines()) <= 5000 for text in files.values())
    assert compare(DIALECT.read(files), motion, small_cell("abb")) == ()


@pytest.mark.parametrize("board", ["Main", "module", "test"])
def test_a_board_may_have_the_name_of_a_word_of_the_language(board: str) -> None:
    motion = program(*READY, line(pose(0), pose(9), 10.0))
    named = replace(motion, origin=replace(motion.origin, board=board))
    files = DIALECT.render(lower(named, DIALECT.capability), small_cell("abb"))
    assert not RAPID.has(next(iter(files)).removesuffix(".mod"))
    assert compare(DIALECT.read(files), named, small_cell("abb")) == ()


def test_names_of_any_tools_are_kept_apart() -> None:
    cell = small_cell("abb")
    tools = {number: replace(tool, name="Düse 60°") for number, tool in cell.tools.items()}
    odd = replace(cell, tools=tools)
    motion = make_motion(PROGRAMS["two_tools"](), odd)
    files = DIALECT.render(lower(motion, DIALECT.capability), odd)
    assert compare(DIALECT.read(files), motion, odd) == ()
    text = next(iter(files.values()))
    assert "PERS tooldata t_Duse_60deg:=" in text
    assert "PERS tooldata t_Duse_60deg_2:=" in text


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("WaitTime ", "WaitTyme "),
        ("],[0,0,0,0],[9E9", "],[0,0,0],[9E9"),
        ("SetDO doWash,0;", "SetDO doWash;"),
        ("PERS wobjdata w_board", "PERS wobjdata w_bench"),
    ],
)
def test_the_reader_refuses_what_is_not_rapid_as_we_write_it(right: str, wrong: str) -> None:
    files = export(PROGRAMS["three_speeds"](), small_cell("abb"), "abb").files
    text = next(iter(files.values()))
    assert right in text
    with pytest.raises(ProgramError):
        DIALECT.read({"tiny__smt_aqueous.mod": text.replace(right, wrong)})
