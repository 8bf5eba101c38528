"""One package of an Eagle library, and its placement on the board."""

import html
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from shapely import MultiPolygon, Polygon
from shapely.affinity import affine_transform

from boards.board import Pad, Side
from boards.formats.eagle.elements import Element, Turn, drawn
from boards.formats.loops import DRILL_MM, Point2, arc, box_around, enclosed
from geometry.arrays import Points2

EDGE = "20"
_BODY = ("21", "51")
"""tPlace and tDocu: print, and the drawing of the part."""

_KEEPOUT = ("39",)
_COPPER = "1"
_LEAST_PAD_MM = 1e-3
_LEAST_BODY = 0.25
"""Part of the box around the pads that the drawing of a body covers at least; pins alone cover less."""
_RIM = 1.7
"""Diameter of a pad as a multiple of its drill, where the file leaves it to the design rules."""


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """An element: where a package is placed. Board frame, mm."""

    origin: Point2
    turn: Turn

    @property
    def side(self) -> Side:
        """Mirrored elements lie on the bottom."""
        return "bottom" if self.turn.is_mirrored else "top"

    def place(self, points: Points2) -> Points2:
        """Bring points of the package's frame ``(n, 2)`` onto the board."""
        return points @ self.turn.matrix() + self.origin

    def place_outline(self, outline: Polygon | MultiPolygon) -> Polygon | MultiPolygon:
        """Bring an outline onto the board."""
        (a, d), (b, e) = self.turn.matrix().tolist()
        return affine_transform(outline, [a, b, d, e, float(self.origin[0]), float(self.origin[1])])


def description_of(package: Element) -> str:
    """Text of a package's description, which is HTML inside XML."""
    described = package.first("description")
    return "" if described is None else html.unescape("".join(described.words))[:2000]


def has_contacts(package: Element) -> bool:
    """Whether anything is soldered to it."""
    return any(True for _ in package.all("pad", "smd"))


def is_copper(package: Element) -> bool:
    """Whether nothing but one pad is there: a fiducial, a test point or a wire pad."""
    return len(list(package.all("pad", "smd"))) < 2 and not drawn(package.children, *_BODY)


def body_outline(package: Element) -> tuple[Polygon | MultiPolygon | None, bool]:
    """Outline of the body in the package's frame: its drawing, else its keep-out, else the box around pads and lines.

    A drawing that is small beside the pads is a mark, not a body.

    Returns:
        The outline (``None`` if nothing has an area), and whether it is only the box around pads and lines.
    """
    lines = drawn(package.children, *_BODY)
    contacts = [_corners(item) for item in package.all("pad", "smd")]
    pads = box_around(contacts)
    for drawing in (lines, drawn(package.children, *_KEEPOUT)):
        body = enclosed(drawing)
        if body is not None and (pads is None or body.area >= _LEAST_BODY * pads.area):
            return body, False
    return box_around([*contacts, *lines]), True


def _corners(item: Element) -> Points2:
    if item.tag == "smd":
        half = np.array([item.number("dx"), item.number("dy")]) / 2.0
    else:
        stated = "diameter" in item.attributes and item.word("diameter") != "0"
        half = np.full(2, item.number("diameter") if stated else _RIM * item.number("drill")) / 2.0
    corners = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) * half
    return corners @ item.turn().matrix() + item.point()


def flat_pads(package: Element, placement: Placement) -> tuple[Pad, ...]:
    """Surface-mount pads on the element's own side, in file order. Board frame, mm."""
    own = (item for item in package.all("smd") if item.word("layer") == _COPPER)
    return tuple(pad for item in own for pad in _flat_pad(item, placement))


def _flat_pad(item: Element, placement: Placement) -> Iterator[Pad]:
    length, width = item.number("dx"), item.number("dy")
    if min(length, width) < _LEAST_PAD_MM:
        return
    x, y = placement.place(item.point()[None, :])[0].tolist()
    roundness = item.number("roundness", 100.0) if "roundness" in item.attributes else 0.0
    is_round = roundness >= 100.0 and abs(length - width) < _LEAST_PAD_MM
    yield Pad(x, y, length, width, placement.turn.angle(item.turn().angle_rad), is_round)


def drill_loops(items: Element) -> list[Points2]:
    """Drilled holes from 1 mm across of a package or of the board itself, in their frame, as open rings."""
    loops: list[Points2] = []
    for item in items.all("hole", "pad"):
        drill_mm = item.number("drill")
        if drill_mm >= DRILL_MM:
            centre = item.point()
            loops.append(arc(centre + np.array([drill_mm / 2.0, 0.0]), centre, 2.0 * math.pi)[:-1])
    return loops
