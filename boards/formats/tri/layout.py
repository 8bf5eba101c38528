"""The two layouts of a ``.tri`` file: which object has which surfaces, and where the numbers of each patch are."""

import difflib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np

from boards.errors import Line
from boards.formats.tri.text import Content, Record
from geometry.arrays import Indices

MILLIMETRES = {"mm": 1.0, "m": 1000.0, "in": 25.4}
_KEYS = ("role", "package", "part", "value", "pins", "side", "standoff", "pads")
_HEADER = ("board-tri", "units", "objects")


@dataclass(frozen=True, slots=True)
class Item(Line):
    """One object as its records describe it; its surfaces are added while they are read."""

    name: str
    attributes: dict[str, str]
    stated_surfaces: int
    surfaces: list[tuple[str, int]] = field(default_factory=list[tuple[str, int]])


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """The objects of a file, with the place of each patch among the numbers."""

    items: tuple[Item, ...]
    units: str
    offsets: Indices
    """(n,) where the numbers of each patch begin."""
    widths: Indices
    """(n,) 9 or 12 numbers."""
    lines: Indices
    """(n,) line number of each patch."""
    legacy: bool = False


def read_layout(content: Content, file: Path) -> Layout:
    """Follow the records of the layout that begins with ``board-tri``.

    Raises:
        BoardError: The records or the counts in them are wrong.
    """
    units, stated, first = _read_header(content.records)
    items: list[Item] = []
    lines: dict[str, int] = {}
    row = 0
    for record in content.records[first:]:
        if record.rows_before != row:
            _refuse_rows(content, items, row, record)
        match record.tokens[0]:
            case "object":
                _check_surfaces(items, record)
                item = _read_object(record)
                if item.name in lines:
                    stands = f"object {item.name} stands already in line {lines[item.name]}"
                    raise record.error(f"{stands}. Give each object its own name.")
                if len(items) == stated:
                    raise record.error(f"one object more than the {stated} stated. Correct 'objects {stated}'.")
                lines[item.name] = record.line
                items.append(item)
            case "surface":
                row += _read_surface(record, items)
            case word:
                nearest = _nearest(word, ("object", "surface", *_HEADER))
                raise record.error(f"expected 'object', 'surface' or a patch, found {word[:40]!r}{nearest}.")
    if row != len(content.numbers.lines):
        _refuse_rows(content, items, row, None)
    _check_surfaces(items, content.last)
    if len(items) != stated:
        raise content.last.error(f"'objects {stated}' is stated, {len(items)} follow. The file may be cut off.")
    counts = content.numbers.counts
    bad = np.flatnonzero((counts != 12) & (counts != 9))
    if bad.size:
        message = f"{counts[bad[0]]} numbers, a patch has 12: three vertices and a normal (or 9: without the normal)."
        raise Line(file, int(content.numbers.lines[bad[0]])).error(message)
    return Layout(tuple(items), units, np.cumsum(counts) - counts, counts, content.numbers.lines)


def _read_header(records: Sequence[Record]) -> tuple[str, int, int]:
    """Units, number of objects, and number of records in the header."""
    magic = records[0]
    if magic.tokens[0] != "board-tri" or magic.rows_before:
        raise magic.error("expected 'board-tri 1' first. Is this a board file?")
    if magic.tokens[1:] != ("1",):
        raise magic.error(f"'{' '.join(magic.tokens)[:60]}': only format version 1 is known ('board-tri 1').")
    found: dict[str, Record] = {}
    for record in records[1:]:
        word = record.tokens[0]
        if word not in ("units", "objects"):
            break
        if len(record.tokens) != 2 or word in found or record.rows_before:
            raise record.error(f"expected one line '{word} …' with one word after it.")
        found[word] = record
    for word, example in (("units", "units mm' (or m, in)"), ("objects", "objects N'")):
        if word not in found:
            after = records[min(len(found) + 1, len(records) - 1)]
            raise after.error(f"expected '{example} before the objects.")
    units = found["units"].tokens[1]
    if units not in MILLIMETRES:
        raise found["units"].error(f"unit {units[:40]!r} is not known. Write mm, m or in.")
    return units, read_count(found["objects"].tokens[1], "objects", found["objects"]), 1 + len(found)


def _read_object(record: Record) -> Item:
    tokens = record.tokens
    if len(tokens) < 4 or tokens[2] != "surfaces":
        raise record.error("expected 'object NAME surfaces N role=…'.")
    attributes: dict[str, str] = {}
    for token in tokens[4:]:
        key, equals, value = token.partition("=")
        if not equals:
            message = f"{token[:40]!r} is no attribute. Write key=value, a value with spaces in double quotes."
            raise record.error(message)
        if key not in _KEYS and not key.startswith("x-"):
            unknown = f"unknown attribute {key[:40]!r}{_nearest(key, _KEYS)}"
            raise record.error(f"{unknown}. Own attributes begin with 'x-'.")
        if key in attributes:
            raise record.error(f"attribute {key!r} stands twice.")
        attributes[key] = value.replace('"', "")
    name = tokens[1].replace('"', "")
    if not name.strip():
        raise record.error("the object's name is empty.")
    return Item(record.file, record.line, name, attributes, read_count(tokens[3], "surfaces", record))


def _read_surface(record: Record, items: list[Item]) -> int:
    """Add a surface to the last object; returns its number of patches."""
    tokens = record.tokens
    if len(tokens) != 4 or tokens[2] != "patches":
        raise record.error("expected 'surface NAME patches N'.")
    if not items:
        raise record.error("a surface before the first object.")
    item = items[-1]
    if len(item.surfaces) == item.stated_surfaces:
        more = f"one surface more than the {item.stated_surfaces} stated for object {item.name}"
        raise record.error(f"{more}. Correct line {item.line}.")
    patches = read_count(tokens[3], "patches", record)
    item.surfaces.append((tokens[1].replace('"', ""), patches))
    return patches


def _check_surfaces(items: list[Item], where: Line) -> None:
    if items and len(items[-1].surfaces) != items[-1].stated_surfaces:
        item = items[-1]
        states = f"object {item.name} states {item.stated_surfaces} surfaces (line {item.line})"
        raise where.error(f"{states}, only {len(item.surfaces)} follow.")


def _refuse_rows(content: Content, items: list[Item], row: int, record: Record | None) -> NoReturn:
    """Refuse a surface with too many or too few patches; ``row`` is where its last patch should be."""
    lines = content.numbers.lines
    found = len(lines) if record is None else record.rows_before
    if found > row:
        where = Line(content.last.file, int(lines[row]))
        if not items or not items[-1].surfaces:
            raise where.error("numbers where an 'object' or 'surface' line is expected.")
        name, patches = items[-1].surfaces[-1]
        raise where.error(f"one patch more than the {patches} stated for surface {name} of {items[-1].name}.")
    name, patches = items[-1].surfaces[-1]
    if record is not None:
        try:
            float(record.tokens[0])
        except ValueError:
            pass
        else:
            raise record.error(f"{record.tokens[0][:40]!r} stands where a finite number is expected.")
    message = f"surface {name} of {items[-1].name} states {patches} patches, only {patches - (row - found)} follow."
    raise (record or content.last).error(message)


def read_count(word: str, what: str, where: Line) -> int:
    """Return a count that a file states.

    Raises:
        BoardError: It is no whole number, or negative.
    """
    if not (word.isascii() and word.isdigit() and len(word) < 12):
        raise where.error(f"{what}: expected a count, found {word[:40]!r}.")
    return int(word)


def _nearest(word: str, known: Sequence[str]) -> str:
    close = difflib.get_close_matches(word.lower(), known, 1, 0.5)
    return f" (the nearest known one is {close[0]!r})" if close else f" (known: {', '.join(known)})"


def read_legacy_layout(content: Content, file: Path) -> Layout:
    """Follow the counts of the numbers-only layout of the 1993 paper: objects, their surfaces, patches of these.

    Line breaks are free, but a patch a line is checked line by line.

    Raises:
        BoardError: A count is wrong, or numbers are missing or left over.
    """
    stream = _Stream(content, file)
    items: list[Item] = []
    blocks: list[tuple[Indices, int]] = []
    for number in range(stream.take_count("objects")):
        name = f"object-{number + 1}"
        item = Item(file, stream.where().line, name, {}, stream.take_count(f"surfaces of {name}"))
        for surface in range(item.stated_surfaces):
            what = f"patches of surface {surface + 1} of {name}"
            patches = stream.take_count(what)
            blocks.append(stream.take_patches(patches, what))
            item.surfaces.append((str(surface + 1), patches))
        items.append(item)
    if left := len(stream.values) - stream.place:
        message = f"{left} numbers are left over after the last patch. Correct the counts above."
        raise stream.where().error(message)
    if not items:
        raise Line(file, int(content.numbers.lines[0])).error("states no objects.")
    offsets = np.concatenate([np.empty(0, np.int64), *(begin for begin, _ in blocks)])
    widths = np.repeat([width for _, width in blocks], [len(begin) for begin, _ in blocks]).astype(np.int64)
    lines = stream.lines[np.searchsorted(stream.begins, offsets, side="right") - 1]
    return Layout(tuple(items), "mm", offsets, widths, lines, legacy=True)


class _Stream:
    """A place in the numbers of a file."""

    def __init__(self, content: Content, file: Path) -> None:
        self.values = content.numbers.values
        self.counts = content.numbers.counts
        self.lines = content.numbers.lines
        self.begins = np.cumsum(self.counts) - self.counts
        self.file = file
        self.place = 0

    def where(self) -> Line:
        return Line(self.file, int(self.lines[np.searchsorted(self.begins, self.place, side="right") - 1]))

    def take_count(self, what: str) -> int:
        if self.place >= len(self.values):
            raise Line(self.file, int(self.lines[-1])).error(f"ends where the number of {what} is expected.")
        value = float(self.values[self.place])
        if value != int(value) or not 0 <= value < 1e9:
            raise self.where().error(f"the number of {what} is expected here, found {value:g}.")
        self.place += 1
        return int(value)

    def take_patches(self, patches: int, what: str) -> tuple[Indices, int]:
        """Where patches begin, and how many numbers each has."""
        width = 12
        if patches and self.place < len(self.values):
            row = int(np.searchsorted(self.begins, self.place, side="right")) - 1
            count = int(self.counts[row])
            if self.begins[row] == self.place and not (count > 12 or (12 % count == 0 and count < 12)):
                width = 9 if count == 9 else 12
                counts = self.counts[row : row + patches]
                for bad in np.flatnonzero(counts != width)[:1].tolist():
                    message = f"{counts[bad]} numbers where patch {bad + 1} of {patches} ({what}) needs {width}."
                    raise Line(self.file, int(self.lines[row + bad])).error(message)
        if self.place + patches * width > len(self.values):
            message = f"ends before all {patches} {what} are read: {width} numbers each."
            raise Line(self.file, int(self.lines[-1])).error(message)
        begins = self.place + width * np.arange(patches, dtype=np.int64)
        self.place += patches * width
        return begins, width
