"""The S-expressions of a KiCad board: the items that matter, each with its line."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import sexpdata

from boards.errors import BoardError
from boards.formats.loops import Point2

_MARK = re.compile(r'"(?:[^"\\]|\\.)*"|[()]', re.DOTALL)
_WANTED = re.compile(r"\(\s*(?:general|footprint|module|gr_line|gr_arc|gr_circle|gr_rect|gr_poly|gr_curve)\b")
_DEPTH = 100
"""KiCad nests about ten lists; more is no board, and would exhaust the parser's recursion."""


@dataclass(frozen=True, slots=True)
class Item:
    """One list: its first word, its atoms as text, its lists."""

    head: str
    atoms: tuple[str, ...]
    items: tuple["Item", ...]
    file: Path
    line: int
    """Line on which the outermost item begins."""

    def all(self, head: str) -> Iterator["Item"]:
        """Yield the lists of this name, in file order."""
        return (item for item in self.items if item.head == head)

    def first(self, head: str) -> "Item | None":
        """Return the first list of this name, if there is one."""
        return next(self.all(head), None)

    def word(self, head: str) -> str:
        """First atom of the first list of this name; empty if there is none."""
        item = self.first(head)
        return item.atoms[0] if item is not None and item.atoms else ""

    def number(self, place: int) -> float:
        """Atom at a place as a finite number.

        Raises:
            BoardError: It is missing or no number.
        """
        try:
            value = float(self.atoms[place])
        except (IndexError, ValueError):
            value = math.nan
        if not math.isfinite(value):
            stated = self.atoms[place] if place < len(self.atoms) else "nothing"
            raise self.error(
                f"number {place + 1} of ({self.head} …) is {stated[:40]!r}. Save the board in KiCad again."
            )
        return value

    def point(self, head: str) -> Point2:
        """First two numbers of a list, ``y`` turned from down to up, mm.

        Raises:
            BoardError: The list is missing, or it holds no numbers.
        """
        item = self.first(head)
        if item is None:
            raise self.error(f"({self.head} …) has no ({head} x y). Save the board in KiCad again.")
        return item.here()

    def here(self) -> Point2:
        """First two numbers of this list, ``y`` turned from down to up, mm."""
        return np.array([self.number(0), -self.number(1)])

    def error(self, message: str) -> BoardError:
        """Build the error that names this item's line."""
        return BoardError(message, file=self.file, line=self.line)


def read_items(path: Path) -> tuple[Item, tuple[Item, ...]]:
    """Read the items of a board that say something about shape: footprints, drawings, general.

    The text is cut at the top level first and the copper is skipped: that leaves the parser half of a usual board,
    and gives every item its line, which ``sexpdata`` does not know.

    Returns:
        The board's own head (``version`` among its lists) and the items, in file order.

    Raises:
        BoardError: The file cannot be read, is no KiCad board, or its brackets do not match.
    """
    text = _read(path)
    if not re.match(r"\s*\(\s*kicad_pcb\b", text):
        raise BoardError(
            "not a KiCad board: it must begin with (kicad_pcb. Open it in KiCad 5 or newer and save it.",
            file=path,
            line=1,
        )
    items: list[Item] = []
    version = re.search(r"\(\s*version\s+(\d+)\s*\)", text[:2000])
    line, seen = 1, 0
    for start, end in _top_level(text, path):
        line, seen = line + text.count("\n", seen, start), start
        if _WANTED.match(text, start):
            items.append(_parse(text[start:end], path, line))
    atoms = (version[1],) if version else ()
    return Item("kicad_pcb", atoms, (), path, 1), tuple(items)


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise BoardError("not a text file in UTF-8. Save the board in KiCad again.", file=path) from None
    except OSError as error:
        raise BoardError(f"cannot be read ({error.strerror}).", file=path) from None


def _top_level(text: str, path: Path) -> Iterator[tuple[int, int]]:
    """Yield start and end of every list directly inside ``(kicad_pcb``."""
    depth = start = 0
    for mark in _MARK.finditer(text):
        if mark[0] == "(":
            depth += 1
            if depth == 2:
                start = mark.start()
            elif depth > _DEPTH:
                raise BoardError("lists are nested too deep for a board.", file=path, line=_line(text, mark.start()))
        elif mark[0] == ")":
            depth -= 1
            if depth == 1:
                yield start, mark.end()
            elif depth == 0 and text[mark.end() :].strip():
                raise BoardError(
                    "there is text after the board's last bracket: a bracket too many, or two files in one.",
                    file=path,
                    line=_line(text, mark.end()),
                )
    if depth:
        raise BoardError(
            f"the file ends inside a list that begins in line {_line(text, start)}. It is incomplete: copy it again.",
            file=path,
            line=_line(text, len(text)),
        )


def _line(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1


def _parse(text: str, path: Path, line: int) -> Item:
    try:
        # No Lisp: `nil`, `t` and `;` are words like any other in KiCad.
        parsed = sexpdata.parse(text, nil=None, true=None, false=None, line_comment="\0")
    except (sexpdata.ExpectClosingBracket, sexpdata.ExpectNothing, sexpdata.ExpectSExp, AttributeError, IndexError):
        raise BoardError("this item cannot be read. Save the board in KiCad again.", file=path, line=line) from None
    return _item(parsed[0], path, line)


def _item(node: list[object], path: Path, line: int) -> Item:
    atoms = [_text(part) for part in node if not isinstance(part, list)]
    lists = [part for part in node if isinstance(part, list)]
    items = tuple(_item(part, path, line) for part in lists)
    return Item(atoms[0] if atoms else "", tuple(atoms[1:]), items, path, line)


def _text(atom: object) -> str:
    if isinstance(atom, sexpdata.Symbol):
        return str(atom.value())
    return f"{atom:.12g}" if isinstance(atom, float) else str(atom)
