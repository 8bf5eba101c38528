"""Programs that are written otherwise than here, as makers' grammars allow: read as the same, or refused at a line."""

import re
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
    if name not in ("fanuc", "yaskawa", "val3"):  # whose programs are checked as a whole
        assert refused.value.line in (place.line, place.line + 1)
