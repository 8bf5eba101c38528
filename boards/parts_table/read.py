"""A table of placements or a bill of materials, from whatever program wrote it."""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import islice
from pathlib import Path
from typing import TypeAlias

from boards.board import Side
from boards.bounds import FARTHEST_MM, MOST_TURN_DEG, number_within
from boards.errors import BoardError, Line, read_bytes
from boards.parts_table.columns import COLUMNS_FILE, NOTHING_STATED, Column, Stated
from boards.parts_table.split import PADS, Lines, blank, marked, marks_in, pads_parts, untitled

Tables: TypeAlias = Path | Sequence[Path] | None
"""Tables that are joined to a board by designator, in any order."""

_NAMES: dict[Column, str] = {
    "ref": "ref refdes refid partid reference references designator designators referencedesignator"
    " referencedesignators refdesignator refdesignators partreference componentreference parts",
    "package": "package footprint symname pattern packagename footprintname pcbfootprint packagereference casesize"
    " case",
    "value": "val value comment designation componentvalue compvalue",
    "part": "mpn partnumber manufacturerpartnumber manufacturerpart mfrpartnumber mfrpn mfgpartnumber mfgpn partno pn"
    " part comppartnumber device",
    "x": "posx midx centerx centrex xposition positionx xcoord xcoordinate coordx locationx xloc symx x refx",
    "y": "posy midy centery centrey yposition positiony ycoord ycoordinate coordy locationy yloc symy y refy",
    "rotation": "rot rotation symrotate rotate angle orientation theta",
    "side": "side layer boardside mountside mountingside tb topbottom symmirror mirror mirrored",
    "pins": "pins pincount numberofpins padcount pads",
    "standoff": "standoff standoffheight",
    "height": "height componentheight compheight symheight maxheight bodyheight",
    "fitted": "fitted populate populated mount mounted assemble assembled stuff fit populatedstatus fitstatus",
    "omitted": "dnp dni dnf dns donotpopulate donotplace donotfit donotmount donotstuff notfitted notpopulated nofit"
    " notmounted nopop excluded",
}
"""Names of columns without blanks, marks and units; the earlier one wins where a table has several."""

_KNOWN = frozenset(name for names in _NAMES.values() for name in names.split()) | {"padx", "pady"}
_PLACE_COLUMNS: tuple[Column, ...] = ("x", "y", "rotation")
_MEASURES = frozenset(name for key in _PLACE_COLUMNS for name in _NAMES[key].split()) | {"padx", "pady"}

_UNITS_MM = {
    "mm": 1.0,
    "millimeter": 1.0,
    "millimeters": 1.0,
    "millimetres": 1.0,
    "mil": 0.0254,
    "mils": 0.0254,
    "thou": 0.0254,
    "in": 25.4,
    "inch": 25.4,
    "inches": 25.4,
    '"': 25.4,
}
UNIT_NAMES = {1.0: "mm", 0.0254: "mil", 25.4: "inch"}
_UNIT_WORDS = "|".join(sorted((re.escape(word) for word in _UNITS_MM if word != '"'), key=len, reverse=True))
_UNIT_LINE = re.compile(
    rf"[^\w\r\n]*(?:u?units?(?: used)?\s*[=:]|x\s*,\s*y\s+in\s)(?:[^\r\n]*?[^a-z\r\n])??({_UNIT_WORDS})\b",
    re.IGNORECASE,
)
_UNIT_OF_EXTRACT = re.compile(rf"J!.*!({_UNIT_WORDS})!", re.IGNORECASE)
_UNITS_OF_PADS = {"MILS": "mil", "METRIC": "mm", "INCHES": "inch", "BASIC": "mil"}
_YES = frozenset(
    {"yes", "y", "true", "t", "1", "x", "fitted", "populated", "mounted", "placed", "ok", "fit", "populate"}
)
_NO = frozenset({"no", "n", "false", "f", "0"})
_NOT_FITTED = frozenset(
    {"dnp", "dni", "dnf", "dns", "dnm", "nf", "nofit", "nopop", "donotpopulate", "donotplace", "donotfit", "donotmount"}
    | {"donotstuff", "donotinstall", "notfitted", "notpopulated", "notmounted", "notplaced", "notassembled", "excluded"}
)
_UNIT = re.compile(r"(?:mm|mils?|thou|inch(?:es)?|in)$")
_VALUE = re.compile(r"([-+]?[\d.,]+(?:e[-+]?\d+)?)\s*([a-z\"°]*)", re.IGNORECASE)
_SIDES: dict[str, Side] = {
    **dict.fromkeys(
        ("top", "t", "no", "n", "false", "front", "f", "fcu", "toplayer", "toplayertop", "componentside", "primary"),
        "top",
    ),
    **dict.fromkeys(
        (
            "bottom",
            "b",
            "bot",
            "yes",
            "y",
            "m",
            "mirrored",
            "true",
            "back",
            "bcu",
            "bottomlayer",
            "solderside",
            "secondary",
        ),
        "bottom",
    ),
}
_NO_SIDE = frozenset({"", "tb", "bt", "both", "na"})
"""One line of a bill of materials may stand for parts on both sides."""

_RANGE = re.compile(r"([A-Za-z]+)(\d{1,9})\s*-\s*([A-Za-z]+)(\d{1,9})")
_HEADER_LINES = 40
_CELLS = 1000
"""Places in which a unit is looked for, where no title states it."""
_HEAD_CHARS = 200_000
"""A text whose beginning is none of a table is not read further."""


_TABLE_SUFFIXES = (".csv", ".tsv", ".txt", ".pos", ".xy", ".mnt", ".mnb", ".rpt", ".pnp", ".bom", ".asc")


class NoTableError(BoardError):
    """A text is no parts table."""


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
    is_fitted: bool = True
    file: str = ""
    """The first that names it."""
    merged: Mapping[str, str] = field(default_factory=dict[str, str])
    """By the name of what it leaves open: the other file that states it."""

    def source(self, key: str) -> str:
        """File that states one of its values."""
        return self.merged.get(key, self.file)


@dataclass(frozen=True, slots=True)
class PartsTable:
    """A table of placements or a bill of materials."""

    file: Path
    rows: tuple[Row, ...]
    unit: str
    """Of its places, and how it is known; empty where it is not stated in a title, a line above or the cells."""
    titles: Mapping[Column, str]


@dataclass(frozen=True, slots=True)
class _Head:
    """Where the columns are, and their units."""

    line: int
    columns: dict[Column, int]
    titles: tuple[str, ...]
    units_mm: dict[Column, float]
    unit: str


def _find_columns(plain: Sequence[str], stated: Stated) -> dict[Column, int]:
    """Columns by their plain titles."""
    columns: dict[Column, int] = {}
    for column, names in _NAMES.items():
        own = map(plain_title, stated.titles.get(column, ()))
        hits = [plain.index(name) for name in (*own, *names.split()) if name in plain]
        if hits:
            columns[column] = hits[0]
    if "ref" not in columns and plain[:1] == ["part"]:
        columns["ref"] = columns.pop("part", 0)
    if "ref" not in columns and {"name", "x", "y"} <= set(plain):  # Eagle 9 and Fusion call it so
        columns["ref"] = plain.index("name")
    elif "package" not in columns and {"name", "side"} <= set(plain):  # DipTrace
        columns["package"] = plain.index("name")
    if "package" not in columns and {"description", "topbottom"} <= set(plain):  # gEDA calls it so
        columns["package"] = plain.index("description")
    return columns


def _find_head(lines: Lines, unit: str | None, stated: Stated) -> _Head | None:
    """The first line that names the reference and one more column; a list called Part, Value … means the reference."""
    for line, cells in lines[:_HEADER_LINES]:
        columns = _find_columns([plain_title(cell) for cell in cells], stated)
        if "ref" in columns and len(columns) > 1:
            units: dict[Column, float] = {}
            known = "" if unit is None else unit
            for column, place in columns.items():
                words = re.split(r"[^a-z]+", cells[place].lower())[1:]
                own = next((_UNITS_MM[word] for word in words if word in _UNITS_MM), None)
                if column == "x" and own is not None:
                    known = f"{UNIT_NAMES[own]} (title)"
                of_places = _UNITS_MM[unit.split()[0]] if unit is not None and column in ("x", "y") else 1.0
                units[column] = own or of_places
            if "x" in columns and not known:
                at = (cells[columns["x"]] for number, cells in lines if number > line and len(cells) > columns["x"])
                hits = (re.search(r"\d\s*(mm|mils?|in|\")\s*$", cell, re.IGNORECASE) for cell in islice(at, _CELLS))
                known = next((f"{UNIT_NAMES[_UNITS_MM[hit[1].lower()]]} (cells)" for hit in hits if hit), "")
            return _Head(line, columns, tuple(cell.strip() for cell in cells), units, known)
    return None


def tables_of(parts: Tables) -> tuple[Path, ...]:
    """The tables that are given: none, one or several."""
    return () if parts is None else (parts,) if isinstance(parts, Path) else tuple(parts)


def is_table_name(name: str) -> bool:
    """Whether a file of an order may be a table, by its name."""
    return name.lower().endswith(_TABLE_SUFFIXES)


def read_table(path: Path, content: bytes | None = None, stated: Stated = NOTHING_STATED) -> PartsTable:
    """Read a parts table: cells between commas, semicolons, tabs, ``!`` or ``|``, or below titles of fixed width.

    Tables without titles are read where their lines are those of Eagle's or Allegro's placements.

    Args:
        path: Of the table.
        content: What is in it, where it was read out of an archive.
        stated: Titles and a unit that its owner states; they come before those that are known.

    Raises:
        NoTableError: No line names the columns.
        BoardError: The file cannot be read, or a cell does not fit its column.
    """
    text = _decoded(read_bytes(path, "parts table") if content is None else content, path)
    unit = _stated_unit(text)
    if unit is None and stated.file is not None and stated.model.unit is not None:
        unit = f"{stated.model.unit} ({stated.file.name})"
    own = {plain_title(title) for titles in stated.titles.values() for title in titles}
    places = {plain_title(title) for key in _PLACE_COLUMNS for title in stated.titles.get(key, ())}
    begin = text[: text.rfind("\n", 0, _HEAD_CHARS) + 1 or _HEAD_CHARS] if len(text) > _HEAD_CHARS else text
    for cut in _cutters(text, _KNOWN | own, _MEASURES | places):
        lines = cut(begin) or []
        if _find_head(lines, unit, stated) is not None:
            lines = lines if begin is text else cut(text) or lines
            head = _find_head(lines, unit, stated)
            if head is not None:
                return _table(path, head, lines)
    raise NoTableError(
        "no line names the columns. The first line must state which column is the reference designator (Ref, "
        "Designator) and what the others are (Package, Value, PosX, PosY, Side, Pins, Standoff, Height …), or "
        f"{COLUMNS_FILE} beside the board which titles they have.",
        file=path,
    )


def _cutters(text: str, titles: Set[str], measures: Set[str]) -> Iterator[Callable[[str], Lines | None]]:
    """Yield the ways to cut a text into cells, one after the other."""
    yield pads_parts
    yield from (partial(marked, mark=mark) for mark in marks_in(text))
    yield lambda part: blank(part, lambda each: plain_title(each) in titles, lambda each: plain_title(each) in measures)
    yield untitled


def _table(path: Path, head: "_Head", lines: Lines) -> PartsTable:
    marks = {"s"} if plain_title(head.titles[0]) == "a" else None  # Allegro's extract begins its lines with their kind
    stated = (
        (line, cells)
        for line, cells in lines
        if line > head.line
        and any(map(str.strip, cells))
        and not cells[0].startswith("#")
        and (marks is None or cells[0].strip().lower() in marks)
    )
    rows = tuple(row for line, cells in stated for row in _Cells(path, line, head, cells).rows())
    if not rows:
        raise BoardError("the table has no row with a reference designator.", file=path)
    if "side" not in head.columns and (side := _side_of_name(path.name)):
        rows = tuple(replace(row, side=side) for row in rows)
    titles: dict[Column, str] = {column: head.titles[place].lstrip("# ") for column, place in head.columns.items()}
    return PartsTable(path, rows, head.unit, titles)


def _side_of_name(name: str) -> Side | None:
    """Side that the name of a table without such a column states: one file a side is common."""
    words = re.split(r"[^a-z]+", name.lower())
    if words[-1] in ("mnt", "mnb"):  # Eagle's mountsmd
        return "top" if words[-1] == "mnt" else "bottom"
    found: set[Side] = {_SIDES[word] for word in words[:-1] if word in ("top", "bottom", "bot", "front", "back")}
    return next(iter(found)) if len(found) == 1 else None


def _stated_unit(text: str) -> str | None:
    """Unit of lengths that the lines above the titles state, and that they do."""
    for line in text[:20_000].splitlines()[:_HEADER_LINES]:
        if (hit := PADS.match(line)) is not None:
            return f"{_UNITS_OF_PADS[hit[1].upper()]} (line above)"
        hit = _UNIT_LINE.match(line) or _UNIT_OF_EXTRACT.match(line)
        if hit is not None:
            return f"{UNIT_NAMES[_UNITS_MM[hit[1].lower()]]} (line above)"
    return None


def _decoded(data: bytes, path: Path) -> str:
    encodings = ("utf-16",) if data[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "cp1252", "latin-1")
    for encoding in encodings:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise BoardError("not a text table. Export it as CSV.", file=path)


def plain_title(title: str) -> str:
    """Title without brackets and their content, unit, marks and case."""
    bare = re.sub(r"[(\[][^()\[\]]*[)\]]", "", title.strip().lstrip("#"))
    words = [word for word in re.split(r"[\W_]+", bare.lower()) if word]
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
                is_fitted=self.is_fitted(),
                file=self.file.name,
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

    def is_fitted(self) -> bool:
        """Whether the part is on the board: by the column that states it, or by a value such as ``DNP``."""
        fitted = _letters(self.text("value")) not in _NOT_FITTED
        columns: tuple[tuple[Column, bool], ...] = (("fitted", False), ("omitted", True))
        for column, marks in columns:
            text = _letters(self.text(column))
            if text in _NOT_FITTED or (marks and text in _YES) or (not marks and text in _NO):
                fitted = False
            elif text and text not in _YES | _NO:
                raise self.refusal(
                    column, "states neither that the part is fitted nor that it is not. Write yes or no."
                )
        return fitted

    def side(self) -> Side | None:
        text = _letters(self.text("side")).strip("0123456789")
        if text in _NO_SIDE:
            return None
        side = _SIDES.get(text)
        if side is None:
            raise self.refusal("side", "is neither top nor bottom.")
        return side


@lru_cache(maxsize=4096)
def _letters(text: str) -> str:
    """Small letters and digits of a cell; most cells of a column are alike."""
    return re.sub(r"[^a-z0-9]", "", text.lower())


def _expand(text: str) -> list[str]:
    """``C1, C2 C5-C7`` as single references, each once."""
    if text.isalnum():
        return [text]
    refs: list[str] = []
    for word in re.sub(r"\s*-\s*", "-", text).replace(",", " ").replace(";", " ").split():
        span = _RANGE.fullmatch(word)
        if span and span[1] == span[3] and int(span[2]) <= int(span[4]) < int(span[2]) + 1000:
            refs.extend(f"{span[1]}{number}" for number in range(int(span[2]), int(span[4]) + 1))
        else:
            refs.append(word)
    return list(dict.fromkeys(refs))
