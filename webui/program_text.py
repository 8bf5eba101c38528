"""An exported program as a page shows it: which text belongs to which line in space, and the other way round."""

import io
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from typing import TypeAlias

from geometry.finding import Finding
from programs.errors import ProgramError
from programs.events import EventError, lower
from programs.export import find_dialect
from programs.installation import Installation
from programs.motion import Line, Reach
from programs.program import TimedProgram
from programs.steps import make_motion
from robotcell.robot import Joints
from webui.palette import ACCENT, INK, QUIET, to_hex

PAGE_LINES = 40
_MOVES: Mapping[str, re.Pattern[str]] = {
    "abb": re.compile(r"\s*(MoveL|MoveJ|TriggL) p\d"),
}
"""How a motion to a pose is told in each language."""
_NEVER = re.compile(r"(?!)")
_CHOSEN, _SELECTED = "#f6d9d1", "#fbf1ee"
_ZIP_TIME = (1980, 1, 1, 0, 0, 0)

Move: TypeAlias = Line | Reach


@dataclass(frozen=True, slots=True, eq=False)
class TextFile:
    """One file of a program, line by line."""

    name: str
    lines: tuple[str, ...]
    moves: tuple[Move | None, ...]
    """How each of them moves, where it does."""


@dataclass(frozen=True, slots=True, eq=False)
class Written:
    """A program in a robot's language."""

    dialect: str
    files: tuple[TextFile, ...]
    content: Mapping[str, str]
    """Text by file name, as the command line writes it."""
    findings: tuple[Finding, ...]
    error: EventError
    tells_places: bool
    """Whether it is known which text is which motion in space."""


def write_program(program: TimedProgram, installation: Installation, dialect: str, joints: Joints | None) -> Written:
    """Write a program in a robot's language, and find out which text is which line.

    Raises:
        ProgramError: there is no such dialect, the program cannot be driven, or the language needs the joint motion.
    """
    language = find_dialect(dialect)
    if language.needs_joints and joints is None:
        raise ProgramError(f"{language.title} is made of joint values; check the program in the tab Robot first.")
    lowered = lower(make_motion(program, installation, joints), language.capability)
    content = language.render(lowered, installation)
    moves = tuple(step for step in lowered.motion.steps if isinstance(step, Line | Reach))
    files = match_lines(content, moves, _MOVES.get(dialect, _NEVER))
    tells = any(move is not None for file in files for move in file.moves)
    return Written(dialect, files, content, lowered.motion.findings, lowered.error, tells)


def match_lines(content: Mapping[str, str], moves: tuple[Move, ...], pattern: re.Pattern[str]) -> tuple[TextFile, ...]:
    """Give each text that tells a motion its place in space; none at all if their numbers differ."""
    split = {name: tuple(text.splitlines()) for name, text in content.items()}
    found = sum(pattern.match(text) is not None for lines in split.values() for text in lines)
    left = iter(moves if found == len(moves) else ())
    return tuple(
        TextFile(name, lines, tuple(next(left, None) if pattern.match(text) else None for text in lines))
        for name, lines in split.items()
    )


def find_text(files: tuple[TextFile, ...], made_by: str) -> tuple[int, int] | None:
    """Where a stroke is told first: index of the file, and number of the line from 1; nowhere if it is not."""
    for index, file in enumerate(files):
        for number, move in enumerate(file.moves, start=1):
            if move is not None and move.made_by == made_by:
                return index, number
    return None


def next_move(file: TextFile, number: int, steps: int) -> int:
    """Number of the next text that moves (steps = 1) or of the one before (-1); stays where there is none."""
    numbers = range(number + 1, len(file.lines) + 1) if steps > 0 else range(number - 1, 0, -1)
    return next((each for each in numbers if file.moves[each - 1] is not None), number)


def page_html(file: TextFile, number: int, made_by: str) -> str:
    """Show the page of a file on which a line is: that line marked, and those of a stroke tinted.

    Args:
        file: What to show.
        number: The line, from 1.
        made_by: The stroke that is selected; empty for none.
    """
    first = (min(max(number, 1), max(len(file.lines), 1)) - 1) // PAGE_LINES * PAGE_LINES
    rows = [
        _line_html(at, text, _ground(at == number, _is_of(file.moves[at - 1], made_by)))
        for at, text in enumerate(file.lines[first : first + PAGE_LINES], start=first + 1)
    ]
    return (
        '<div style="margin:2px 10px;border:1px solid #dfe4e8;border-radius:3px;overflow-x:auto;font-family:monospace;'
        f'font-size:11px;line-height:1.5;white-space:pre;color:{to_hex(INK)}">'
        f'<div style="display:inline-block;min-width:100%">{"".join(rows)}</div></div>'
    )


def zip_bytes(content: Mapping[str, str]) -> bytes:
    """Pack files so that the same program gives the same bytes: with one fixed time."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in content.items():
            archive.writestr(zipfile.ZipInfo(name, _ZIP_TIME), text.encode("ascii"), zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def _is_of(move: Move | None, made_by: str) -> bool:
    return move is not None and bool(made_by) and move.made_by == made_by


def _ground(chosen: bool, selected: bool) -> str:
    return (
        f"background:{_CHOSEN};box-shadow:inset 3px 0 {to_hex(ACCENT)}"
        if chosen
        else (f"background:{_SELECTED}" if selected else "")
    )


def _line_html(number: int, text: str, style: str) -> str:
    return (
        f'<div style="{style}"><span style="display:inline-block;width:44px;padding-right:8px;text-align:right;'
        f'color:{to_hex(QUIET)}">{number}</span>{escape(text)} </div>'
    )
