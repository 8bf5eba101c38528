"""The text of an IDF file, cut into sections and records."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from boards.errors import BoardError
from boards.formats.loops import CHAIN_MM, arc, arc_between
from geometry.arrays import Points2

_TOKEN = re.compile(r'"([^"]*)"|(\S+)')
_SAME_MM = 1e-6
_FULL_RAD = math.radians(359.99)
_UNITS_MM = {"MM": 1.0, "THOU": 0.0254, "TNM": 1e-5}
"""TNM, ten nanometres, is in IDF 2.0 only."""


@dataclass(frozen=True, slots=True)
class Record:
    """One line: its fields, and where it stands."""

    file: Path
    line: int
    fields: tuple[str, ...]

    def number(self, place: int, name: str) -> float:
        """Field at a place as a finite number.

        Raises:
            BoardError: It is missing or no number.
        """
        try:
            value = float(self.fields[place])
        except (IndexError, ValueError):
            value = math.nan
        if not math.isfinite(value):
            stated = self.fields[place] if place < len(self.fields) else "nothing"
            raise self.error(f"{name} must be a number, not {stated[:40]!r}. Correct it or export the board again.")
        return value

    def error(self, message: str) -> BoardError:
        """Build the error that names this line."""
        return BoardError(message, file=self.file, line=self.line)


@dataclass(frozen=True, slots=True)
class Section:
    """From ``.NAME`` to ``.END_NAME``."""

    name: str
    opening: Record
    records: tuple[Record, ...]

    def need(self, count: int) -> None:
        """Raise if the section has fewer records than this."""
        if len(self.records) < count:
            raise self.opening.error(f".{self.name} is incomplete. Export the board again.")


def read_sections(path: Path) -> tuple[Section, ...]:
    """Cut a file into its sections; comments and blank lines are gone.

    Raises:
        BoardError: The file cannot be read or is no IDF file, or a section does not end.
    """
    records = _records(path)
    if not records or records[0].fields[0].upper() != ".HEADER":
        raise BoardError("not an IDF file: it must begin with .HEADER. Export it again as IDF 3.0.", file=path, line=1)
    sections: list[Section] = []
    opening: Record | None = None
    start = 0
    for number, record in enumerate(records):
        word = record.fields[0].upper()
        if opening is None:
            if not word.startswith(".") or word.startswith(".END"):
                raise record.error(f"a section such as .PLACEMENT is expected here, not {word[:40]!r}.")
            opening, start = record, number + 1
        elif word == f".END_{_name(opening)}":
            sections.append(Section(_name(opening), opening, tuple(records[start:number])))
            opening = None
        elif word.startswith("."):
            raise record.error(
                f".END_{_name(opening)} is expected before {word[:40]!r} (opened in line {opening.line})."
            )
    if opening is not None:
        raise opening.error(f".END_{_name(opening)} is missing. The file is incomplete: export or copy it again.")
    return tuple(sections)


def _name(opening: Record) -> str:
    return opening.fields[0].upper().removeprefix(".")


def _records(path: Path) -> list[Record]:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise BoardError(f"cannot be read ({error.strerror}).", file=path) from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Older tools write the code page of their country; only names can differ.
        text = data.decode("latin-1")
    records: list[Record] = []
    for number, line in enumerate(text.splitlines(), start=1):
        if line.lstrip()[:1] not in ("", "#"):
            fields = tuple(quoted or plain for quoted, plain in _TOKEN.findall(line))
            if "\0" in line or not fields:
                raise BoardError("not a text file. Export it again as IDF 3.0.", file=path, line=number)
            records.append(Record(path, number, fields))
    return records


def unit_mm(record: Record, place: int) -> float:
    """Length of the unit named in a field, mm."""
    name = record.fields[place].upper() if place < len(record.fields) else ""
    if name not in _UNITS_MM:
        raise record.error(f"the unit {name[:40]!r} is not known. Write MM or THOU.")
    return _UNITS_MM[name]


def read_loops(records: Sequence[Record], scale_mm: float) -> list[tuple[int, Points2]]:
    """Closed loops of label, x, y and included angle, one point a record.

    The angle is that of the arc from the point before; 360° is a circle about the point before.

    Args:
        records: Records of one outline.
        scale_mm: Length of the file's unit, mm.

    Returns:
        Label and open ring ``(n, 2)`` in mm of each loop, in file order.

    Raises:
        BoardError: A record has no numbers, or a loop does not close.
    """
    loops: list[tuple[int, Points2]] = []
    run: list[tuple[Record, float, float, float]] = []
    for record in records:
        label = record.number(0, "loop label")
        if run and label != run[0][0].number(0, "loop label"):
            raise _unclosed(run)
        x, y = record.number(1, "x") * scale_mm, record.number(2, "y") * scale_mm
        run.append((record, x, y, math.radians(record.number(3, "included angle"))))
        ring = _circle(run) if abs(run[-1][3]) > _FULL_RAD else _ring(run)
        if ring is not None:
            loops.append((int(label), _distinct(ring, run)))
            run = []
    if run:
        raise _unclosed(run)
    return loops


def _distinct(ring: Points2, run: list[tuple[Record, float, float, float]]) -> Points2:
    """Leave out points that repeat the one before."""
    ring = ring[np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) > _SAME_MM]
    if len(ring) < 3:
        raise run[-1][0].error(
            f"the loop that starts in line {run[0][0].line} encloses nothing. Correct it or export the board again."
        )
    return ring


def _unclosed(run: list[tuple[Record, float, float, float]]) -> BoardError:
    _, x, y, _ = run[0]
    return run[-1][0].error(
        f"the loop that starts in line {run[0][0].line} at ({x:.3f}, {y:.3f}) mm does not return to its start. "
        "Close it or export the board again."
    )


def _circle(run: list[tuple[Record, float, float, float]]) -> Points2:
    if len(run) != 2:
        raise run[-1][0].error("a full circle must be a loop of two points: its centre, then a point on it.")
    (_, cx, cy, _), (_, x, y, turn) = run
    turn = math.copysign(2.0 * math.pi, turn)
    return arc(np.array([x, y]), np.array([cx, cy]), turn)[:-1]


def _ring(run: list[tuple[Record, float, float, float]]) -> Points2 | None:
    """Return the loop if its last point is its first one again."""
    if len(run) < 3 or math.hypot(run[-1][1] - run[0][1], run[-1][2] - run[0][2]) > CHAIN_MM:
        return None
    pieces = [
        arc_between(np.array([ax, ay]), np.array([bx, by]), turn)[:-1]
        for (_, ax, ay, _), (_, bx, by, turn) in pairwise(run)
    ]
    return np.concatenate(pieces)


def spot_mm(point: Points2) -> str:
    """Say a point for a message."""
    return f"({point[0]:.3f}, {point[1]:.3f}) mm"
