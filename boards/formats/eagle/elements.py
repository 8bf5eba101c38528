"""The XML of an Eagle board: the elements that matter, each with its line, and the lines they draw."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from xml.parsers import expat

import numpy as np

from boards.bounds import FARTHEST_MM, MOST_TURN_DEG, number_within
from boards.errors import BoardError, Line, read_bytes
from boards.formats.loops import Point2, arc, arc_between, is_too_far
from geometry.arrays import Points2

_SKIPPED = frozenset({"signals", "schematic", "autorouter", "errors", "classes", "symbols", "devicesets"})
"""Copper, rules and circuit diagrams: most of a usual file."""

_DEEPEST = 30
"""Eagle nests about ten elements."""

_MOST_ELEMENTS = 5_000_000
_BINARY = (b"\x10\x00", b"\x10\x80")
_SAVE = "Open it in Eagle 6 or newer, or in KiCad, and save it there."


@dataclass(frozen=True, slots=True)
class Element(Line):
    """One element: its line, tag and attributes, its text, and the elements inside it."""

    tag: str
    attributes: dict[str, str]
    children: list["Element"] = field(default_factory=list["Element"])
    words: list[str] = field(default_factory=list[str])

    def all(self, *tags: str) -> Iterator["Element"]:
        """Yield the children with one of these tags, in file order."""
        return (child for child in self.children if child.tag in tags)

    def first(self, tag: str) -> "Element | None":
        """Return the first child with a tag, if there is one."""
        return next(self.all(tag), None)

    def inside(self, *tags: str) -> Iterator["Element"]:
        """Yield what is inside the children along a path of tags, such as ``libraries``, ``library``."""
        if not tags:
            yield from self.children
            return
        for child in self.all(tags[0]):
            yield from child.inside(*tags[1:])

    def word(self, name: str) -> str:
        """Return an attribute without blanks around it; empty if there is none."""
        return self.attributes.get(name, "").strip()

    def number(self, name: str, bound: float = FARTHEST_MM) -> float:
        """Return an attribute as a number.

        Raises:
            BoardError: It is missing, no number, or beyond the bound.
        """
        value = number_within(self.attributes.get(name, ""), bound)
        if not math.isfinite(value):
            stated = self.attributes.get(name, "nothing")
            raise self.error(
                f"{name} of <{self.tag}> must be a number from {-bound:g} to {bound:g}, not {stated[:40]!r}. "
                "Save the board in Eagle again."
            )
        return value

    def point(self, mark: str = "") -> Point2:
        """Return the point of the attributes ``x`` and ``y``, with a number behind them if one is given, mm."""
        return np.array([self.number(f"x{mark}"), self.number(f"y{mark}")])

    def turn(self) -> "Turn":
        """Return the attribute ``rot``: spin and mirror letters, ``R`` and degrees.

        Raises:
            BoardError: It cannot be read.
        """
        text = self.word("rot").upper()
        letters, mark, degrees = text.rpartition("R")
        value = number_within(degrees, MOST_TURN_DEG) if text else 0.0
        if not math.isfinite(value) or set(letters) - {"S", "M"} or (text and not mark):
            raise self.error(f"rot of <{self.tag}> is {text[:40]!r}, not such as R90 or MR180. Save the board again.")
        return Turn(math.radians(value), "M" in letters)


@dataclass(frozen=True, slots=True)
class Turn:
    """How something is turned, then mirrored: ``MR90`` is turned by 90° as drawn, and its x then changes its sign."""

    angle_rad: float
    is_mirrored: bool

    def matrix(self) -> Points2:
        """Return the matrix that rows of points are multiplied with from the right."""
        cos, sin = math.cos(self.angle_rad), math.sin(self.angle_rad)
        x_sign = -1.0 if self.is_mirrored else 1.0
        return np.array([[x_sign * cos, sin], [-x_sign * sin, cos]])

    def angle(self, inner_rad: float) -> float:
        """Angle on the board of an axis that has this angle in what is turned; a half turn more or less is the same."""
        angle = inner_rad + self.angle_rad
        return math.remainder(-angle if self.is_mirrored else angle, 2.0 * math.pi)


def read_elements(path: Path) -> Element:
    """Read the tree of an Eagle file without its copper; entities are never expanded, nothing else is opened.

    Returns:
        The element ``eagle``.

    Raises:
        BoardError: The file cannot be read, is no Eagle file of version 6 or later, or declares entities.
    """
    data = read_bytes(path)
    if data[:2] in _BINARY:
        raise BoardError(f"a board of Eagle 5 or older, in its binary format. {_SAVE}", file=path)
    if not data.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        raise BoardError(f"not a board of Eagle 6 or newer, which is XML. {_SAVE}", file=path)
    top = _parse(data, path)
    if top.tag != "eagle":
        raise top.error(f"not an Eagle board: it begins with <{top.tag[:40]}>. {_SAVE}")
    return top


class _Builder:
    """The tree of a file as its parser goes through it; what is skipped is counted and forgotten."""

    def __init__(self, path: Path) -> None:
        self.parser = expat.ParserCreate()
        self.top = Element(path, 1, "", {})
        self._opened = [self.top]
        self._skipped = self._count = 0
        self.parser.StartElementHandler = self._begin
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self.parser.EntityDeclHandler = self.parser.ExternalEntityRefHandler = self._refuse

    def _here(self) -> Line:
        return Line(self.top.file, self.parser.CurrentLineNumber)

    def _begin(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if len(self._opened) + self._skipped > _DEEPEST:
            raise self._here().error(f"elements are nested more than {_DEEPEST} deep. That is no Eagle board.")
        if self._count > _MOST_ELEMENTS:
            raise self._here().error(f"more than {_MOST_ELEMENTS:,} elements. That is no Eagle board.")
        if self._skipped or tag in _SKIPPED:
            self._skipped += 1
            return
        element = Element(self.top.file, self.parser.CurrentLineNumber, tag, attributes)
        self._opened[-1].children.append(element)
        self._opened.append(element)

    def _end(self, _: str) -> None:
        if self._skipped:
            self._skipped -= 1
        else:
            self._opened.pop()

    def _text(self, words: str) -> None:
        if not self._skipped and self._opened[-1].tag == "description":
            self._opened[-1].words.append(words)

    def _refuse(self, *_: object) -> int:
        raise self._here().error("declares entities, which no Eagle board does. Save the board in Eagle again.")


def _parse(data: bytes, path: Path) -> Element:
    builder = _Builder(path)
    try:
        builder.parser.Parse(data, True)
    except expat.ExpatError as error:
        message = f"not valid XML: {expat.errors.messages[error.code]}. Save the board in Eagle again."
        raise Line(path, error.lineno).error(message) from None
    except (LookupError, ValueError):  # the encoding that it states is unknown to Python, or of several bytes
        raise Line(path, 1).error("is in an encoding that is not read. Save the board in Eagle again.") from None
    return builder.top.children[0]


def drawn(items: Iterable[Element], *layers: str) -> list[Points2]:
    """Polylines ``(n, 2)`` of what is drawn on some layers, mm; closed shapes end on their first point."""
    lines = (_polyline(item) for item in items if item.word("layer") in layers)
    return [line for line in lines if line is not None]


def _polyline(item: Element) -> Points2 | None:
    match item.tag:
        case "wire":
            return _stretch(item.point("1"), item.point("2"), item)
        case "circle":
            centre = item.point()
            return arc(centre + np.array([item.number("radius"), 0.0]), centre, 2.0 * math.pi)
        case "rectangle":
            (ax, ay), (bx, by) = item.point("1"), item.point("2")
            middle = np.array([ax + bx, ay + by]) / 2.0
            corners = np.array([[ax, ay], [bx, ay], [bx, by], [ax, by], [ax, ay]])
            return (corners - middle) @ item.turn().matrix() + middle
        case "polygon":
            corners = list(item.all("vertex"))
            if len(corners) < 3:
                raise item.error("a polygon has fewer than three corners. Save the board in Eagle again.")
            pieces = [_stretch(a.point(), b.point(), a)[:-1] for a, b in pairwise([*corners, corners[0]])]
            return np.concatenate([*pieces, pieces[0][:1]])
        case _:
            return None


def _stretch(start: Point2, end: Point2, item: Element) -> Points2:
    """Line or arc; a positive ``curve`` turns counter-clockwise."""
    curve = item.number("curve", 360.0) if "curve" in item.attributes else 0.0
    if is_too_far(start, end, math.radians(curve)):
        raise item.error(
            f"curve of <{item.tag}> is {curve:g} degrees between two places: such an arc leads more than 10 m away. "
            "Draw a circle, or save the board in Eagle again."
        )
    return arc_between(start, end, math.radians(curve))
