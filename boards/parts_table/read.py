"""A table of placements or a bill of materials, from whatever program wrote it."""

import math
import re
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice, pairwise
from pathlib import Path
from typing import TypeAlias

from boards.board import Side
from boards.bounds import FARTHEST_MM, MOST_TURN_DEG, number_within
from boards.errors import BoardError, Line, read_bytes
from boards.parts_table.columns import COLUMNS_FILE, NOTHING_STATED, Column, Stated
from boards.parts_table.split import PADS, Lines, blank, is_designator, marked, marks_in, pads_parts, untitled
from boards.parts_table.words import (
    ALL_UNITS,
    KNOWN,
    MEASURES,
    NAMES,
    NO,
    NO_SIDE,
    NOT_FITTED,
    PLACE_COLUMNS,
    SIDES,
    UNIT_LINE,
    UNIT_OF_EXTRACT,
    UNITS_MM,
    YES,
    leaves_out,
    letters,
    plain_title,
    side_in,
    unaccented,
    unit_in,
    unit_of_cell,
)

Tables: TypeAlias = Path | Sequence[Path] | None
"""Tables that are joined to a board by designator, in any order."""

_UNITS_OF_PADS = {"MILS": "mil", "METRIC": "mm", "INCHES": "inch", "BASIC": "mil"}
_VALUE = re.compile(r"([-+]?[\d.,]+(?:e[-+]?\d+)?)\s*([^\W\d_]*|\"|°)", re.IGNORECASE)
_MOST_OF = re.compile(r"[ (]{0,3}(?:max|nom|typ)\.?\)?$", re.IGNORECASE)
"""Behind a height."""
_MINUS = "\u2212"
_LAYER = re.compile(r"l?(\d{1,4})", re.IGNORECASE)
"""A layer that a side column names by its number."""
_RANGE = re.compile(r"([A-Za-z]+)(\d{1,9})\s*-\s*([A-Za-z]+)(\d{1,9})")
_NO_PIECE = re.compile(r"0+(?:[.,]0+)?")
_UP_TO = re.compile(r"(?<=\d)(?: (?:to|bis|thru|through|à|至) | ?: ?)(?=[A-Za-z]{1,9}\d)", re.IGNORECASE)
_OR = re.compile(r"(?<=\d) ?/ ?(?=[A-Za-z]{1,9}\d)")
"""Marks between designators, besides the usual ones."""
_HEADER_LINES = 200
_UNIT_OF_CELLS = re.compile(r"\d\s*(mm|mils?|in|um|μm|cm|\")\s*$")
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
    states_fitted: bool = False
    """Whether a column states it."""
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
    layers: tuple[int, ...] = ()
    """Numbers by which the side column names layers, the least first."""


def _find_columns(plain: Sequence[str], stated: Stated) -> dict[Column, int]:
    """Columns by their plain titles."""
    columns: dict[Column, int] = {}
    for column, names in NAMES.items():
        own = map(plain_title, stated.titles.get(column, ()))
        hits = [plain.index(name) for name in (*own, *names) if name in plain]
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
    for number, (line, cells) in enumerate(lines[:_HEADER_LINES]):
        columns = _find_columns([plain_title(cell) for cell in cells], stated)
        if "ref" in columns and len(columns) > 1:
            units: dict[Column, float] = {}
            known = "" if unit is None else unit
            below = _units_below(columns, lines[number + 1 : number + 3])
            for column, place in columns.items():
                own = unit_in(cells[place]) or below.get(column)
                if column == "x" and own is not None:
                    known = f"{ALL_UNITS[own]} ({'below its title' if column in below else 'title'})"
                of_places = UNITS_MM[unit.split()[0]] if unit is not None and column in ("x", "y") else 1.0
                units[column] = own or of_places
            if "x" in columns and not known:
                at = (cells[columns["x"]] for number, cells in lines if number > line and len(cells) > columns["x"])
                hits = (re.search(_UNIT_OF_CELLS, unaccented(cell)) for cell in islice(at, _CELLS))
                known = next((f"{ALL_UNITS[UNITS_MM[hit[1]]]} (cells)" for hit in hits if hit), "")
            return _Head(line, columns, tuple(cell.strip() for cell in cells), units, known)
    return None


def _units_below(columns: Mapping[Column, int], lines: Lines) -> dict[Column, float]:
    """Units that a line of nothing else states below the titles."""
    for _, cells in lines:
        stated = [cell for cell in cells if cell.strip()]
        if stated and all(unit_of_cell(cell) is not None for cell in stated):
            found: dict[Column, float] = {}
            for column, place in columns.items():
                if place < len(cells) and (unit_mm := unit_of_cell(cells[place])):
                    found[column] = unit_mm
            return found
    return {}


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
    content = read_bytes(path, "parts table") if content is None else content
    for text in _decodings(content, path):
        found = _read_text(path, text, stated)
        if found is not None:
            return found
    raise NoTableError(
        "no line names the columns. The first line must state which column is the reference designator (Ref, "
        "Designator) and what the others are (Package, Value, PosX, PosY, Side, Pins, Standoff, Height …), or "
        f"{COLUMNS_FILE} beside the board which titles they have.",
        file=path,
    )


def _read_text(path: Path, text: str, stated: Stated) -> PartsTable | None:
    """Read a text in one of the ways in which it can be cut; ``None`` where no line names the columns."""
    unit = _stated_unit(text)
    if unit is None and stated.file is not None and stated.model.unit is not None:
        unit = f"{stated.model.unit} ({stated.file.name})"
    own = {plain_title(title) for titles in stated.titles.values() for title in titles}
    places = {plain_title(title) for key in PLACE_COLUMNS for title in stated.titles.get(key, ())}
    begin = text[: text.rfind("\n", 0, _HEAD_CHARS) + 1 or _HEAD_CHARS] if len(text) > _HEAD_CHARS else text
    for mark, cut in _cutters(text, KNOWN | own, MEASURES | places):
        lines = cut(begin) or []
        if _find_head(lines, unit, stated) is not None:
            lines = lines if begin is text else cut(text) or lines
            head = _find_head(lines, unit, stated)
            if head is not None:
                return _table(path, head, lines, mark)
    return None


def unread_titles(path: Path, content: bytes) -> tuple[str, ...]:
    """Cells above the designators of a text that may be a parts table whose titles are not known; else none."""
    for text in _decodings(content, path):
        for mark in marks_in(text):
            lines = [cells for _, cells in marked(text[:_HEAD_CHARS], mark) if len(cells) > 2]
            for place in range(min(map(len, lines), default=0)):
                hits = [number for number, cells in enumerate(lines) if is_designator(cells[place].strip())]
                kinds = {lines[number][place].strip().rstrip("0123456789") for number in hits}
                if len(kinds) > 1 and 2 * len(hits) > len(lines) - hits[0]:
                    return tuple(cell.strip() for cell in lines[max(hits[0] - 1, 0)] if cell.strip())
    return ()


def _cutters(text: str, titles: Set[str], measures: Set[str]) -> Iterator[tuple[str, Callable[[str], Lines | None]]]:
    """Yield the ways to cut a text into cells, one after the other, each with its mark if it has one."""
    yield "", pads_parts
    yield from ((mark, partial(marked, mark=mark)) for mark in marks_in(text))
    in_columns = partial(
        blank,
        is_title=lambda each: plain_title(each) in titles,
        is_number=lambda each: plain_title(each) in measures,
        is_name=lambda each: plain_title(each) in NAMES["ref"],
    )
    yield from (("", cut) for cut in (in_columns, untitled))


def _table(path: Path, head: "_Head", lines: Lines, mark: str) -> PartsTable:
    marks = {"s"} if plain_title(head.titles[0]) == "a" else None  # Allegro's extract begins its lines with their kind
    stated = [
        (line, _rejoined(cells, head, Line(path, line)) if mark == "," else cells)
        for line, cells in lines
        if line > head.line
        and any(cell.strip("-=:+_ \t") for cell in cells)
        and not cells[0].startswith("#")
        and (marks is None or cells[0].strip().lower() in marks)
    ]
    if (place := head.columns.get("side")) is not None:
        hits = (_LAYER.fullmatch(cells[place].strip()) for _, cells in stated if place < len(cells))
        head = replace(head, layers=tuple(sorted({int(hit[1]) for hit in hits if hit is not None})))
    rows = tuple(_once(row for line, cells in stated for row in _Cells(path, line, head, cells).rows()))
    if "side" not in head.columns and (side := _side_of_name(path.name)):
        rows = tuple(replace(row, side=side) for row in rows)
    titles: dict[Column, str] = {column: head.titles[place].lstrip("# ") for column, place in head.columns.items()}
    return PartsTable(path, rows, head.unit, titles)


def _once(rows: Iterator[Row]) -> Iterator[Row]:
    """Leave out a row that places a part again at the same place."""
    seen = set[tuple[object, ...]]()
    for row in rows:
        key = row.ref.casefold(), row.xy_mm, row.side, row.turn_deg, row.package, row.value
        if row.xy_mm is None or key not in seen:
            yield row
        seen.add(key)


def _rejoined(cells: list[str], head: _Head, line: Line) -> list[str]:
    """Cells of a line whose decimal commas were taken for separators, put together; others as they are.

    Raises:
        BoardError: Which of the commas are decimal ones is open.
    """
    over = len(cells) - len(head.titles)
    if over <= 0 or "y" not in head.columns or not any(map(str.strip, cells[len(head.titles) :])):
        return cells
    joined: list[str] = []
    for cell in cells:
        if joined and re.fullmatch(r"[-+]?\d+", joined[-1].strip()) and re.fullmatch(r"\d+\D{0,3}", cell):
            joined[-1] += f",{cell}"
        else:
            joined.append(cell)
    if len(joined) == len(head.titles):
        return joined
    if any(re.fullmatch(r"\d+", a.strip()) and re.fullmatch(r"0\d*|\d{3,}", b.strip()) for a, b in pairwise(cells)):
        text = (
            f"{len(cells)} cells stand below {len(head.titles)} titles: which commas are decimal ones and which stand "
        )
        raise line.error(f"{text}between cells is open. Export it with semicolons or decimal points.")
    return cells


def _side_of_name(name: str) -> Side | None:
    """Side that the name of a table without such a column states: one file a side is common."""
    words = re.split(r"[\W_\d]+", unaccented(name))
    if words[-1] in ("mnt", "mnb"):  # Eagle's mountsmd
        return "top" if words[-1] == "mnt" else "bottom"
    found: set[Side] = {SIDES[word] for word in words[:-1] if len(word) > 1 and word in SIDES}
    return next(iter(found)) if len(found) == 1 else None


def _stated_unit(text: str) -> str | None:
    """Unit of lengths that the lines above the titles state, and that they do."""
    for line in text[:20_000].splitlines()[:_HEADER_LINES]:
        if (hit := PADS.match(line)) is not None:
            return f"{_UNITS_OF_PADS[hit[1].upper()]} (line above)"
        plain = unaccented(line)
        hit = UNIT_LINE.match(plain) or UNIT_OF_EXTRACT.match(plain)
        if hit is not None:
            return f"{ALL_UNITS[UNITS_MM[hit[1]]]} (line above)"
    return None


def _decodings(data: bytes, path: Path) -> Iterator[str]:
    """Yield the texts that bytes may be, the likeliest first.

    Raises:
        BoardError: They are no text.
    """
    nuls = [data[:_HEAD_CHARS][first::2].count(0) for first in (0, 1)]
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        encodings = ("utf-16",)
    elif 5 * max(nuls) > len(data[:_HEAD_CHARS]) and 20 * min(nuls) < max(nuls):  # no mark, every second byte 0
        encodings = ("utf-16-be" if nuls[0] else "utf-16-le",)
    else:  # characters of GBK are pairs of high bytes, letters with accents stand alone
        pairs = all(len(run) % 2 == 0 for run in re.findall(rb"[\x80-\xff]+", data[:_HEAD_CHARS]))
        encodings = ("utf-8-sig", *(("gb18030",) if pairs else ()), "cp1252", "latin-1", "shift_jis")
    is_text = False
    for encoding in encodings:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            is_text = True
            yield text
            if encoding == "utf-8-sig":
                return
    if not is_text:
        raise BoardError("not a text table. Export it as CSV.", file=path)


@dataclass(frozen=True, slots=True)
class _Cells(Line):
    """One line of the table."""

    head: _Head
    cells: list[str]

    def rows(self) -> Iterator[Row]:
        """One row for each reference designator of the line."""
        refs = _expand(self.text("ref"))
        if not refs:
            return
        x, y = self.length("x"), self.length("y")
        is_fitted = self.is_fitted()
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
                is_fitted=is_fitted,
                states_fitted=not is_fitted or not {"fitted", "omitted"}.isdisjoint(self.head.columns),
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
        text = _MOST_OF.sub("", self.text(column).replace(_MINUS, "-"))
        if not text or text in ("-", "~", "N/A", "n/a"):
            return None
        hit = _VALUE.fullmatch(text)
        unit = unaccented(hit[2]) if hit else ""
        if hit is None or (unit and unit not in UNITS_MM):
            raise self.refusal(column, "is not a length. Write a number, such as 12.3 or 12.3mm.")
        number = hit[1]
        if "," in number and "." in number:  # the last mark of the two is the decimal one
            number = number.replace("," if number.rindex(".") > number.rindex(",") else ".", "")
        unit_mm = UNITS_MM[unit] if unit else self.head.units_mm[column]
        is_open = column in ("x", "y") and not unit  # a title may state another unit than the copper
        value = number_within(number.replace(",", "."), FARTHEST_MM * (1000.0 if is_open else 1.0), unit_mm)
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
        text = self.text(column).replace(_MINUS, "-").rstrip("°").removesuffix("deg").strip()
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
        """Whether the part is fitted: by the column that states it, a value such as ``DNP``, a remark, or 0 pieces."""
        fitted = not (
            leaves_out(self.text("value"), is_value=True)
            or leaves_out(self.text("remark"))
            or _NO_PIECE.fullmatch(self.text("quantity"))
        )
        columns: tuple[tuple[Column, bool], ...] = (("fitted", False), ("omitted", True))
        for column, marks in columns:
            text = letters(self.text(column))
            if text in NOT_FITTED or (marks and text in YES) or (not marks and text in NO):
                fitted = False
            elif text and text not in YES | NO:
                raise self.refusal(
                    column, "states neither that the part is fitted nor that it is not. Write yes or no."
                )
        return fitted

    def side(self) -> Side | None:
        text = self.text("side")
        if letters(text) in NO_SIDE:
            return None
        title = plain_title(self.head.titles[self.head.columns["side"]])
        if (layer := _LAYER.fullmatch(text)) is not None and "mirror" not in title:
            first, number = self.head.layers[0], int(layer[1])
            return "top" if number == first and (number <= 1 or len(self.head.layers) > 1) else "bottom"
        side = side_in(text, title)
        if side is None:
            raise self.refusal("side", "is neither top nor bottom.")
        return side


def _expand(text: str) -> list[str]:
    """``C1, C2 C5-C7`` as single references, each once."""
    if text.isalnum():
        return [text]
    refs: list[str] = []
    plain = " ".join(unicodedata.normalize("NFKC", text).split())
    plain = _UP_TO.sub("-", re.sub(r" ?(?:[-~\u2013\u2014]|\.\.+) ?", "-", plain))
    words = re.sub(r"[,;\u3001]", " ", _OR.sub(" ", plain)).split()
    if re.fullmatch(r"[A-Za-z]{1,4} \d{1,5}", plain):  # a blank before the number
        return [plain.replace(" ", "")]
    first = re.fullmatch(r"([A-Za-z]+)\d+", words[0]) if words else None
    if first is not None and all(word.isdecimal() for word in words[1:]):  # R1, 2, 3
        words[1:] = [f"{first[1]}{word}" for word in words[1:]]
    for word in words:
        span = _RANGE.fullmatch(word)
        if span and span[1] == span[3] and int(span[2]) <= int(span[4]) < int(span[2]) + 1000:
            refs.extend(f"{span[1]}{number}" for number in range(int(span[2]), int(span[4]) + 1))
        else:
            refs.append(word)
    return list(dict.fromkeys(refs))
