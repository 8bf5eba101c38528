"""The text of an IDF file, cut into sections and records."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from boards.bounds import FARTHEST_MM, MOST_CORNERS, MOST_TURN_DEG, number_within
from boards.errors import BoardError, Line, read_bytes
from boards.formats.loops import CHAIN_MM, arc, arc_between, is_too_far
from geometry.arrays import Points2

_TOKEN = re.compile(r'"([^"]*)"|(\S+)')
_SAME_MM = 1e-6
_FULL_TURN_DEG = 360.0
_LARGEST = 1e9
_FULL_RAD = math.radians(359.99)
_UNITS_MM = {"MM": 1.0, "THOU": 0.0254, "TNM": 1e-5}
"""TNM, ten nanometres, is in IDF 2.0 only."""


@dataclass(frozen=True, slots=True)
class Record(Line):
    """One line and its fields."""

    fields: tuple[str, ...]

    def number(self, place: int, name: str) -> float:
        """Field at a place as a finite number that has no unit.

        Raises:
            BoardError: It is missing or no number.
        """
        return self._bounded(place, name, _LARGEST, 1.0)

    def length(self, place: int, name: str, scale_mm: float) -> float:
        """Field at a place as a length or coordinate, mm.

        Args:
            place: From 0.
            name: In the message.
            scale_mm: Length of the file's unit, mm.

        Raises:
            BoardError: It is missing, no number, or farther than a board reaches.
        """
        return self._bounded(place, name, FARTHEST_MM, scale_mm)

    def angle(self, place: int, name: str, most_deg: float = MOST_TURN_DEG) -> float:
        """Field at a place as an angle, degrees in the file and radians here.

        Raises:
            BoardError: It is missing, no number, or larger.
        """
        return math.radians(self._bounded(place, name, most_deg, 1.0))

    def _bounded(self, place: int, name: str, bound: float, scale: float) -> float:
        stated = self.fields[place] if place < len(self.fields) else "nothing"
        value = number_within(stated, bound, scale)
        if math.isnan(value):
            message = f"{name} must be a number within ±{bound / scale:g}, not {stated[:40]!r}"
            raise self.error(f"{message}. Correct it or export the board again.")
        return value


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
        raise Line(path, 1).error("not an IDF file: it must begin with .HEADER. Export it again as IDF 3.0.")
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
            before = f"before {word[:40]!r} (opened in line {opening.line})"
            raise record.error(f".END_{_name(opening)} is expected {before}.")
    if opening is not None:
        raise opening.error(f".END_{_name(opening)} is missing. The file is incomplete: export or copy it again.")
    return tuple(sections)


def _name(opening: Record) -> str:
    return opening.fields[0].upper().removeprefix(".")


def _records(path: Path) -> list[Record]:
    data = read_bytes(path)
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
                raise Line(path, number).error("not a text file. Export it again as IDF 3.0.")
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
    corners = 0
    run: list[tuple[Record, float, float, float]] = []
    for record in records:
        label = record.number(0, "loop label")
        if run and label != run[0][0].number(0, "loop label"):
            raise _unclosed(run)
        x, y = record.length(1, "x", scale_mm), record.length(2, "y", scale_mm)
        run.append((record, x, y, record.angle(3, "included angle", _FULL_TURN_DEG)))
        ring = _ring(run)
        if ring is not None:
            corners += len(ring)
            if corners > MOST_CORNERS:
                message = f"the outline has more than {MOST_CORNERS:,} corners, arcs as chords"
                raise record.error(f"{message}. Export it with fewer and smaller pieces.")
            ring = ring[np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) > _SAME_MM]  # no point repeats the one before
            if len(ring) < 3:
                start = f"the loop that starts in line {run[0][0].line} encloses nothing"
                raise record.error(f"{start}. Correct it or export the board again.")
            loops.append((int(label), ring))
            run = []
    if run:
        raise _unclosed(run)
    return loops


def _unclosed(run: list[tuple[Record, float, float, float]]) -> BoardError:
    first, x, y, _ = run[0]
    start = f"the loop that starts in line {first.line} at {spot_mm(np.array([x, y]))} does not return to its start"
    return run[-1][0].error(f"{start}. Close it or export the board again.")


def _ring(run: list[tuple[Record, float, float, float]]) -> Points2 | None:
    """Return the loop if it is a circle, or if its last point is its first one again."""
    record, x, y, turn = run[-1]
    if abs(turn) > _FULL_RAD:
        if len(run) != 2:
            raise record.error("a full circle must be a loop of two points: its centre, then a point on it.")
        return arc(np.array([x, y]), np.array(run[0][1:3]), math.copysign(2.0 * math.pi, turn))[:-1]
    if len(run) < 3 or math.hypot(x - run[0][1], y - run[0][2]) > CHAIN_MM:
        return None
    for (_, ax, ay, _), (point, bx, by, sweep) in pairwise(run):
        if is_too_far(np.array([ax, ay]), np.array([bx, by]), sweep):
            raise point.error("nearly a full turn between two places is an arc that leads more than 10 m away.")
    pieces = [
        arc_between(np.array([ax, ay]), np.array([bx, by]), turn)[:-1]
        for (_, ax, ay, _), (_, bx, by, turn) in pairwise(run)
    ]
    return np.concatenate(pieces)


def spot_mm(point: Points2) -> str:
    """Describe a point in a message."""
    return f"({point[0]:z.3f}, {point[1]:z.3f}) mm"
