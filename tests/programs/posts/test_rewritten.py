"""Programs that are written otherwise than here, as makers' grammars allow: read as the same, or refused at a line."""

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from functools import cache

import numpy as np
import pytest
from installations import ARM_LANGUAGES, full_cell
from robot_programs import PROGRAMS, joints_of, machine_joints_of

from programs.errors import ProgramError
from programs.export import Exported, export
from programs.motion.layout import on_time
from programs.posts.dialects import DIALECTS
from programs.posts.rebuilt import ReadLine, ReadSwitch, Rebuilt

Rewrite = Callable[[str], str]

COMMENTS = {
    **dict.fromkeys(("abb", "abb-paint"), "!"),
    **dict.fromkeys(("kuka", "linuxcnc", "sinumerik", "heidenhain"), ";"),
    **dict.fromkeys(("denso", "epson", "melfa"), "'"),
    "ur": "#",
}
"""What begins a comment, up to the end of its line."""
FREE = ("abb", "abb-paint", "kuka", "sinumerik", "epson", "denso", "melfa")
"""Languages in which blanks around words and signs are free."""
ABOUT_LINES = ("linuxcnc", "fanuc-cnc", "ur", "heidenhain", *FREE)
"""Those whose texts people write by hand: FANUC's and Yaskawa's controllers print theirs, VAL3's are XML."""


@cache
def exported(name: str, made: str) -> Exported:
    program, cell = PROGRAMS[made](), full_cell(name)
    joints = joints_of(program) if name in ARM_LANGUAGES else machine_joints_of(program, cell)
    if name in ARM_LANGUAGES:
        joints = on_time(program, np.tile(joints.joints, (1, 2))[:, : len(cell.joints)])
    return export(program, cell, name, joints)


def in_lines(change: Rewrite) -> Rewrite:
    return lambda text: "\n".join(map(change, text.split("\n")))


def in_statements(mark: str, change: Rewrite) -> Rewrite:
    """Change what is neither in quotes nor in a comment."""

    def changed(line: str) -> str:
        at = min((place for each in (*mark.split(), "(*") if (place := line.find(each)) >= 0), default=len(line))
        parts = re.split(r'("[^"]*")', line[:at])
        parts[::2] = map(change, parts[::2])
        return "".join(parts) + line[at:]

    return in_lines(changed)


def renumbered(text: str) -> str:
    return re.sub(r"(?m)^\d+(?= )", lambda number: str(10 * int(number[0])), text)


def positions_first(text: str) -> str:
    """Steps after the positions that stand below them."""
    lines = text.rstrip("\n").split("\n")
    steps = [line for line in lines if re.match(r"\d+ ", line)]
    return "\n".join([*(line for line in lines if line not in steps), *steps, ""])


def rewrites(name: str) -> Iterator[tuple[str, Rewrite]]:
    mark = COMMENTS.get(name, "")
    within = in_statements if name != "linuxcnc" else lambda mark, change: in_statements(f"{mark} (", change)
    yield "windows lines", lambda text: text.replace("\n", "\r\n")
    yield "blanks at the ends of lines", in_lines(lambda line: f"{line}  ")
    if name not in ABOUT_LINES:
        return
    yield "deeper", in_lines(lambda line: f"  {line}" if line.strip() else line)
    yield "empty lines", lambda text: text.replace("\n", "\n\n")
    if mark and name not in ("melfa", "heidenhain"):  # whose lines have numbers
        yield "lines of comments", lambda text: text.rstrip("\n").replace("\n", f"\n{mark} note\n") + "\n"
    if mark:
        comment = f" {mark} a, b = .5"
        yield "comments", in_lines(lambda line: f"{line}{comment}" if line.strip() and line[-1] != ")" else line)
    if name in FREE:
        yield "wide commas", within(mark, lambda code: re.sub(r", ?", " ,  ", code))
        yield "tight commas", within(mark, lambda code: re.sub(r", ", ",", code))
        yield "wide equals", within(mark, lambda code: re.sub(r" ?(?<![<>=!:])(:?=)(?!=) ?", r"  \1 ", code))
        yield "many blanks", within(mark, lambda code: re.sub(r"(?<=\S) (?=\S)", "   ", code))
        yield "no zero before a point", within(mark, lambda code: re.sub(r"(?<![\w.])0(\.\d)", r"\1", code))
    if name in (*FREE, "fanuc-cnc") and name != "denso":
        numbers = r"(?<![A-Za-z.\d])(\d+\.\d+)(?![\d.])"
        yield "more zeros", within(mark, lambda code: re.sub(numbers, r"\g<1>0", code))
        yield "fewer zeros", within(mark, lambda code: re.sub(r"(\.\d*[1-9])0+(?!\d)", r"\1", code))
    if name in ("melfa", "heidenhain"):
        yield "other numbers of lines", renumbered
    if name == "melfa":
        yield "positions before steps", positions_first


SMALL_OR_LARGE = ("abb", "abb-paint", "kuka", "sinumerik", "linuxcnc", "epson", "denso", "melfa")
"""Languages in which the case of letters is free."""
POWERS = ("abb", "abb-paint", "kuka", "epson", "denso", "melfa")
"""Languages whose controllers write small numbers with powers of ten."""


def in_code(name: str, change: Rewrite) -> Rewrite:
    """Change what is neither in quotes nor a comment."""
    marks = {"linuxcnc": "; (", "fanuc-cnc": "(", "val3": "//", "joint-table": "#", "fanuc": "!", "yaskawa": "'"}
    return in_statements(marks.get(name, COMMENTS.get(name, "")), change)


def edits(name: str) -> Iterator[tuple[str, Rewrite, bool]]:
    """Changes by hand, and whether the maker's grammar allows them: others, and some that it does, are refused."""
    is_free = name in SMALL_OR_LARGE
    yield "large letters", in_code(name, str.upper), is_free or name in ("heidenhain", "fanuc-cnc")
    yield "small letters", in_code(name, str.lower), is_free
    number = r"(?<![A-Za-z_.\d])(\d+)\.0+(?![.\d])"
    may_end = name in (*FREE, "linuxcnc", "heidenhain", "fanuc-cnc", "val3")
    yield "no digits after a point", in_code(name, lambda code: re.sub(number, r"\1.", code)), may_end
    power = r"(?<![\w.])(\d+\.\d+)(?![.\d])"
    yield "powers of ten", in_code(name, lambda code: re.sub(power, r"\1E0", code)), name in POWERS
    yield "wrapped at a comma", in_code(name, lambda code: code.replace(",", ",\n ", 1)), False


def outcome(name: str, files: Mapping[str, str]) -> Rebuilt | ProgramError:
    try:
        return DIALECTS[name].read_edited(files)
    except ProgramError as refused:
        return refused


def edited_cases() -> Iterator[object]:
    for name in DIALECTS:
        for what, change, allowed in edits(name):
            files = exported(name, "two_tools").files
            if any(change(text) != text for text in files.values()):
                yield pytest.param(name, change, allowed, id=f"{name}-{what}")


CASES = [pytest.param(name, change, id=f"{name}-{what}") for name in DIALECTS for what, change in rewrites(name)]


def rewritten(name: str, change: Rewrite, made: str = "loop") -> tuple[Exported, Mapping[str, str]]:
    done = exported(name, made)
    return done, {file: change(text) for file, text in done.files.items()}


@pytest.mark.parametrize(("name", "change"), CASES)
def test_a_program_that_is_written_otherwise_is_the_same(name: str, change: Rewrite) -> None:
    done, files = rewritten(name, change)
    files = {file: text.replace("\r\n", "\n") for file, text in files.items()}  # as files are read
    read = DIALECTS[name].read_edited(files)
    assert read.steps == done.rebuilt.steps
    assert read.frame == done.rebuilt.frame


@pytest.mark.parametrize("made", ["two_tools", "loop"])
@pytest.mark.parametrize(("name", "change", "allowed"), edited_cases())
def test_what_is_edited_by_hand_is_read_or_refused_at_a_line(
    name: str, change: Rewrite, allowed: bool, made: str
) -> None:
    """Where letters may be small or large, names are spelled otherwise too: channels and routines."""
    done, files = rewritten(name, change, made)
    read = outcome(name, files)
    if isinstance(read, ProgramError):
        assert not allowed, read
        assert isinstance(read.file, str)
        assert read.line is not None
        assert 1 <= read.line <= files[read.file].count("\n") + 1
    else:
        assert repr(read.steps).lower() == repr(done.rebuilt.steps).lower()
        assert (read.frame is None) is (done.rebuilt.frame is None)


@pytest.mark.parametrize("name", ["abb", "kuka", "linuxcnc", "epson"])
def test_valves_are_known_in_any_letters(name: str) -> None:
    done, files = rewritten(name, in_code(name, str.upper), "two_tools")
    channels = [valve.channel for valve in done.installation.valves.values()]
    steps = DIALECTS[name].read_edited(files).steps
    labels = Counter(
        each.channel
        for step in steps
        for each in ([step] if isinstance(step, ReadSwitch) else step.signals if isinstance(step, ReadLine) else [])
    )
    assert all(any(channel.is_called(label) for label in labels) for channel in channels)


DECLARATIONS = {
    **dict.fromkeys(("abb", "abb-paint"), ("(?m)^  VAR num .*$", "  VAR num nMine:=0;")),
    "kuka": ("(?m)^DECL GLOBAL INT .*$", "DECL GLOBAL INT nMine=0"),
    "epson": ("(?m)^ *Integer .*$", "  Integer nMine"),
    "denso": ("(?m)^ *Dim .*$", "  Dim nMine As Integer"),
    "ur": ("(?m)^ *board = .*$", "  n_mine = 1"),
    "melfa": (r"(?m)^PTL1=.*$", "PMINE=(1,2,3,4,5,6)(0,0)"),
    "val3": (
        r'(?m)^.*<Data name="nStart".*$',
        '<Data name="nMine" access="private" xsi:type="array" type="num" size="1"/>',
    ),
    "heidenhain": (r"(?m)^\d+ CYCL DEF 32.0 .*$", "1 Q99 = +1"),
    "sinumerik": (r"(?m)^R111=0$", "DEF INT nMine"),
    "linuxcnc": (r"(?m)^ *#<_start> = 1$", "#<mine> = 1"),
    "fanuc-cnc": (r"(?m)^ *#\d+ ?= ?\d+$", "#199=1"),
    "fanuc": (r"(?m)^ *\d+:  R\[.*$", "   1:  R[99]=0 ;"),
    "yaskawa": (r"(?m)^///NPOS .*$", "///NVARS 1"),
}
"""A line before which what is declared and never used is put, and that."""


@pytest.mark.parametrize("name", DECLARATIONS)
def test_what_is_declared_and_never_used_is_read_or_refused_at_its_line(name: str) -> None:
    before, declared = DECLARATIONS[name]
    done = exported(name, "loop")
    file, place = next(
        (file, found.start()) for file, text in done.files.items() if (found := re.search(before, text)) is not None
    )
    text = done.files[file]
    files = {**done.files, file: f"{text[:place]}{declared}\n{text[place:]}"}
    line = text[:place].count("\n") + 1
    read = outcome(name, files)
    if isinstance(read, ProgramError):
        assert read.file == file
        assert read.line is not None
        counts = "LINE_COUNT" in text.split("\n")[read.line - 1]  # FANUC's programs state how many lines they have
        assert counts or read.line in (line, line + 1)  # what is wrong with a line may be found at the next
    else:
        assert read.steps == done.rebuilt.steps


@pytest.mark.parametrize("made", ["loop", "two_tools", "bottom", "faces"])
@pytest.mark.parametrize("name", DIALECTS)
def test_what_is_written_here_is_read_as_it_is(name: str, made: str) -> None:
    done = exported(name, made)
    assert DIALECTS[name].read_edited(done.files).steps == done.rebuilt.steps


@pytest.mark.parametrize("name", DIALECTS)
def test_what_no_language_has_is_refused_at_its_line(name: str) -> None:
    done = exported(name, "loop")
    place = next(place for place in reversed(done.rebuilt.places) if place is not None)
    lines = done.files[place.file].split("\n")
    lines[place.line - 1] = "%%%"
    with pytest.raises(ProgramError) as refused:
        DIALECTS[name].read_edited({**done.files, place.file: "\n".join(lines)})
    assert refused.value.file is not None
    if name != "val3":  # whose programs are checked as a whole
        assert refused.value.line in (place.line, place.line + 1)


@pytest.mark.parametrize("name", ["denso", "epson", "melfa", "sinumerik", "linuxcnc"])
def test_a_way_to_part_1_is_refused(name: str) -> None:
    """A program starts there anyway; its other parts have a way from where the robot stands."""
    files = exported(name, "two_tools").files
    entry = re.compile(r"(?im)^(.*\bif \S+? ?(?:==?|<>|eq) ?)[23]\b")
    changed = {each: entry.sub(r"\g<1>1", text, count=1) for each, text in files.items()}
    assert changed != files
    with pytest.raises(ProgramError):
        DIALECTS[name].read_edited(changed)
