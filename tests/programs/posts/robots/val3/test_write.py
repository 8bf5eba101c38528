import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from installations import AIR, WASH, small_cell
from robot_programs import PROGRAMS, joints_of
from robot_steps import line, pose, program, turn

from programs.errors import ProgramError
from programs.export import export
from programs.motion.lower import lower
from programs.motion.steps import Call, Event, Line, MotionProgram, Note, Pause, Reach, Step, UseBoard, UseTool
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import IDENTITY
from programs.posts.proving.compare import compare
from programs.posts.robots.val3.read import DIALECT

READY: tuple[Step, ...] = (UseBoard("", IDENTITY, ""), UseTool(1, "ring60", "s"), Reach(pose(0), (), "s"))


def files_of(motion: MotionProgram) -> dict[str, str]:
    return DIALECT.render(lower(motion, DIALECT.capability), small_cell("staubli"))


def code(text: str) -> list[str]:
    """The statements of a program, comments left out."""
    inside = text.split("<![CDATA[begin")[1].split("end]]>")[0]
    return [line.strip() for line in inside.splitlines() if line.strip() and not line.strip().startswith("//")]


def test_the_example_of_the_four_dialects() -> None:
    """On 4 mm after the start, off 10 mm before the end: there the line is divided; the task sets the outputs."""
    stroke = line(pose(0), pose(100), 100.0)
    requests = [SwitchRequest(3, 0.08, True, "ring60", "s"), SwitchRequest(3, 0.92, False, "ring60", "s")]
    steps, _ = open_valves((*READY, stroke), requests, small_cell("staubli"))
    said = code(files_of(program(*steps))["start_01.pgx"])
    assert said[said.index("movej(p_01[0],t_ring60,mReach)") + 1 :] == [
        "movel(p_01[1],t_ring60,m100_z0p30)",
        "nId=movel(p_01[2],t_ring60,m100_z0p30)",
        "call trigger(nId,0,1)",
        "nId=movel(p_01[3],t_ring60,m100_fine)",
        "call trigger(nId,0,0)",
        "waitEndMove()",
    ]


def test_the_task_knows_every_output_of_the_path() -> None:
    both = tuple(Event(channel, 1.0, "start", 0.0, 0.0, 0.0, 0.0, 60.0, "s") for channel in (AIR, WASH))
    files = files_of(program(*READY, line(pose(0), pose(60), 60.0, events=both)))
    assert code(files["setOutput.pgx"]) == [
        *("if x_nOutput==0", "do1=x_nValue!=0", "endIf"),
        *("if x_nOutput==1", "do2=x_nValue!=0", "endIf"),
    ]
    triggers = [line for line in code(files["start_01.pgx"]) if "trigger" in line]
    assert triggers == ["call trigger(nId,1,1)", "call trigger(nId,0,1)"]


def test_what_is_done_at_rest_waits_for_the_moves() -> None:
    end = Event(WASH, 0.0, "end", 0.0, 0.0, 1.0, 1.0, 60.0, "s")
    said = code(
        files_of(program(*READY, line(pose(0), pose(60), 60.0, events=(end,)), Pause(0.2, "s")))["start_01.pgx"]
    )
    assert said[-4:] == ["movel(p_01[1],t_ring60,m60_fine)", "waitEndMove()", "do1=false", "delay(0.200)"]


def test_every_file_is_xml_and_the_project_lists_it() -> None:
    files = export(PROGRAMS["bottom"](), small_cell("staubli"), "val3").files
    names = list(files)
    assert names[0] == "tiny_sm_sx45.pjx"
    trees = [ElementTree.fromstring(text) for text in files.values()]
    listed = re.findall(r'file="(.*?)"', files["tiny_sm_sx45.pjx"])
    assert sorted(listed) == sorted(names[1:])
    assert {tree.tag.rpartition("}")[2] for tree in trees} == {"Project", "Database", "Programs"}
    programs = {name.removesuffix(".pgx"): text for name, text in files.items() if name.endswith(".pgx")}
    assert all(f'<Program name="{name}"' in text for name, text in programs.items())


def test_points_lie_in_the_frame_of_their_board() -> None:
    data = export(PROGRAMS["bottom"](), small_cell("staubli"), "val3").files["tiny_sm_sx45.dtx"]
    assert set(re.findall(r'fatherId="(f_\w+)\[0\]"', data)) == {"f_board", "f_flip_to_botto"}


def test_a_comment_cannot_end_the_code() -> None:
    files = files_of(program(*READY, Note("odd ]]> name", "s"), line(pose(0), pose(60), 60.0)))
    assert "// odd ]] > name" in files["start_01.pgx"]
    ElementTree.fromstring(files["start_01.pgx"])


def test_a_turn_on_the_spot_goes_at_its_rate() -> None:
    files = files_of(program(*READY, turn(pose(0), math.pi / 2, 1.0)))
    assert "movel(p_01[1],t_ring60,r90_fine)" in files["start_01.pgx"]
    assert re.search(r'name="r90_fine".*\n.*tmax="9999" rmax="90"', files["tiny_sm_sx45.dtx"])


def test_with_known_joints_the_arm_is_led_to_its_configuration() -> None:
    made = PROGRAMS["two_tools"]()
    files = export(made, small_cell("staubli"), "val3", joints_of(made)).files
    moves = [line for text in files.values() if "<Code>" in text for line in code(text) if line.startswith("mov")]
    joints = [at for at, move in enumerate(moves) if move.startswith("movej(jReach[")]
    assert len(joints) == 3
    assert all(moves[at + 1].startswith("movel(p_") for at in joints)
    assert not any(move.startswith("movej(p_") for move in moves)


def test_a_loop_asks_the_sensor_after_its_first_turn() -> None:
    start = export(PROGRAMS["loop"](), small_cell("staubli"), "val3").files["start.pgx"]
    assert "until nLoop1>=4 or 2*aioGet(ai1)+0>=1" in start
    counted = export(PROGRAMS["loop"](), replace(small_cell("staubli"), sensors={}), "val3")
    assert "until nLoop1>=4\n" in counted.files["start.pgx"]


def test_a_call_keeps_its_name_and_our_programs_take_others() -> None:
    steps = (*READY, Note("function clean", "s"), Call("clean_01", "s"), line(pose(0), pose(9), 10.0))
    files = files_of(program(*steps))
    assert "clean_01.pgx" not in files
    assert "call clean_01()" in code(files["clean_01_2.pgx"])


@pytest.mark.slow
def test_a_long_program_is_divided_into_programs() -> None:
    lines: list[Line] = []
    for number in range(2 * DIALECT.most_steps):
        blend_mm = 0.3 if number % 50 else 0.0
        lines.append(line(pose(0.1 * number), pose(0.1 * number + 0.1), 50.0, blend_mm=blend_mm))
    motion = program(*READY, *lines, Pause(0.1, "s"))
    files = files_of(motion)
    assert [name for name in files if name.startswith("start_")] == [f"start_0{number}.pgx" for number in (1, 2, 3)]
    assert compare(DIALECT.read(files), motion, small_cell("staubli")) == ()


@pytest.mark.parametrize(
    ("file", "right", "wrong"),
    [
        ("clean_02.pgx", "waitEndMove()\n  delay", "delay"),
        ("clean_02.pgx", "trigger(nId,0", "trigger(nId,7"),
        ("clean_02.pgx", "_fine)", "_fein)"),
        ("pathOutputs.pgx", ">=", ">"),
        ("tiny_sm_sx45.pjx", '"clean_02.pgx"', '"clean_09.pgx"'),
        ("tiny_sm_sx45.dtx", "</Datas>", ""),
    ],
)
def test_the_reader_refuses_what_is_not_written_so(file: str, right: str, wrong: str) -> None:
    lines = [line(pose(0), pose(60), 60.0), line(pose(60), pose(90), 60.0)]
    off = Event(WASH, 0.0, "start", 0.0, 0.0, 0.0, 0.0, 60.0, "s")
    first = (*READY, lines[0], Note("function clean", "s"), replace(lines[1], events=(off,)), Pause(0.1, "s"))
    files = files_of(program(*first))
    assert right in files[file]
    with pytest.raises(ProgramError):
        DIALECT.read({**files, file: files[file].replace(right, wrong)})


def test_an_input_that_is_not_declared_is_found() -> None:
    files = dict(export(PROGRAMS["bottom"](), small_cell("staubli"), "val3").files)
    (data,) = [file for file in files if file.endswith(".dtx")]
    files[data] = re.sub(r' *<Data name="di3"[^>]*?(?:/>|>(?s:.*?)</Data>)\n', "", files[data])
    assert "di3" not in files[data]
    with pytest.raises(ProgramError, match="variable di3 is not declared as dio"):
        DIALECT.read(files)


@pytest.mark.parametrize("name", ["two_tools", "loop"])
def test_a_jet_that_begins_or_ends_where_the_robot_stands_does_so_at_its_time(name: str) -> None:
    """Divided by the signal, the way of the last moments before a stop would take the controller's own time."""
    program, cell = PROGRAMS[name](), small_cell("staubli")
    forecast = export(program, cell, "val3", joints_of(program)).forecast
    assert forecast is not None
    assert forecast.event_s < DIALECT.capability.cycle_s
    assert forecast.event_mm < 0.01


@pytest.mark.parametrize("other", ["t_ring60", "t_other", "do77"])
def test_a_fault_in_the_data_names_their_file_and_line(other: str) -> None:
    """Declared twice, or never used."""
    files = files_of(program(*READY, line(pose(0), pose(100), 100.0)))
    (name,) = (each for each in files if each.endswith(".dtx"))
    rows = files[name].splitlines()
    begin = next(number for number, row in enumerate(rows) if 'name="t_ring60"' in row)
    more = [row.replace("t_ring60", other) for row in rows[begin : begin + 3]]
    if other == "do77":
        more = [row.replace("do1", other) for row in rows if 'name="do1"' in row]
    files[name] = "\n".join([*rows[: begin + 3], *more, *rows[begin + 3 :]])
    with pytest.raises(ProgramError) as caught:
        DIALECT.read(files)
    assert (str(caught.value.file), caught.value.line) == (name, begin + 4)
