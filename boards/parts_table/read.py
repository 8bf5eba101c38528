"""A table of placements or a bill of materials, from whatever program wrote it."""

import csv
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

from boards.board import Side
from boards.bounds import FARTHEST_MM, MOST_TURN_DEG, number_within
from boards.errors import BoardError, Line, read_bytes

Column: TypeAlias = Literal[
    "ref", "package", "value", "part", "x", "y", "rotation", "side", "pins", "standoff", "height"
]

_NAMES: dict[Column, str] = {
    "ref": "ref refdes reference references designator designators referencedesignator referencedesignators"
    " refdesignator refdesignators partreference componentreference",
    "package": "package footprint pattern packagename footprintname pcbfootprint packagereference casesize case",
    "value": "val value comment designation componentvalue",
    "part": "mpn partnumber manufacturerpartnumber manufacturerpart mfrpartnumber mfrpn mfgpartnumber mfgpn partno pn"
    " part",
    "x": "posx midx centerx centrex xposition positionx xcoord xcoordinate coordx locationx xloc x refx",
    "y": "posy midy centery centrey yposition positiony ycoord ycoordinate coordy locationy yloc y refy",
    "rotation": "rot rotation angle orientation",
    "side": "side layer boardside mountside mountingside tb topbottom",
    "pins": "pins pincount numberofpins padcount pads",
    "standoff": "standoff standoffheight",
    "height": "height componentheight maxheight bodyheight",
}
"""Names of columns without blanks, marks and units; the earlier one wins where a table has several."""

_UNITS_MM = {
    "mm": 1.0,
    "mil": 0.0254,
    "mils": 0.0254,
    "thou": 0.0254,
    "in": 25.4,
    "inch": 25.4,
    "inches": 25.4,
    '"': 25.4,
}
_UNIT = re.compile(r"(?:mm|mils?|thou|inch(?:es)?|in)$")
_VALUE = re.compile(r"([-+]?[\d.,]+(?:e[-+]?\d+)?)\s*([a-z\"°]*)", re.IGNORECASE)
_SIDES: dict[str, Side] = {
    **dict.fromkeys(("top", "t", "front", "f", "fcu", "toplayer", "toplayertop", "componentside", "primary"), "top"),
    **dict.fromkeys(("bottom", "b", "bot", "back", "bcu", "bottomlayer", "solderside", "secondary"), "bottom"),
}
_NO_SIDE = frozenset({"", "tb", "bt", "both", "na"})
"""One line of a bill of materials may stand for parts on both sides."""

_RANGE = re.compile(r"([A-Za-z]+)(\d{1,9})\s*-\s*([A-Za-z]+)(\d{1,9})")
_HEADER_LINES = 40


@dataclass(frozen=True, slots=True)
class Row:
    """One component in one line; ``None`` or an empty text is not stated. Lengths in mm, as in the table."""

    line: int
    ref: str
    package: str = ""
    value: str = ""
    part: str = ""
    pins: int | None = None
    gap_height_mm: float | None = None
    height_mm: float | None = None
    side: Side | None = None
    xy_mm: tuple[float, float] | None = None
    turn_deg: float | None = None


@dataclass(frozen=True, slots=True)
class _Head:
    """Where the columns are, and their units."""

    line: int
    columns: dict[Column, int]
    titles: tuple[str, ...]
    units_mm: dict[Column, float]


def read_table(path: Path) -> tuple[Row, ...]:
    """Read a parts table: commas, semicolons, tabs, or the blanks of a KiCad ``.pos`` file.

    Raises:
        BoardError: The file cannot be read, no line names the columns, or a cell does not fit its column.
    """
    text = _read(path)
    # The most frequent delimiter of the beginning first; blanks, the form of KiCad's ASCII, last.
    for delimiter in (*sorted(",;\t", key=lambda mark: -text[:20_000].count(mark)), " "):
        lines = list(_split(text, delimiter))
        head = _find_head(lines, text)
        if head is not None:
            stated = ((line, cells) for line, cells in lines if line > head.line and any(map(str.strip, cells)))
            rows = tuple(row for line, cells in stated for row in _Cells(path, line, head, cells).rows())
            if not rows:
                raise BoardError("the table has no row with a reference designator.", file=path)
            return rows
    raise BoardError(
        "no line names the columns. The first line must state which column is the reference designator (Ref, "
        "Designator) and what the others are (Package, Value, PosX, PosY, Side, Pins, Standoff, Height …).",
        file=path,
    )


def _read(path: Path) -> str:
    data = read_bytes(path, "parts table")
    encodings = ("utf-16",) if data[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "cp1252", "latin-1")
    for encoding in encodings:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise BoardError("not a text table. Export it as CSV.", file=path)


def _split(text: str, delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """Yield line number and cells; comments, except a header behind a ``#``, have no cells."""
    lines = text.splitlines()
    if delimiter == " ":
        yield from _split_blanks(lines)
        return
    reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=True)
    try:
        for cells in reader:
            yield reader.line_num, [] if cells and cells[0].startswith("##") else cells
    except csv.Error:
        # A field of more than 131,072 characters: no table of parts.
        return


def _split_blanks(lines: Sequence[str]) -> Iterator[tuple[int, list[str]]]:
    """Split at blanks, or where the titles begin: Altium Designer's columns hold blanks themselves, or nothing."""
    starts: list[int] = []
    for number, line in enumerate(lines, start=1):
        if not starts and re.match(r"designator\s", line, re.IGNORECASE):
            starts = [word.start() for word in re.finditer(r"\S+", line)]
        if starts and line.strip() and all(line[start - 1 : start] in ("", " ") for start in starts[1:]):
            yield number, [line[start:end].strip() for start, end in zip(starts, [*starts[1:], None], strict=True)]
        else:
            yield number, [] if line.startswith("##") else line.removeprefix("#").split()


def _find_head(lines: Sequence[tuple[int, list[str]]], text: str) -> _Head | None:
    """The first line that names the reference and one more column; a list called Part, Value … means the reference."""
    stated = re.search(r"^(?:##\s*unit\s*=|units used:)\s*([a-z]+)", text, re.IGNORECASE | re.MULTILINE)
    default_mm = _UNITS_MM.get(stated[1].lower(), 1.0) if stated else 1.0
    for line, cells in lines[:_HEADER_LINES]:
        columns: dict[Column, int] = {}
        plain = [_plain(cell) for cell in cells]
        for column, names in _NAMES.items():
            hits = [plain.index(name) for name in names.split() if name in plain]
            if hits:
                columns[column] = hits[0]
        if "ref" not in columns and plain[:1] == ["part"]:
            columns["ref"] = columns.pop("part", 0)
        if "ref" in columns and len(columns) > 1:
            units: dict[Column, float] = {}
            for column, place in columns.items():
                words = re.split(r"[^a-z]+", cells[place].lower())[1:]
                units[column] = next((_UNITS_MM[word] for word in words if word in _UNITS_MM), default_mm)
            return _Head(line, columns, tuple(cell.strip() for cell in cells), units)
    return None


def _plain(title: str) -> str:
    """Title without brackets and their content, unit, marks and case."""
    bare = re.sub(r"[(\[][^()\[\]]*[)\]]", "", title.strip().lstrip("#"))
    words = [word for word in re.split(r"[^a-z0-9]+", bare.lower()) if word]
    if len(words) > 1 and _UNIT.fullmatch(words[-1]):
        words = words[:-1]
    return "".join(words)


@dataclass(frozen=True, slots=True)
class _Cells(Line):
    """One line of the table."""

    head: _Head
    cells: list[str]

    def rows(self) -> Iterator[Row]:
        """One row for each reference designator of the line."""
        refs = _expand(self.text("ref"))
        x, y = self.length("x"), self.length("y")
        for ref in refs:
            yield Row(
                self.line,
                ref,
                package=self.text("package").rpartition(":")[2],
                value=self.text("value"),
                part=self.text("part"),
                pins=self.count("pins"),
                gap_height_mm=self.gap("standoff"),
                height_mm=self.gap("height"),
                side=self.side(),
                xy_mm=(x, y) if x is not None and y is not None and len(refs) == 1 else None,
                turn_deg=self.angle("rotation"),
            )

    def text(self, column: Column) -> str:
        place = self.head.columns.get(column)
        return self.cells[place].strip() if place is not None and place < len(self.cells) else ""

    def refusal(self, column: Column, message: str) -> BoardError:
        title = self.head.titles[self.head.columns[column]].lstrip("# ")
        return self.error(f"column {title}: {self.text(column)[:40]!r} {message}")

    def length(self, column: Column) -> float | None:
        """Length in mm, its unit in the cell or in the title; a decimal comma is understood."""
        text = self.text(column)
        if not text or text in ("-", "~", "N/A", "n/a"):
            return None
        hit = _VALUE.fullmatch(text)
        unit = hit[2].lower() if hit else ""
        if hit is None or (unit and unit not in _UNITS_MM):
            raise self.refusal(column, "is not a length. Write a number, such as 12.3 or 12.3mm.")
        number = hit[1]
        if "," in number and "." in number:  # the last mark of the two is the decimal one
            number = number.replace("," if number.rindex(".") > number.rindex(",") else ".", "")
        unit_mm = _UNITS_MM[unit] if unit else self.head.units_mm[column]
        value = number_within(number.replace(",", "."), FARTHEST_MM, unit_mm)
        if math.isnan(value):
            raise self.refusal(column, f"is not a length within ±{FARTHEST_MM / unit_mm:g}. Correct it.")
        return value

    def gap(self, column: Column) -> float | None:
        value = self.length(column)
        if value is not None and value < 0.0:
            raise self.refusal(column, "must not be negative.")
        return value

    def angle(self, column: Column) -> float | None:
        """Angle in degrees; a decimal comma and a sign for degrees are understood, other texts are no angle."""
        text = self.text(column).rstrip("°").removesuffix("deg").strip()
        value = number_within(text.replace(",", "."), MOST_TURN_DEG)
        return None if math.isnan(value) else value

    def count(self, column: Column) -> int | None:
        text = self.text(column)
        if not text:
            return None
        if not re.fullmatch(r"\d{1,6}(?:[.,]0+)?", text):
            raise self.refusal(column, "is not a number of pins. Write a whole number.")
        return int(re.split("[.,]", text)[0])

    def side(self) -> Side | None:
        text = re.sub(r"[^a-z]", "", self.text("side").lower())
        if text in _NO_SIDE:
            return None
        side = _SIDES.get(text)
        if side is None:
            raise self.refusal("side", "is neither top nor bottom.")
        return side


def _expand(text: str) -> list[str]:
    """``C1, C2 C5-C7`` as single references, each once."""
    refs: list[str] = []
    for word in re.sub(r"\s*-\s*", "-", text).replace(",", " ").replace(";", " ").split():
        span = _RANGE.fullmatch(word)
        if span and span[1] == span[3] and int(span[2]) <= int(span[4]) < int(span[2]) + 1000:
            refs.extend(f"{span[1]}{number}" for number in range(int(span[2]), int(span[4]) + 1))
        else:
            refs.append(word)
    return list(dict.fromkeys(refs))
