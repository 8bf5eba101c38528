"""The XML of an Eagle board: the elements that matter, each with its line, and the lines they draw."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from boards.bounds import MOST_TURN_DEG, number_within
from boards.errors import BoardError, read_bytes
from boards.formats.loops import Point2, arc_between, circle, is_too_far
from boards.formats.placed import Pose
from boards.formats.xml_tree import XmlElement, XmlWords, read_xml
from geometry.arrays import Points2

_BINARY = (b"\x10\x00", b"\x10\x80")
_SAVE = "Open it in Eagle 6 or newer, or in KiCad, and save it there."


_WORDS = XmlWords(
    "Eagle board",
    "Save the board in Eagle again.",
    frozenset({"signals", "schematic", "autorouter", "errors", "classes", "symbols", "devicesets"}),
    deepest=30,  # Eagle nests about ten elements
    most_elements=5_000_000,
    most_kept=5_000_000,
    kept_texts=frozenset({"description"}),
)
"""Left out are copper, rules and circuit diagrams: most of a usual file."""


@dataclass(frozen=True, slots=True)
class Element(XmlElement):
    """One element of an Eagle file."""

    def point(self, mark: str = "") -> Point2:
        """Return the point of the attributes ``x`` and ``y``, with a number behind them if one is given, mm."""
        return np.array([self.number(f"x{mark}"), self.number(f"y{mark}")])

    def pose(self, at: Point2 | None = None) -> Pose:
        """Pose at a place, or at ``x`` and ``y``, by ``rot``: spin and mirror letters, ``R`` and degrees.

        ``MR90`` is turned by 90° as drawn, and its x then changes its sign.

        Raises:
            BoardError: It cannot be read.
        """
        text = self.word("rot").upper()
        letters, mark, degrees = text.rpartition("R")
        value = number_within(degrees, MOST_TURN_DEG) if text else 0.0
        if not math.isfinite(value) or set(letters) - {"S", "M"} or (text and not mark):
            raise self.error(f"rot of <{self.tag}> is {text[:40]!r}, not such as R90 or MR180. Save the board again.")
        x, y = (self.point() if at is None else at).tolist()
        return Pose(x, y, math.radians(-value if "M" in letters else value), "M" in letters)


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
    top = read_xml([data], path, _WORDS, Element)
    if top.tag != "eagle":
        raise top.error(f"not an Eagle board: it begins with <{top.tag[:40]}>. {_SAVE}")
    return top


def drawn(items: Iterable[Element], *layers: str) -> list[Points2]:
    """Polylines ``(n, 2)`` of what is drawn on some layers, mm; closed shapes end on their first point."""
    lines = (_polyline(item) for item in items if item.word("layer") in layers)
    return [line for line in lines if line is not None]


def _polyline(item: Element) -> Points2 | None:
    match item.tag:
        case "wire":
            return _stretch(item.point("1"), item.point("2"), item)
        case "circle":
            ring = circle(item.point(), item.number("radius"))
            return np.concatenate([ring, ring[:1]])
        case "rectangle":
            (ax, ay), (bx, by) = item.point("1"), item.point("2")
            middle = np.array([ax + bx, ay + by]) / 2.0
            return item.pose(middle).place(np.array([[ax, ay], [bx, ay], [bx, by], [ax, by], [ax, ay]]) - middle)
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
