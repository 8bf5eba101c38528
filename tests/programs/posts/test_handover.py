"""What a program leaves to the integrator, in every language, and what it states of its cell."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from installations import ARM_LANGUAGES, full_cell
from robot_programs import PROGRAMS, joints_of, machine_joints_of

from programs.export import Exported, export
from programs.foreign import check_origin, rebuild_program
from programs.motion.installation import Installation
from programs.motion.layout import on_time
from programs.pose import IDENTITY
from programs.posts.dialects import DIALECTS
from robotcell.cell.cell_edits import apply_edits, parse_edit
from robotcell.cell.installation import installation_of
from robotcell.cell.interview import find_questions
from robotcell.cell.load import CELL, LoadedCell, cell_library, read_cell, read_cell_text
from specs.yaml.located import read_yaml

PAGE = Path(__file__).parents[3] / "docs" / "robot-programs.md"
CELLS = {
    "abb": "irb1200-bench",
    "abb-paint": "irb1200-bench",
    "denso": "vs060-bench",
    "epson": "c8l-bench",
    "fanuc": "lrmate-bench",
    "kuka": "kr6-bench",
    "melfa": "rv-4frl-bench",
    "ur": "ur5e-bench",
    "val3": "tx2-60-bench",
    "yaskawa": "gp8-bench",
}
MOST = {name: 3 if name in CELLS else 5 for name in DIALECTS}
"""Tasks: robots, machining controllers."""
NAMED = pytest.mark.parametrize("name", list(DIALECTS))


def answered(name: str) -> LoadedCell:
    """The library's cell of a language, with an answer to all that an interview asks; a person changes tools."""
    file = cell_library()[CELLS.get(name, "gantry")]
    text = file.read_text("utf-8")
    outputs = ("doBusy", "doDone", "doFault", "doLamp")
    edits = [f"io.outputs.{each}: {{kind: digital, number: {40 + at}}}" for at, each in enumerate(outputs)]
    edits.append("io.inputs.diStart: {number: 30}")
    asked = find_questions(read_cell(CELLS.get(name, "gantry")).spec, DIALECTS[name])
    edits += [f"{each.path}: {'stop' if each.path == 'at_tool_change' else each.example}" for each in asked]
    root = read_yaml(text, file, CELL)
    return read_cell_text(apply_edits(text, [parse_edit(each, root) for each in edits], file), file=file)


@cache
def exported(name: str, made: str = "two_tools") -> Exported:
    """In a cell that states all that a cell may state."""
    return export_in(full_cell(name), name, made)


def export_in(cell: Installation, name: str, made: str = "two_tools") -> Exported:
    program = PROGRAMS[made]()
    joints = joints_of(program) if name in ARM_LANGUAGES else machine_joints_of(program, cell)
    if name in ARM_LANGUAGES:
        joints = on_time(program, np.tile(joints.joints, (1, 2))[:, : len(cell.joints)])
    return export(program, cell, name, joints)


@NAMED
def test_little_is_left_to_do_by_hand(name: str) -> None:
    tasks = exported(name).handover.tasks
    assert 0 < len(tasks) <= MOST[name]
    text = "\n".join(exported(name).files.values())
    if name in ("fanuc", "yaskawa"):  # whose comments are short
        assert ".commissioning.md" in text
    if name != "joint-table":  # whose header is for its columns
        assert text.count("Set up: ") + text.count("Set up; ") == len(tasks)


@pytest.mark.slow
@NAMED
def test_in_a_cell_of_the_library_that_answers_an_interview_too(name: str) -> None:
    cell = answered(name)
    assert find_questions(cell.spec, DIALECTS[name]) == ()
    tasks = export_in(installation_of(cell), name).handover.tasks
    assert len(tasks) <= MOST[name]


@NAMED
def test_a_routine_of_the_integrators_is_one_more(name: str) -> None:
    more = {task.text for task in exported(name, "bottom").handover.tasks}
    assert sum(text.startswith("You provide ") for text in more) == 1


@NAMED
def test_every_signal_and_frame_of_the_program_is_listed(name: str) -> None:
    done, cell = exported(name), full_cell(name)
    stated = {each.name: each for each in done.handover.signals}
    assert {"doWash", "doAir"} <= stated.keys()
    assert stated["doWash"].use.startswith("opens ring60")
    outputs = [each.address for each in done.handover.signals if not each.is_input]
    assert len(set(outputs)) == len(outputs)
    if name != "joint-table":
        assert {"doBusy", "doDone", "doFault", "diStart", "diPart", "diDoor"} <= stated.keys()
    frames = [(each.kind, each.number) for each in done.handover.frames]
    assert frames == [("tool", 1), ("tool", 2), ("board", 1)]
    assert done.handover.frames[-1].words[0] == f"{cell.T_base_board.position[0]:.3f}"
    names = done.handover.angles[0].split()
    assert {len(each.words) for each in done.handover.frames} == {3 + len(names)}


def list_of_tasks() -> str:
    """The list of the document, as Markdown."""
    lines: list[str] = []
    for name, language in DIALECTS.items():
        program = next(iter(exported(name).files)).partition(".")[0]
        tasks = (task.text.replace(program, "NAME").replace("|", "\\|") for task in exported(name).handover.tasks)
        lines.append(f"| {language.title} | {'<br>'.join(f'{at}. {text}' for at, text in enumerate(tasks, start=1))} |")
    return "\n".join(("| language | left to do by hand |", "| --- | --- |", *lines)) + "\n"


def test_the_document_lists_what_is_left_to_do(request: pytest.FixtureRequest) -> None:
    text = PAGE.read_text("utf-8")
    table = re.search(r"(?<=## Left to do by hand\n)[^|]*?(\| language .*?\n)\n", text, re.DOTALL)
    assert table
    if request.config.getoption("--update-golden"):
        PAGE.write_text(text[: table.start(1)] + list_of_tasks() + text[table.end(1) :], "utf-8")
        return
    assert table[1] == list_of_tasks(), "run pytest --update-golden and review the diff"


@NAMED
def test_a_part_is_called_a_part_and_its_origin_is_found_again(name: str) -> None:
    files = export_in(replace(full_cell(name), workpiece="part"), name).files
    lines = [line for text in files.values() for line in text.splitlines()]
    about = [line for line in lines if "CAD frame" in line or "sha256" in line or "Washboard: " in line]
    assert about
    assert [line for line in about if re.search(r"\bboard\b", line, re.IGNORECASE)] == []
    check_origin(files)
    origin = rebuild_program(name, files, full_cell(name), lambda _: IDENTITY).origin
    assert origin.board == PROGRAMS["two_tools"]().origin.board
