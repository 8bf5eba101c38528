"""The text files of an ODB++ job: records, arrays, units, and what contours draw."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

import numpy as np

from boards.bounds import FARTHEST_MM, MOST_CORNERS, MOST_TURN_DEG, number_within
from boards.errors import Line
from boards.formats.loops import Point2, arc_about
from geometry.arrays import Points2

AGAIN = "Export the board again as ODB++."
_UNITS_MM = {"MM": 1.0, "INCH": 25.4}
_KEY = re.compile(r"\s*([A-Za-z_0-9]+)\s*=(.*)")


@dataclass(frozen=True, slots=True)
class Record(Line):
    """One line of a file inside the job."""

    words: tuple[str, ...]
    rest: str
    """What follows the first semicolon."""
    scale_mm: float
    """Length of the file's unit, mm."""

    def length(self, place: int, name: str) -> float:
        """Word at a place as a length or coordinate, mm.

        Raises:
            BoardError: It is missing, no number, or farther than a board reaches.
        """
        return self._number(place, name, FARTHEST_MM, self.scale_mm)

    def angle(self, place: int, name: str) -> float:
        """Word at a place as an angle, degrees in the file and radians here."""
        return math.radians(self._number(place, name, MOST_TURN_DEG, 1.0))

    def count(self, place: int, name: str) -> int:
        """Word at a place as a whole number from 0."""
        value = self._number(place, name, 1e9, 1.0)
        if value != int(value) or value < 0.0:
            raise self.error(f"{name} must be a whole number, not {self.words[place][:40]!r}. {AGAIN}")
        return int(value)

    def point(self, place: int) -> Point2:
        """Two words from a place as a point, mm."""
        return np.array([self.length(place, "x"), self.length(place + 1, "y")])

    def _number(self, place: int, name: str, bound: float, scale: float) -> float:
        stated = self.words[place] if place < len(self.words) else "nothing"
        value = number_within(stated, bound, scale)
        if math.isnan(value):
            message = f"{name} must be a number within ±{bound / scale:g}, not {stated[:40]!r}"
            raise self.error(f"{message}. {AGAIN}")
        return value


def read_records(content: bytes, file: Path, default_mm: float) -> Iterator[Record]:
    """Yield the records of a line record file with the unit that holds for each; comments are gone.

    Args:
        content: Of the file.
        file: Its path, that of the job included, for messages.
        default_mm: Length of the unit where the file states none, mm.

    Raises:
        BoardError: A stated unit is not known.
    """
    scale = default_mm
    for number, line in enumerate(_lines(content), start=1):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        key = _KEY.match(line)
        if key and key[1].upper() in ("UNITS", "U"):
            scale = unit_mm(key[2].strip(), Line(file, number))
            continue
        if line.startswith("U ") and line[2:].strip().upper() in _UNITS_MM:
            scale = _UNITS_MM[line[2:].strip().upper()]
            continue
        stated, _, rest = line.partition(";")
        yield Record(file, number, tuple(stated.split()), rest, scale)


def _lines(content: bytes) -> Iterator[str]:
    """Yield the lines one by one: the text is not doubled in memory."""
    start = 0
    while start < len(content):
        end = content.find(b"\n", start)
        end = len(content) if end < 0 else end
        yield content[start:end].decode("utf-8", "replace")
        start = end + 1


def unit_mm(word: str, line: Line) -> float:
    """Length of a unit, mm.

    Raises:
        BoardError: It is neither MM nor INCH.
    """
    if word.upper() not in _UNITS_MM:
        raise line.error(f"the unit {word[:40]!r} is not known; it is MM or INCH. {AGAIN}")
    return _UNITS_MM[word.upper()]


@dataclass(frozen=True, slots=True)
class Array(Line):
    """An array of a structured text file, such as ``LAYER { … }``; keys in upper case."""

    name: str
    values: dict[str, str]

    @property
    def named(self) -> str:
        """Its name as a folder's, in small letters."""
        return self.values.get("NAME", "").lower()

    @property
    def kind(self) -> str:
        """Type of a layer."""
        return self.values.get("TYPE", "").upper()


def read_structure(content: bytes, file: Path) -> tuple[dict[str, str], list[Array]]:
    """Read a structured text file: its keys, and its arrays in file order.

    Raises:
        BoardError: An array does not end.
    """
    keys: dict[str, str] = {}
    arrays: list[Array] = []
    opened: Array | None = None
    for number, line in enumerate(_lines(content), start=1):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        if line.endswith("{"):
            opened = Array(file, number, line[:-1].strip().upper(), {})
        elif line == "}" and opened is not None:
            arrays.append(opened)
            opened = None
        elif key := _KEY.match(line):
            (keys if opened is None else opened.values)[key[1].upper()] = key[2].strip()
    if opened is not None:
        raise opened.error(f"the array {opened.name[:40]} does not end. {AGAIN}")
    return keys, arrays


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """A closed contour, mm."""

    ring: Points2
    """(n, 2) without a repeated first point."""
    is_hole: bool


def read_contours(records: Sequence[Record]) -> list[Contour]:
    """Read ``OB``, ``OS``, ``OC`` and ``OE`` records: lines, and arcs about their centres.

    Raises:
        BoardError: A contour does not end, a number is missing, or together they have too many corners.
    """
    contours: list[Contour] = []
    pieces: list[Points2] = []
    first: Record | None = None
    corners = 0
    for record in records:
        word = record.words[0].upper() if record.words else ""
        if word == "OB":
            first, pieces = record, [record.point(1)[None, :]]
        elif first is None:
            continue
        elif word == "OS":
            pieces.append(record.point(1)[None, :])
        elif word == "OC":
            pieces.append(_curve(pieces[-1][-1], record))
        elif word == "OE":
            ring = np.concatenate(pieces)
            ring = ring[np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) > 1e-6]
            if len(ring) > 2:
                contours.append(Contour(ring, len(first.words) > 3 and first.words[3].upper() == "H"))
            first = None
        corners += len(pieces[-1])
        if corners > 10 * MOST_CORNERS:
            raise record.error(f"more than {10 * MOST_CORNERS:,} corners, arcs as chords. That is no board.")
    if first is not None:
        raise first.error(f"a contour does not end with OE. {AGAIN}")
    return contours


def _curve(start: Point2, record: Record) -> Points2:
    clockwise = len(record.words) < 6 or record.words[5].upper().startswith("Y")
    points = arc_about(start, record.point(1), record.point(3), clockwise=clockwise)
    if points is None:
        raise record.error(f"the ends of an arc are not equally far from its centre. {AGAIN}")
    return points[1:]


def quoted(text: str) -> str:
    """Return the text between the quotes of a property."""
    return text.split("'", 2)[1] if text.count("'") >= 2 else text


def attributes(rest: str) -> Iterator[tuple[str, str]]:
    """Yield the pairs of an attribute list, such as ``0=1,3=2.5``; flags have an empty value."""
    for pair in takewhile(bool, rest.split(";")[0].split(",")):
        key, _, value = pair.strip().partition("=")
        yield key, value
