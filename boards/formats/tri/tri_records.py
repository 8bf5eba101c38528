"""The grammar of a ``.tri`` file: which object has which surfaces and how many patches they hold."""

import difflib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np

from boards.errors import BoardError
from boards.formats.tri.tri_text import Content, Record
from geometry.arrays import Indices

MILLIMETRES = {"mm": 1.0, "m": 1000.0, "in": 25.4}
KEYS = ("role", "package", "part", "value", "pins", "side", "standoff", "pads")
_HEADER = ("board-tri", "units", "objects")


@dataclass(slots=True)
class Item:
    """One object as its records describe it; built up while they are read."""

    name: str
    line: int
    attributes: dict[str, str]
    stated_surfaces: int
    surfaces: list[tuple[str, int]] = field(default_factory=list[tuple[str, int]])


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """What the records say, with the place of each patch among the numbers."""

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
    units, stated, first = _read_header(content.records, file)
    items: list[Item] = []
    names: dict[str, int] = {}
    row = 0
    for record in content.records[first:]:
        if record.rows_before != row:
            _refuse_rows(content, items, row, record, file)
        match record.tokens[0]:
            case "object":
                _close(items, record.line, file)
                item = _read_object(record, file)
                if item.name in names:
                    message = (
                        f"object {item.name} stands already in line {names[item.name]}. Give each object its own name."
                    )
                    raise BoardError(message, file=file, line=record.line)
                if len(items) == stated:
                    raise BoardError(
                        f"one object more than the {stated} stated. Correct 'objects {stated}'.",
                        file=file,
                        line=record.line,
                    )
                names[item.name] = record.line
                items.append(item)
            case "surface":
                row += _read_surface(record, items, file)
            case word:
                nearest = _nearest(word, ("object", "surface", *_HEADER))
                raise BoardError(
                    f"expected 'object', 'surface' or a patch, found {word[:40]!r}{nearest}.",
                    file=file,
                    line=record.line,
                )
    if row != len(content.numbers.lines):
        _refuse_rows(content, items, row, None, file)
    _close(items, content.last_line, file)
    if len(items) != stated:
        raise BoardError(
            f"'objects {stated}' is stated, {len(items)} follow. The file may be cut off.",
            file=file,
            line=content.last_line,
        )
    counts = content.numbers.counts
    bad = np.flatnonzero((counts != 12) & (counts != 9))
    if bad.size:
        message = f"{counts[bad[0]]} numbers, a patch has 12: three vertices and a normal (or 9: without the normal)."
        raise BoardError(message, file=file, line=int(content.numbers.lines[bad[0]]))
    return Layout(tuple(items), units, np.cumsum(counts) - counts, counts, content.numbers.lines)


def _read_header(records: Sequence[Record], file: Path) -> tuple[str, int, int]:
    magic = records[0]
    if magic.tokens[0] != "board-tri" or magic.rows_before:
        raise BoardError("expected 'board-tri 1' first. Is this a board file?", file=file, line=magic.line)
    if magic.tokens[1:] != ("1",):
        raise BoardError(
            f"'{' '.join(magic.tokens)[:60]}': only format version 1 is known ('board-tri 1').",
            file=file,
            line=magic.line,
        )
    found: dict[str, Record] = {}
    for record in records[1:]:
        word = record.tokens[0]
        if word not in ("units", "objects"):
            break
        if len(record.tokens) != 2 or word in found or record.rows_before:
            raise BoardError(f"expected one line '{word} …' with one word after it.", file=file, line=record.line)
        found[word] = record
    line = records[min(len(found) + 1, len(records) - 1)].line
    if "units" not in found:
        raise BoardError("expected 'units mm' (or m, in) before the objects.", file=file, line=line)
    if "objects" not in found:
        raise BoardError("expected 'objects N' before the objects.", file=file, line=line)
    units = found["units"].tokens[1]
    if units not in MILLIMETRES:
        raise BoardError(f"unit {units[:40]!r} is not known. Write mm, m or in.", file=file, line=found["units"].line)
    return units, read_count(found["objects"].tokens[1], "objects", found["objects"].line, file), 1 + len(found)


def _read_object(record: Record, file: Path) -> Item:
    tokens = record.tokens
    if len(tokens) < 4 or tokens[2] != "surfaces":
        raise BoardError("expected 'object NAME surfaces N role=…'.", file=file, line=record.line)
    attributes: dict[str, str] = {}
    for token in tokens[4:]:
        key, equals, value = token.partition("=")
        if not equals:
            message = f"{token[:40]!r} is no attribute. Write key=value, a value with spaces in double quotes."
            raise BoardError(message, file=file, line=record.line)
        if key not in KEYS and not key.startswith("x-"):
            message = f"unknown attribute {key[:40]!r}{_nearest(key, KEYS)}. Own attributes begin with 'x-'."
            raise BoardError(message, file=file, line=record.line)
        if key in attributes:
            raise BoardError(f"attribute {key!r} stands twice.", file=file, line=record.line)
        attributes[key] = value.replace('"', "")
    name = tokens[1].replace('"', "")
    if not name.strip():
        raise BoardError("the object's name is empty.", file=file, line=record.line)
    return Item(name, record.line, attributes, read_count(tokens[3], "surfaces", record.line, file))


def _read_surface(record: Record, items: list[Item], file: Path) -> int:
    tokens = record.tokens
    if len(tokens) != 4 or tokens[2] != "patches":
        raise BoardError("expected 'surface NAME patches N'.", file=file, line=record.line)
    if not items:
        raise BoardError("a surface before the first object.", file=file, line=record.line)
    item = items[-1]
    if len(item.surfaces) == item.stated_surfaces:
        message = (
            f"one surface more than the {item.stated_surfaces} stated for object {item.name}. Correct line {item.line}."
        )
        raise BoardError(message, file=file, line=record.line)
    patches = read_count(tokens[3], "patches", record.line, file)
    item.surfaces.append((tokens[1].replace('"', ""), patches))
    return patches


def _close(items: list[Item], line: int, file: Path) -> None:
    if items and len(items[-1].surfaces) != items[-1].stated_surfaces:
        item = items[-1]
        stated, found = item.stated_surfaces, len(item.surfaces)
        message = f"object {item.name} states {stated} surfaces (line {item.line}), only {found} follow."
        raise BoardError(message, file=file, line=line)


def _refuse_rows(content: Content, items: list[Item], row: int, record: Record | None, file: Path) -> NoReturn:
    """Say which surface has too many or too few patches; ``row`` is where its last patch should be."""
    lines = content.numbers.lines
    found = len(lines) if record is None else record.rows_before
    if found > row:
        line = int(lines[row])
        if not items or not items[-1].surfaces:
            raise BoardError("numbers where an 'object' or 'surface' line is expected.", file=file, line=line)
        name, patches = items[-1].surfaces[-1]
        message = f"one patch more than the {patches} stated for surface {name} of {items[-1].name}."
        raise BoardError(message, file=file, line=line)
    name, patches = items[-1].surfaces[-1]
    if record is not None and _looks_like_number(record.tokens[0]):
        message = f"{record.tokens[0][:40]!r} stands where a finite number is expected."
        raise BoardError(message, file=file, line=record.line)
    message = f"surface {name} of {items[-1].name} states {patches} patches, only {patches - (row - found)} follow."
    raise BoardError(message, file=file, line=content.last_line if record is None else record.line)


def _looks_like_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def read_count(word: str, what: str, line: int, file: Path) -> int:
    """Return a count that a file states.

    Raises:
        BoardError: It is no whole number, or negative.
    """
    if not (word.isascii() and word.isdigit() and len(word) < 12):
        raise BoardError(f"{what}: expected a count, found {word[:40]!r}.", file=file, line=line)
    return int(word)


def _nearest(word: str, known: Sequence[str]) -> str:
    close = difflib.get_close_matches(word.lower(), known, 1, 0.5)
    return f" (the nearest known one is {close[0]!r})" if close else f" (known: {', '.join(known)})"
