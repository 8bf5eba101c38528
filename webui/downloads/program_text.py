"""An exported program as a page shows it: which text belongs to which line in space, and the other way round."""

import io
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TypeAlias

from programs.errors import ProgramError
from programs.export import find_dialect
from programs.motion.installation import Installation
from programs.motion.lower import EventError, lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import Line, Reach
from programs.program import TimedProgram
from robotcell.robot.robot import Joints
from specs.finding import Finding
from specs.source import NO_SOURCE, Source
from webui.theme.palette import ACCENT, INK, QUIET, to_hex

PAGE_LINES = 40
_LEAD = 6
"""Lines that are shown before the chosen one."""
_MAKER = re.compile(r"sequence\[\d+\][^\s;,)]*")
"""How languages cite who asked for what follows."""
_CHOSEN, _SELECTED = "#f6d9d1", "#fbf1ee"
_ZIP_TIME = (1980, 1, 1, 0, 0, 0)

Move: TypeAlias = Line | Reach


@dataclass(frozen=True, slots=True, eq=False)
class TextFile:
    """One file of a program, line by line."""

    name: str
    lines: tuple[str, ...]
    moves: tuple[Move | None, ...]
    """How each of them moves, where that is known."""
    makers: tuple[Source, ...]
    """Who asked for each of them; empty where nobody did, or it is not known."""


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
    """Whether it is known which text is which motion in space; if not, only which stroke it belongs to."""


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
    files = match_lines(content, moves, language.move)
    tells = any(move is not None for file in files for move in file.moves)
    return Written(dialect, files, content, lowered.motion.findings, lowered.error, tells)


def match_lines(
    content: Mapping[str, str], moves: tuple[Move, ...], pattern: re.Pattern[str] | None
) -> tuple[TextFile, ...]:
    """Give each text that tells a motion its place in space; only its maker if their numbers differ."""
    split = {name: tuple(text.splitlines()) for name, text in content.items()}
    found = sum(pattern.match(text) is not None for lines in split.values() for text in lines) if pattern else 0
    if pattern is None or found != len(moves) or not moves:
        known = tuple(dict.fromkeys(move.made_by for move in moves))
        return tuple(
            TextFile(name, lines, (None,) * len(lines), cited_makers(lines, known)) for name, lines in split.items()
        )
    left = iter(moves)
    files: list[TextFile] = []
    for name, lines in split.items():
        own = tuple(next(left) if pattern.match(text) else None for text in lines)
        files.append(TextFile(name, lines, own, tuple(NO_SOURCE if move is None else move.made_by for move in own)))
    return tuple(files)


def cited_makers(lines: Sequence[str], known: Sequence[Source]) -> tuple[Source, ...]:
    """Say who asked for each text: the one who was cited last, who may have been cut short."""
    makers: list[Source] = []
    maker = NO_SOURCE
    by_text = {str(source): source for source in known}
    for text in lines:
        cited = _MAKER.search(text)
        if cited is not None:
            maker = by_text.get(cited[0]) or _whole(cited[0].removesuffix("..."), by_text)
        makers.append(maker)
    return tuple(makers)


def _whole(begin: str, by_text: Mapping[str, Source]) -> Source:
    return next((source for text, source in by_text.items() if text.startswith(begin)), NO_SOURCE)


def find_text(files: tuple[TextFile, ...], made_by: Source) -> tuple[int, int] | None:
    """Where a stroke is told first: index of the file, and number of the line from 1; nowhere if it is not."""
    for index, file in enumerate(files):
        if made_by and made_by in file.makers:
            return index, file.makers.index(made_by) + 1
    return None


def next_move(file: TextFile, number: int, steps: int) -> int:
    """Number of the next text that moves, or else begins a stroke (steps = 1), or of the one before (-1), if any."""
    numbers = range(number + 1, len(file.lines) + 1) if steps > 0 else range(number - 1, 0, -1)
    if not any(file.moves):
        makers = file.makers
        return next(
            (each for each in numbers if makers[each - 1] and makers[each - 2 : each - 1] != (makers[each - 1],)),
            number,
        )
    return next((each for each in numbers if file.moves[each - 1] is not None), number)


def page_html(file: TextFile, number: int, made_by: Source) -> str:
    """Show a page of a file around a line: that line marked, and those of a stroke tinted.

    Args:
        file: What to show.
        number: The line, from 1.
        made_by: The stroke that is selected; empty for none.
    """
    first = min(max(number - 1 - _LEAD, 0), max(len(file.lines) - PAGE_LINES, 0))
    shown = file.lines[first : first + PAGE_LINES]
    indent = min((len(text) - len(text.lstrip()) for text in shown if text.strip()), default=0)
    rows = [
        _line_html(at, text[indent:], _ground(at == number, bool(made_by) and file.makers[at - 1] == made_by))
        for at, text in enumerate(shown, start=first + 1)
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
