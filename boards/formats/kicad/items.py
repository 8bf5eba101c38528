"""The S-expressions of a KiCad board: the items that matter, each with its line, and the lines they draw."""

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from boards.bounds import FARTHEST_MM, MOST_CORNERS, MOST_TURN_DEG, number_within
from boards.errors import BoardError, Line, read_bytes
from boards.formats.loops import Point2, arc, arc_between, is_too_far, sweep_through
from geometry.arrays import Points2

_MARK = re.compile(r'"(?:[^"\\]|\\.?)*("|\Z)|[()]', re.DOTALL)
"""A string may end with the file: else each quote of one that is not closed would be looked at to the end again."""
_KEPT = re.compile(r"\(\s*(?:general|footprint|module|gr_line|gr_arc|gr_circle|gr_rect|gr_poly|gr_curve)\b")
_DEPTH = 100
"""KiCad nests about ten lists; more is no board."""

_TOKEN = re.compile(r'"((?:[^"\\]|\\.)*)"|[()]|([^\s()"]+)', re.DOTALL)
_ESCAPE = re.compile(r"\\(.)", re.DOTALL)
_ESCAPED = {"n": "\n", "r": "\r", "t": "\t"}
_CURVE_STEPS = 32
_FULL_TURN_DEG = 360.0
"""No arc turns farther."""


@dataclass(frozen=True, slots=True)
class Item(Line):
    """One list: the line on which its outermost item begins, its first word, its atoms as text, its lists."""

    head: str
    atoms: tuple[str, ...]
    items: tuple["Item", ...]

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

    def number(self, place: int, bound: float = FARTHEST_MM) -> float:
        """Atom at a place as a finite number, at most as large as the bound: a length or coordinate, mm, by default.

        Raises:
            BoardError: It is missing, no number, or beyond the bound.
        """
        stated = self.atoms[place] if place < len(self.atoms) else "nothing"
        value = number_within(stated, bound)
        if math.isnan(value):
            message = f"number {place + 1} of ({self.head} …) is {stated[:40]!r}, not a number within ±{bound:g}"
            raise self.error(f"{message}. Save the board in KiCad again.")
        return value

    def angle(self) -> float:
        """Third number of the list's ``at`` in radians, 0 without one."""
        at = self.first("at")
        return math.radians(at.number(2, MOST_TURN_DEG)) if at is not None and len(at.atoms) > 2 else 0.0

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


def read_items(path: Path) -> tuple[Item, tuple[Item, ...]]:
    """Read the items of a board that describe shapes: footprints, drawings, general.

    The text is cut at the top level first and the copper is skipped: that leaves the parser half of a usual board.

    Returns:
        The board's own head (``version`` among its lists) and the items, in file order.

    Raises:
        BoardError: The file cannot be read, is no KiCad board, or its brackets do not match.
    """
    try:
        text = read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise BoardError("not a text file in UTF-8. Save the board in KiCad again.", file=path) from None
    if not re.match(r"\s*\(\s*kicad_pcb\b", text):
        hint = "Open it in KiCad 5 or newer and save it"
        raise Line(path, 1).error(f"not a KiCad board: it must begin with (kicad_pcb. {hint}.")
    items: list[Item] = []
    version = re.search(r"\(\s*version\s+(\d{1,9})\s*\)", text[:2000])
    line, seen = 1, 0
    for start, end in _top_level(text, path):
        line, seen = line + text.count("\n", seen, start), start
        if _KEPT.match(text, start):
            items.append(_parse(text[start:end], path, line))
    atoms = (version[1],) if version else ()
    return Item(path, 1, "kicad_pcb", atoms, ()), tuple(items)


def _top_level(text: str, path: Path) -> Iterator[tuple[int, int]]:
    """Yield start and end of every list directly inside ``(kicad_pcb``."""
    depth = start = 0
    for mark in _MARK.finditer(text):
        if mark[0] == "(":
            depth += 1
            if depth == 2:
                start = mark.start()
            elif depth > _DEPTH:
                raise _at(path, text, mark.start()).error("lists are nested too deep for a board.")
        elif mark[0] == ")":
            depth -= 1
            if depth == 1:
                yield start, mark.end()
            elif depth == 0 and text[mark.end() :].strip():
                message = "there is text after the board's last bracket: a bracket too many, or two files in one."
                raise _at(path, text, mark.end()).error(message)
        elif not mark[1]:
            raise _at(path, text, mark.start()).error("a quote is not closed. Save the board in KiCad again.")
    if depth:
        begins = f"the file ends inside a list that begins in line {_at(path, text, start).line}"
        raise _at(path, text, len(text)).error(f"{begins}. It is incomplete: copy it again.")


def _at(path: Path, text: str, place: int) -> Line:
    return Line(path, text.count("\n", 0, place) + 1)


def _parse(text: str, path: Path, line: int) -> Item:
    """Parse one list. KiCad's words are no Lisp: brackets other than round ones, marks and numbers are plain text."""
    opened: list[tuple[list[str], list[Item]]] = [([], [])]
    for token in _TOKEN.finditer(text):
        quoted, plain = token.groups()
        if quoted is not None:
            opened[-1][0].append(_ESCAPE.sub(lambda found: _ESCAPED.get(found[1], found[1]), quoted))
        elif plain is not None:
            opened[-1][0].append(plain)
        elif token[0] == "(":
            opened.append(([], []))
        else:
            atoms, items = opened.pop()
            opened[-1][1].append(Item(path, line, atoms[0] if atoms else "", tuple(atoms[1:]), tuple(items)))
    return opened[0][1][0]


def drawn(items: Iterable[Item], prefix: str, layer: str) -> list[Points2]:
    """Polylines of the items that a prefix such as ``fp_`` marks as drawings, on one layer.

    Raises:
        BoardError: A number of them cannot be read, or they have more corners than an outline may have.
    """
    lines: list[Points2] = []
    count = 0
    for item in items:
        line = polyline(item) if item.head.startswith(prefix) and item.word("layer") == layer else None
        if line is not None:
            lines.append(line)
            count += len(line)
            if count > MOST_CORNERS:
                message = f"what is drawn on {layer} has more than {MOST_CORNERS:,} corners, arcs as chords"
                raise item.error(f"{message}. Draw it with fewer and smaller pieces.")
    return lines


def pens(items: Iterable[Item], prefix: str, layer: str) -> list[float]:
    """Widths of the lines that a prefix marks as drawings on one layer, mm, as far as they are stated.

    Raises:
        BoardError: A width cannot be read.
    """
    drawings = [item for item in items if item.head.startswith(prefix) and item.word("layer") == layer]
    strokes = [stroke for item in drawings for stroke in (item, *item.all("stroke"))]
    return [width.number(0) for stroke in strokes for width in stroke.all("width") if width.atoms]


def polyline(item: Item) -> Points2 | None:
    """Points of a drawn item ``(n, 2)``, mm, y up; closed shapes end on their first point.

    Args:
        item: ``gr_line``, ``fp_arc`` and so on; the part before the underscore does not matter.

    Returns:
        ``None`` for what is not a line: text, dimensions.

    Raises:
        BoardError: A point of it is missing.
    """
    match item.head.partition("_")[2]:
        case "line":
            return np.array([item.point("start"), item.point("end")])
        case "arc":
            return _arc(item)
        case "circle":
            return arc(item.point("end"), item.point("center"), 2.0 * math.pi)
        case "rect":
            (ax, ay), (bx, by) = item.point("start"), item.point("end")
            return np.array([[ax, ay], [bx, ay], [bx, by], [ax, by], [ax, ay]])
        case "poly":
            points = _corners(item)
            return np.concatenate([points, points[:1]])
        case "curve":
            control = _corners(item)
            if len(control) != 4:
                raise item.error(f"({item.head} …) has {len(control)} control points; four are needed.")
            t = np.linspace(0.0, 1.0, _CURVE_STEPS + 1)[:, None]
            while len(control) > 1:  # De Casteljau: between neighbours until one point is left for every t
                control = np.array([(1.0 - t) * a + t * b for a, b in pairwise(control)])
            return control[0]
        case _:
            return None


def _arc(item: Item) -> Points2:
    """Since version 6 by three points; before by centre (called start), first point (called end) and angle.

    The old angle turns clockwise on the screen: negative once y points up.
    """
    if item.first("mid") is not None:
        start, end = item.point("start"), item.point("end")
        sweep_rad = sweep_through(start, item.point("mid"), end)
        if is_too_far(start, end, sweep_rad):
            raise item.error(f"the points of this ({item.head} …) are in a row, with mid beside start and end.")
        return arc_between(start, end, sweep_rad)
    angle = item.first("angle")
    if angle is None:
        raise item.error(f"({item.head} …) has neither a mid point nor an angle. Save the board in KiCad again.")
    return arc(item.point("end"), item.point("start"), -math.radians(angle.number(0, _FULL_TURN_DEG)))


def _corners(item: Item) -> Points2:
    """Corners of a polygon; since version 7 an arc may stand among them."""
    points = item.first("pts")
    pieces: list[Points2] = []
    for part in points.items if points is not None else ():
        if part.head == "xy":
            pieces.append(part.here()[None, :])
        elif part.head == "arc":
            pieces.append(_arc(part))
    if not pieces:
        raise item.error(f"({item.head} …) has no points. Save the board in KiCad again.")
    return np.concatenate(pieces)
