"""Packages of a library and their placements on both sides, as IPC-2581, ODB++ and placement tables state them."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from shapely import MultiPolygon, Polygon
from shapely.affinity import affine_transform

from boards.board import Pad, Side
from boards.formats.layout import LayoutPart
from boards.formats.loops import box_around
from boards.packages.families import package_family
from boards.packages.heights import HeightEvidence
from geometry.arrays import Points2, Scalars

_LEAST_PAD_MM = 1e-3
_LEAST_BODY = 0.1
"""Part of the box around the pads that the drawing of a body covers at least; a smaller one is a mark."""


@dataclass(frozen=True, slots=True)
class Land:
    """The copper of one pin in the frame of its package, as seen from the package's own side; mm."""

    number: str
    pad: Pad
    flat: bool
    """Whether the pin is soldered to the surface, not through the board."""


@dataclass(frozen=True, slots=True, eq=False)
class PackageShape:
    """One package of the library, in its own frame as seen from its own side; mm."""

    name: str
    outline: Polygon | MultiPolygon | None
    """Of the body; ``None`` where none is drawn."""
    lands: tuple[Land, ...]
    pins: int | None
    height_mm: float | None = None
    description: str = ""

    @property
    def through_hole(self) -> bool:
        """Whether a pin goes through the board."""
        return any(not land.flat for land in self.lands)

    def body(self) -> tuple[Polygon | MultiPolygon | None, bool]:
        """Outline of the body, ``None`` if nothing has an area, and whether it is only the box around the pads."""
        pads = box_around([_corners(land.pad) for land in self.lands])
        if self.outline is not None and (pads is None or self.outline.area >= _LEAST_BODY * pads.area):
            return self.outline, False
        return pads, True


@dataclass(frozen=True, slots=True)
class PlacedPart:
    """Where a package stands. Board frame, mm, as seen from the top."""

    name: str
    x_mm: float
    y_mm: float
    turn_rad: float
    """Anticlockwise as seen from the top, after x was mirrored if it is."""
    side: Side
    is_mirrored: bool
    """Whether the package's x changes its sign before it is turned."""
    part: str = ""
    value: str = ""
    height_mm: float | None = None
    standoff_mm: float | None = None

    def matrix(self) -> Points2:
        """Matrix (2, 2) that columns of the package's frame are multiplied with from the left."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        mirror = -1.0 if self.is_mirrored else 1.0
        return np.array([[mirror * cos, -sin], [mirror * sin, cos]])


@dataclass(frozen=True, slots=True)
class TurnConvention:
    """How the stated rotation of a side's parts leads from the frame of their packages onto the board.

    Programs differ: clockwise or not, mirrored before or after the turn, packages drawn as seen from their own side or
    through the board.
    """

    is_mirrored: bool
    sign: float
    """1 where stated angles are anticlockwise as seen from the top, after mirroring; else -1."""
    quarters: int = 0
    """Quarter turns that are added."""

    def turn_rad(self, stated_rad: float) -> float:
        """Turn of a part as ``PlacedPart`` has it."""
        return math.remainder(self.sign * stated_rad + self.quarters * math.pi / 2.0, 2.0 * math.pi)


def fit_convention(pins: Points2, places: Points2, stated_rad: Scalars, usual: TurnConvention) -> TurnConvention:
    """Find the convention under which pins come to lie where the file places their copper.

    Args:
        pins: (n, 2) pins of many parts in the frames of their packages, mm.
        places: (n, 2) where the file places them, less the places of their parts, mm.
        stated_rad: (n,) rotation stated for the part of each pin.
        usual: Taken where others fit no better.
    """
    if not len(pins):
        return usual
    known = [TurnConvention(mirrored, sign, n) for mirrored in (False, True) for sign in (1.0, -1.0) for n in range(4)]
    return min((usual, *known), key=lambda each: round(_misfit(each, pins, places, stated_rad), 3))


def _misfit(convention: TurnConvention, pins: Points2, places: Points2, stated_rad: Scalars) -> float:
    """Mean distance of pins from their places, mm."""
    turn = convention.sign * stated_rad + convention.quarters * math.pi / 2.0
    x = -pins[:, 0] if convention.is_mirrored else pins[:, 0]
    placed = np.column_stack(
        [x * np.cos(turn) - pins[:, 1] * np.sin(turn), x * np.sin(turn) + pins[:, 1] * np.cos(turn)]
    )
    return float(np.hypot(*(placed - places).T).mean())


def layout_part(placed: PlacedPart, package: PackageShape) -> LayoutPart | None:
    """Stand a package on the board; ``None`` where it has no body, no pad with an area."""
    outline, from_pads = package.body()
    if outline is None:
        return None
    (a, b), (d, e) = placed.matrix().tolist()
    x0, y0, x1, y1 = outline.bounds
    return LayoutPart(
        placed.name,
        affine_transform(outline, [a, b, d, e, placed.x_mm, placed.y_mm]),
        placed.side,
        HeightEvidence(package.name, placed.name, (), package.description, package.through_hole, max(x1 - x0, y1 - y0)),
        from_pads,
        part=placed.part,
        value=placed.value,
        pins=package.pins,
        pads=tuple(_place_pads(placed, package.lands)),
        stated_height_mm=package.height_mm if placed.height_mm is None else placed.height_mm,
        gap_height_mm=placed.standoff_mm,
    )


def has_no_body(package: PackageShape) -> bool:
    """Whether it is copper, print or a hole: by its family, or because at most one pad and no body is there."""
    family = package_family(package.name)
    if family is not None:
        return not family.has_body
    return len(package.lands) < 2 and package.outline is None


def _place_pads(placed: PlacedPart, lands: Sequence[Land]) -> Iterator[Pad]:
    matrix = placed.matrix()
    mirror = -1.0 if placed.is_mirrored else 1.0
    for land in lands:
        pad = land.pad
        if not land.flat or min(pad.length_mm, pad.width_mm) < _LEAST_PAD_MM:
            continue
        x, y = (matrix @ np.array([pad.x_mm, pad.y_mm]) + [placed.x_mm, placed.y_mm]).tolist()
        turn = math.remainder(placed.turn_rad + mirror * pad.turn_rad, 2.0 * math.pi)
        yield Pad(x, y, pad.length_mm, pad.width_mm, turn, pad.round)


def _corners(pad: Pad) -> Points2:
    cos, sin = math.cos(pad.turn_rad), math.sin(pad.turn_rad)
    half = np.array([pad.length_mm, pad.width_mm]) / 2.0
    corners = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) * half
    return corners @ np.array([[cos, sin], [-sin, cos]]) + [pad.x_mm, pad.y_mm]


@dataclass(frozen=True, slots=True)
class StepPlace:
    """One repetition of a board's step on a panel, as the file states it. Millimetres and radians."""

    x_mm: float
    y_mm: float
    """Of the origin of the board's frame, on the panel."""
    turn_rad: float
    """Anticlockwise as seen from the panel's top, after x was mirrored if the board is turned over."""
    is_turned_over: bool


@dataclass(frozen=True, slots=True, eq=False)
class StepPanel:
    """How a file repeats its board."""

    places: tuple[StepPlace, ...]
    outline: Polygon | MultiPolygon | None
    """Profile of the panel; ``None`` where it has none."""


MOST_PLACES = 1000
