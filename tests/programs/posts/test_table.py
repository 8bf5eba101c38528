"""What every language makes of every kind of program and cell: read back as planned, or refused by the cell's name."""

import re
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from itertools import combinations

import pytest
from installations import ARM_LANGUAGES, for_language, small_cell, small_machine
from robot_programs import PROGRAMS, joints_of, machine_joints_of

from programs.errors import ProgramError
from programs.motion.installation import Assignment, Channel, Contact, Installation, Sensor
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import MotionProgram, Mount
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare
from programs.posts.rebuilt import ReadCall, ReadLine, ReadMount, ReadReach
from programs.posts.writing.axes import in_tool_points
from programs.program import TimedProgram
from robotcell.cell.hold import board_pose
from robotcell.cell.installation import to_pose
from robotcell.cell.spec import Hold, PointPair

NAMED = pytest.mark.parametrize("name", list(DIALECTS))
CHANGES_TOOLS = [name for name, each in DIALECTS.items() if each.capability.changes_tools]
"""Languages in which a word has the tool changed."""
ASKS = [name for name in DIALECTS if name not in CHANGES_TOOLS]
QUICK = ("two_tools", "bottom", "loop", "faces", "panel", "odd_names")
"""Two tools, a board that is turned over, a repeat, a part with faces along +-x and +-y, names that nobody takes."""
FIDUCIALS = Hold(
    points=[
        PointPair(board_mm=on_board, cell_mm=in_cell)
        for on_board, in_cell in (
            ((0, 0, 0), (400, -120, 35)),
            ((100, 0, 0), (496.593, -94.118, 38)),
            ((0, 80, 0), (379.24, -42.76, 33.5)),
        )
    ],
    largest_residual_mm=2.0,
)
"""Of a board that lies askew, and not quite level."""
CASES = [
    pytest.param(name, made, id=f"{name}-{made}", marks=() if made in QUICK else pytest.mark.slow)
    for name in DIALECTS
    for made in PROGRAMS
    if name in ARM_LANGUAGES or made != "at_random"  # made-up joints would jump where its jets turn over the vertical
]


def cell_of(name: str) -> Installation:
    return for_language(small_cell(), name) if name in ARM_LANGUAGES else small_machine()


def motion_in(name: str, program: TimedProgram, cell: Installation) -> MotionProgram:
    language = DIALECTS[name]
    joints = joints_of(program) if name in ARM_LANGUAGES else machine_joints_of(program, cell)
    motion = make_motion(program, cell, joints, switches_at_rest=language.capability.switches_at_rest)
    return motion if name in ARM_LANGUAGES else in_tool_points(motion, cell)


def write(name: str, motion: MotionProgram, cell: Installation) -> Mapping[str, str]:
    return DIALECTS[name].render(lower(motion, DIALECTS[name].capability), cell)


@cache
def written(name: str, made: str) -> tuple[MotionProgram, Mapping[str, str]]:
    motion = motion_in(name, PROGRAMS[made](), cell_of(name))
    return motion, write(name, motion, cell_of(name))


@pytest.mark.parametrize(("name", "made"), CASES)
def test_what_is_written_is_ascii_in_lines_and_is_read_back_as_planned(name: str, made: str) -> None:
    motion, files = written(name, made)
    assert compare(DIALECTS[name].read(files), motion, cell_of(name)) == ()
    for file, text in files.items():
        assert file.isascii()
        assert "/" not in file
        assert text.isascii()
        assert max(map(len, text.splitlines())) <= DIALECTS[name].longest_line
        assert text.endswith("\n")


@NAMED
def test_a_board_that_was_measured_at_its_fiducials_is_where_they_are(name: str) -> None:
    cell = replace(cell_of(name), T_base_board=to_pose(board_pose(FIDUCIALS)))
    motion = motion_in(name, PROGRAMS["faces"](), cell)
    files = write(name, motion, cell)
    assert compare(DIALECTS[name].read(files), motion, cell) == ()
    if name not in ("joint-table", "linuxcnc"):  # which have joint values here
        assert compare(DIALECTS[name].read(files), written(name, "faces")[0], cell_of(name))


def problems(name: str, files: Mapping[str, str], motion: MotionProgram) -> str:
    try:
        return "; ".join(map(str, compare(DIALECTS[name].read(files), motion, cell_of(name))))
    except ProgramError as refused:
        return str(refused)


# Names

OTHERS = [("tiny", "smt-aqueous"), ("tiny", "rinse-only"), ("tiny-2", "smt-aqueous"), ("tiny_2", "smt-aqueous")]
GLOBAL = {"kuka": r"(?m)^DECL GLOBAL \w+ (\w+)=", "fanuc-cnc": r"(?m)^<(\w+)>$", "abb": r"(?m)^MODULE (\w+)$"}
"""Names beside those of files that a controller knows."""


@NAMED
def test_boards_and_recipes_have_no_name_in_common_but_what_is_shared_and_the_same(name: str) -> None:
    motion, _ = written(name, "loop")
    everything: list[Mapping[str, str]] = []
    for board, recipe in OTHERS:
        files = write(name, replace(motion, origin=replace(motion.origin, board=board, recipe=recipe)), cell_of(name))
        assert compare(DIALECTS[name].read(files), motion, cell_of(name)) == ()
        if DIALECTS[name].form.is_project:  # a folder of its own
            files = {next(iter(files)): ""}
        known = {found for text in files.values() for found in re.findall(GLOBAL.get(name, "(?!)"), text)}
        everything.append({**files, **dict.fromkeys(known, "global")})
    assert len({next(iter(files)).lower() for files in everything}) == len(OTHERS)  # by which the pages are named
    stated = "\n".join(everything[0].values())
    for one, other in combinations(everything, 2):
        for common in {each.lower() for each in one} & {each.lower() for each in other}:
            (first, second) = (
                next(text for key, text in each.items() if key.lower() == common) for each in (one, other)
            )
            assert first == second != "global"
            shared = common.rpartition(".")[0]
            assert re.search(rf"(?i)Shared with other programs of this cell: .*\b{shared}\b", stated), common


NAMES = {"abb": "RAPID", "abb-paint": "RAPID", "kuka": "KRL"}
"""Languages that call channels by the names that they have in the cell."""


def called(name: str, word: str) -> Installation:
    """A cell in which a valve, a group, an input, a sensor and the tools have that name."""
    cell = cell_of(name)
    part, door, pressure = cell.waits
    waits = (part, replace(door, contact=Contact(word, 4)), replace(pressure, sensor=Sensor(word, 2, 1.25, -2.5)))
    ring = replace(cell.valves["ring60"], channel=Channel("digital", word, 1))
    groups = {each: (Assignment(Channel("group", word, 1), 1.0),) for each in cell.solutions}
    tools = {number: replace(tool, name=word) for number, tool in cell.tools.items()}
    return replace(cell, valves={**cell.valves, "ring60": ring}, solutions=groups, waits=waits, tools=tools)


@pytest.mark.parametrize("word", ["IF", "p1", "a.b-c"])
@NAMED
def test_a_name_with_another_meaning_is_refused_by_its_path_or_has_no_effect(name: str, word: str) -> None:
    cell = called(name, word)
    motion = motion_in(name, PROGRAMS["two_tools"](), cell)
    if name in NAMES:
        with pytest.raises(ProgramError, match=rf"^io\.outputs\.{word}: {NAMES[name]}: {word} .* in the cell\.$"):
            write(name, motion, cell)
        return
    assert compare(DIALECTS[name].read(write(name, motion, cell)), motion, cell) == ()


@pytest.mark.parametrize("word", ["nStart", "shut_valves", "Define_Events", "ev3", "s60", "s120p5_r45", "x" * 42])
def test_words_and_names_of_the_program_itself_are_no_outputs_of_rapid(word: str) -> None:
    cell = called("abb", word)
    with pytest.raises(ProgramError, match=rf"^io\.outputs\.{word}: RAPID: {word} (is a word|has 42 characters)"):
        write("abb", motion_in("abb", PROGRAMS["two_tools"](), cell), cell)


def test_a_group_of_krl_is_not_the_counter_of_waits() -> None:
    with pytest.raises(
        ProgramError, match=r"^io\.outputs\.nWait: KRL: nWait is a word of the language, or a name that"
    ):
        write("kuka", motion_in("kuka", PROGRAMS["two_tools"](), called("kuka", "nWait")), called("kuka", "nWait"))


@pytest.mark.parametrize(("name", "taken"), [("abb", "diDoor"), ("abb-paint", "DIDOOR"), ("abb", "DOAIR")])
def test_a_name_that_an_input_or_another_output_has_too_is_refused_by_its_path(name: str, taken: str) -> None:
    """A controller knows a name once, in large or small letters."""
    cell = cell_of(name)
    valve = replace(cell.valves["ring60"], channel=Channel("digital", taken, 1))
    cell = replace(cell, valves={**cell.valves, "ring60": valve})
    motion = motion_in(name, PROGRAMS["two_tools"](), cell)
    with pytest.raises(ProgramError, match=r"^io\.(in|out)puts\.\w+: RAPID: io\.outputs\.\w+ has this name too"):
        write(name, motion, cell)


def test_names_of_the_controller_come_before_those_that_the_program_may_choose() -> None:
    valve = replace(cell_of("abb").valves["ring60"], channel=Channel("digital", "clean_01", 1))
    cell = replace(cell_of("abb"), valves={**cell_of("abb").valves, "ring60": valve})
    text = "".join(write("abb", motion_in("abb", PROGRAMS["two_tools"](), cell), cell).values())
    assert "SetDO clean_01,0;" in text
    assert "PROC clean_01_2()" in text


@pytest.mark.parametrize("name", ASKS)
def test_a_routine_that_changes_tools_is_called_by_its_name_or_refused(name: str) -> None:
    cell = replace(cell_of(name), tool_routine="y" * 42)
    motion = motion_in(name, PROGRAMS["two_tools"](), cell)
    if name == "ur":  # which takes 60 letters
        assert f"{'y' * 42}_2()" in "".join(write(name, motion, cell).values())
        return
    with pytest.raises(ProgramError, match=r"^at_tool_change\.routine: .* has \d\d characters, \d+ at most are taken;"):
        write(name, motion, cell)


# Acts of a person


@pytest.mark.parametrize("name", ASKS)
@pytest.mark.parametrize("routine", ["", "mount"])
def test_the_program_never_goes_on_with_another_tool_by_itself(name: str, routine: str) -> None:
    """Before the first motion too: another tool may be left from the last time."""
    cell = replace(cell_of(name), tool_routine=routine)
    motion = motion_in(name, PROGRAMS["two_tools"](), cell)
    files = write(name, motion, cell)
    read = DIALECTS[name].read(files)
    assert compare(read, motion, cell) == ()
    acts = [step for step in read.steps if isinstance(step, ReadMount | ReadCall | ReadLine | ReadReach)]
    changes = [at for at, step in enumerate(acts) if isinstance(step, ReadMount | ReadCall)]
    assert changes[0] == 0
    asked = [str(step.number) if isinstance(step, ReadMount) else step.label for at in changes for step in [acts[at]]]
    assert [each[-1] for each in asked] == ["1", "2", "1"]
    text = "\n".join(files.values())
    assert "Tools 1 (ring60) and 2 (knife): " in text
    assert ("mount_1 and mount_2 are yours" in text) is bool(routine)
    other = replace(cell, tool_routine="" if routine else "mount")
    assert compare(read, motion, other)
    wrong = replace(motion, steps=tuple(step for step in motion.steps if not isinstance(step, Mount)))
    assert compare(DIALECTS[name].read(write(name, wrong, cell)), motion, cell)


AGAIN = {
    "abb": "    ISignalDI diDoor,1,irWatch2;\n",
    "kuka": "INTERRUPT ON 23\n",
    "ur": "    run_watch_inputs = run watch_inputs()\n",
    "val3": '  taskCreate "guard",50,guard()\n',
    "epson": "  Trap 1, Sw(4) = On Xqt on_fault\n",
    "sinumerik": "ID=23 EVERY $A_IN[5]==1 DO SETAL(65023)\n",
}
"""What begins to watch the door, in languages in which the program does that."""


@pytest.mark.parametrize("name", AGAIN)
def test_the_door_is_not_watched_while_a_person_mounts_a_tool_and_is_again_before_the_robot_moves(name: str) -> None:
    motion, files = written(name, "two_tools")
    file = [file for file, text in files.items() if AGAIN[name] in text][-1]
    head, _, tail = files[file].rpartition(AGAIN[name])
    assert problems(name, files, motion) == ""
    assert problems(name, {**files, file: head + tail}, motion)
    if name == "kuka":  # in a subprogram a declaration ends with it
        assert "".join(files.values()).count("INTERRUPT DECL 23") == 1


@pytest.mark.parametrize("name", ASKS)
def test_a_later_part_begins_with_the_tool_that_it_needs(name: str) -> None:
    """In short parts, so that some begin within the work of a tool."""
    language, motion = replace(DIALECTS[name], most_steps=4), written(name, "two_tools")[0]
    read = language.read(language.render(lower(motion, language.capability), cell_of(name)))
    assert read.frame is not None
    mounted = ""
    begun = {part.begins: part for part in read.frame.parts}
    for at, step in enumerate(read.steps):
        entry = begun[at].entry if at in begun else ()
        asked = [str(each.number) for each in entry if isinstance(each, ReadMount)]
        moves = any(isinstance(each, ReadLine | ReadReach) for each in entry)
        assert asked == ([mounted] if moves else asked)
        assert set(asked) <= {mounted}
        mounted = str(step.number) if isinstance(step, ReadMount) else mounted
    assert any(isinstance(each, ReadMount) for part in read.frame.parts for each in part.entry)


@pytest.mark.parametrize("name", CHANGES_TOOLS)
def test_a_language_whose_word_changes_tools_asks_for_nothing_else(name: str) -> None:
    cell = replace(cell_of(name), tool_routine="mount")
    motion = motion_in(name, PROGRAMS["two_tools"](), cell)
    assert any(isinstance(step, Mount) for step in motion.steps)
    files = write(name, motion, cell)
    assert compare(DIALECTS[name].read(files), motion, cell) == ()
    assert not re.search(r"mount_\d", "\n".join(files.values()))
