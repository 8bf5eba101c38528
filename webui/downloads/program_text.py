"""The text of a robot's program, with the motion and the stroke of each line."""

import io
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TypeAlias

from programs.export import Exported
from programs.motion.steps import Line, Reach
from programs.posts.rebuilt import ReadLine, ReadReach, TextPlace
from specs.source import NO_SOURCE, Source
from webui.theme.palette import ACCENT, CHOSEN_GROUND, GROUND, INK, LINE_COLOUR, QUIET, css_colour

PAGE_LINES = 40
_LEAD = 6
"""Lines above the chosen one."""
_MAKER = re.compile(r"sequence\[\d+\][^\s;,)]*")
"""Comment that names the origin of the lines that follow."""
_CHOSEN, _SELECTED = css_colour(CHOSEN_GROUND), GROUND
_ZIP_TIME = (1980, 1, 1, 0, 0, 0)

Move: TypeAlias = Line | Reach


@dataclass(frozen=True, slots=True, eq=False)
class TextFile:
    """One file of a program, line by line."""

    name: str
    lines: tuple[str, ...]
    moves: tuple[Move | None, ...]
    """Motion of each line, where it is known."""
    makers: tuple[Source, ...]
    """Origin of each line; empty where there is none, or it is not known."""


@dataclass(frozen=True, slots=True, eq=False)
class Written:
    """A program in a robot's language."""

    dialect: str
    files: tuple[TextFile, ...]
    exported: Exported
    """As the command line writes it."""
    places_known: bool
    """Whether it is known which text is which motion in space; if not, only which stroke it belongs to."""


def link_text(dialect: str, exported: Exported) -> Written:
    """Assign the lines of a program that was written in a language to its motions."""
    moves = tuple(step for step in exported.motion.steps if isinstance(step, Line | Reach))
    read = zip(exported.rebuilt.steps, exported.rebuilt.places, strict=True)
    places = [place for step, place in read if isinstance(step, ReadLine | ReadReach)]
    files = match_lines(exported.files, moves, places)
    places_known = any(move is not None for file in files for move in file.moves)
    return Written(dialect, files, exported, places_known)


def match_lines(
    content: Mapping[str, str], moves: tuple[Move, ...], places: Sequence[TextPlace | None]
) -> tuple[TextFile, ...]:
    """Lines with their motions; only with their origins where a motion takes several lines.

    Args:
        content: Text by file name.
        moves: In the order of the program.
        places: Statements of the motions that were read, in the same order.
    """
    split = {name: tuple(text.splitlines()) for name, text in content.items()}
    if len(places) != len(moves) or not moves or None in places:
        known = tuple(dict.fromkeys(move.made_by for move in moves))
        return tuple(
            TextFile(name, lines, (None,) * len(lines), cited_makers(lines, known)) for name, lines in split.items()
        )
    at = {(place.file, place.line): move for place, move in zip(places, moves, strict=True) if place is not None}
    files: list[TextFile] = []
    for name, lines in split.items():
        own = tuple(at.get((name, number)) for number in range(1, len(lines) + 1))
        files.append(TextFile(name, lines, own, tuple(NO_SOURCE if move is None else move.made_by for move in own)))
    return tuple(files)


def cited_makers(lines: Sequence[str], known: Sequence[Source]) -> tuple[Source, ...]:
    """Origin of each line: the one named last, whose name may be truncated."""
    makers: list[Source] = []
    maker, by_text = NO_SOURCE, {str(source): source for source in known}
    for text in lines:
        cited = _MAKER.search(text)
        if cited is not None:
            begin = cited[0].removesuffix("...")
            full = next((text for text in by_text if text.startswith(begin)), "")
            maker = by_text.get(cited[0]) or by_text.get(full, NO_SOURCE)
        makers.append(maker)
    return tuple(makers)


def find_text(files: tuple[TextFile, ...], made_by: Source) -> tuple[int, int] | None:
    """First line of a stroke: index of the file, and number of the line from 1; ``None`` if there is none."""
    for index, file in enumerate(files):
        if made_by and made_by in file.makers:
            return index, file.makers.index(made_by) + 1
    return None


def next_move(file: TextFile, number: int, steps: int) -> int:
    """Number of the next line with a motion, else of the next stroke (steps = 1), or of the one before (-1), if any."""
    numbers = range(number + 1, len(file.lines) + 1) if steps > 0 else range(number - 1, 0, -1)
    if not any(file.moves):
        makers = file.makers
        return next(
            (each for each in numbers if makers[each - 1] and makers[each - 2 : each - 1] != (makers[each - 1],)),
            number,
        )
    return next((each for each in numbers if file.moves[each - 1] is not None), number)


def page_html(file: TextFile, number: int, made_by: Source) -> str:
    """Page of a file around a line, which is marked; lines of the selected stroke are tinted.

    Args:
        file: The file.
        number: The line, from 1.
        made_by: The selected stroke; empty for none.
    """
    first = min(max(number - 1 - _LEAD, 0), max(len(file.lines) - PAGE_LINES, 0))
    shown = file.lines[first : first + PAGE_LINES]
    indent = min((len(text) - len(text.lstrip()) for text in shown if text.strip()), default=0)
    rows = ""
    for at, text in enumerate(shown, start=first + 1):
        style = f"background:{_SELECTED}" if made_by and file.makers[at - 1] == made_by else ""
        if at == number:
            style = f"background:{_CHOSEN};box-shadow:inset 3px 0 {css_colour(ACCENT)}"
        rows += (
            f'<div style="{style}"><span style="display:inline-block;width:44px;padding-right:8px;text-align:right;'
            f'color:{css_colour(QUIET)}">{at}</span>{escape(text[indent:])} </div>'
        )
    return (
        f'<div tabindex="0" style="margin:2px 10px;border:1px solid {LINE_COLOUR};border-radius:3px;overflow-x:auto;'
        f'font-family:monospace;font-size:11px;line-height:1.5;white-space:pre;color:{css_colour(INK)}">'
        f'<div style="display:inline-block;min-width:100%">{rows}</div></div>'
    )


def zip_bytes(files: Mapping[str, bytes]) -> bytes:
    """Files as a zip with a fixed time stamp, so that the same program gives the same bytes."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name, _ZIP_TIME), content, zipfile.ZIP_DEFLATED)
    return packed.getvalue()
