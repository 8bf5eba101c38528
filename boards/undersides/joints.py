"""Solder joints beneath a package: from the pads that the board file states, or laid out by its family.

Frame of the underside: x along its length, origin in its middle, mm.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from boards.board import Pad
from boards.packages.families import PackageSizes
from boards.packages.undersides import FINE_PITCH_MM, UndersideFamily
from boards.undersides.body_rectangle import Rectangle, lengthwise
from geometry.gridframe import GridFrame

_LAND_MM = 0.4
"""Length of a land of QFN and DFN (JEDEC MO-220 and MO-229, L nominal)."""

_WIDEST_LAND_MM = 0.8

_ROW_MARGIN_MM = 1.5
"""What the row of lands is shorter than the side it stands along, from the first land's middle to the last's."""

_BALL = 0.55
"""Diameter of a soldered ball in pitches: 0.55 mm at 1.0, 0.44 at 0.8, 0.28 at 0.5 (JEDEC MO-192 and MO-195)."""

_LAND = 0.6
"""Side of a land of an LGA in pitches (maker's typical)."""

_FEW_LANDS = 32
"""An LGA with no more pins than this, and no grid in its name, has its lands along the edges, as sensors do."""

_MANY = 0.5
"""Length and width of the heat pad, as shares of the underside, where joints are unknown and many are assumed."""

_Places: TypeAlias = tuple[tuple[float, float], ...]
_ENDS: _Places = ((-1.0, 0.0), (1.0, 0.0))
_CORNERS: _Places = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
_DEFAULT_PITCH_MM = 0.5
_LEAST_LAND_MM = 0.1
_SKEW_RAD = 1e-4
_LEAST_MM = 0.01
_LEAST_BODY = 0.25
_LONGEST_END = 0.3
"""Longest termination of a chip as a part of its length: 0.3 mm of 1.0 at 0402, less in larger ones (typical)."""

_LONGER = 1.1
_EDGE_MM = 3e-5
"""Places are stated in decimals; none of them is this far from an edge, so that the last bits decide nothing."""


@dataclass(frozen=True, slots=True)
class Joint:
    """One solder joint in a gap, in the frame of the underside: x along its length, origin in its middle. mm."""

    x_mm: float
    y_mm: float
    length_mm: float
    """Along x before it is turned; the diameter if it is round."""
    width_mm: float
    round: bool = False
    turn_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class Package:
    """One package and its underside, as far as it is known."""

    sizes: PackageSizes
    pins: int
    """0 if unknown; exposed pads are not counted."""
    length_mm: float
    width_mm: float

    @property
    def sides_mm(self) -> tuple[float, float]:
        """Length and width."""
        return self.length_mm, self.width_mm

    @property
    def is_x_along_length(self) -> bool:
        """Whether the first size of the name lies along the length; of a square it does not, so rows lie along it."""
        return self.sizes.body_mm is not None and self.sizes.body_mm[0] > self.sizes.body_mm[1]


def joints_of(family: UndersideFamily, package: Package) -> tuple[Joint, ...] | None:
    """Lay out the joints of a family; ``None`` where they are unknown."""
    match family.joints:
        case "outside":
            return _exposed_pad(package) if package.sizes.has_pad else ()
        case "ends" | "folded" | "corners":
            return _terminals(family, package)
        case "tab":
            length, width = (round(part * side, 4) for part, side in zip(family.size, package.sides_mm, strict=True))
            return (Joint(0.0, 0.0, length, width),)
        case "quad":
            return _quad(package) + _thermal(package)
        case "dual":
            return _dual(package) + _thermal(package)
        case "balls":
            return _grid(package, _BALL, package.sizes.ball_mm)
        case "lands" if package.sizes.layout is None and package.pins <= _FEW_LANDS:
            return _quad(package)
        case "lands":
            return _grid(package, _LAND, None)
        case "unknown" | "none":
            return None


def _terminals(family: UndersideFamily, package: Package) -> tuple[Joint, ...]:
    """Two terminals at the ends; more of them in the corners, or of a chip array along the length."""
    length, width = package.sides_mm
    half = package.pins // 2
    match family.joints:
        case "ends" if half > 1:
            return tuple(_row_pair(half, length / half, (length, width), 0))
        case "ends":
            return _lands_at(package, (family.share / 2.0, 1.0), _ENDS)
        case "corners" if half > 1:
            return _lands_at(package, family.size, _CORNERS)
        case _:
            return _lands_at(package, family.size, _ENDS)


def many_joints(package: Package) -> tuple[Joint, ...]:
    """Lay out what an unknown underside may hold at most, as lands along all sides and a heat pad."""
    pad = Joint(0.0, 0.0, round(_MANY * package.length_mm, 4), round(_MANY * package.width_mm, 4))
    return (*_quad(package), pad)


def _thermal(package: Package) -> tuple[Joint, ...]:
    """The heat pad of a leadless package: there, unless the name states a pitch but no pad."""
    return () if package.sizes.has_pad is False else _exposed_pad(package)


def _exposed_pad(package: Package) -> tuple[Joint, ...]:
    """The pad as the name states it, or as KiCad's QFN of 3 to 7 mm have it: 0.86 of the side less 0.87 mm."""
    if package.sizes.pad_mm is not None:
        length, width = _turned(package, package.sizes.pad_mm)
        return (Joint(0.0, 0.0, min(length, package.length_mm), min(width, package.width_mm)),)
    length, width = (
        round(min(max(0.86 * side - 0.87, 0.4 * side), 0.8 * side), 4) for side in (package.length_mm, package.width_mm)
    )
    return (Joint(0.0, 0.0, length, width),)


def _turned(package: Package, sizes_mm: tuple[float, float]) -> tuple[float, float]:
    """Turn sizes that are in the order of the name's body so that they lie along length and width."""
    return sizes_mm if package.is_x_along_length else (sizes_mm[1], sizes_mm[0])


def _quad(package: Package) -> tuple[Joint, ...]:
    length, width = package.sides_mm
    pitch = package.sizes.pitch_mm
    half = package.pins // 2
    if half >= 2:
        # a + b = half of the pins, and the longer side holds more by the difference of the sides.
        more = (length - width) / pitch if pitch else half * (length - width) / (length + width)
        front = min(max(round((half + more) / 2.0), 1), half - 1)
        beside = half - front
    else:
        front = _row_count(pitch or _DEFAULT_PITCH_MM, length)
        beside = _row_count(pitch or _DEFAULT_PITCH_MM, width)
        pitch = pitch or _DEFAULT_PITCH_MM
    in_front = front, _fitting(pitch, front, length), length
    at_side = beside, _fitting(pitch, beside, width), width
    # Where two rows meet in a corner the lands are as much shorter as keeps them apart.
    land = min(_LAND_MM, max(_corner_distance_mm(*in_front), _corner_distance_mm(*at_side), _LEAST_LAND_MM))
    sides = package.sides_mm
    rows = _row_pair(*in_front[:2], sides, 0, land), _row_pair(*at_side[:2], sides, 1, land)
    return (*rows[0], *rows[1])


def _dual(package: Package) -> tuple[Joint, ...]:
    length, width = package.sides_mm
    beside = package.is_x_along_length
    side = width if beside else length
    pitch = package.sizes.pitch_mm
    count = package.pins // 2 if package.pins >= 2 else _row_count(pitch or _DEFAULT_PITCH_MM, side)
    return tuple(_row_pair(count, _fitting(pitch, count, side), (length, width), 1 if beside else 0))


def _fitting(pitch_mm: float | None, count: int, side_mm: float) -> float:
    """The pitch, or one with which the row fits along its side."""
    if pitch_mm is not None and (count - 0.5) * pitch_mm <= side_mm:
        return pitch_mm
    return max(side_mm - _ROW_MARGIN_MM, 0.6 * side_mm) / max(count - 1, 1)


def _grid(package: Package, share: float, ball_mm: float | None) -> tuple[Joint, ...]:
    """Lay out the whole grid: which places are empty is not known from a name."""
    length, width = package.sides_mm
    pitch = package.sizes.pitch_mm
    if package.sizes.layout is not None:
        columns, rows = (round(count) for count in _turned(package, package.sizes.layout))
    else:
        columns, rows = _grid_counts(package)
    if pitch is None or (columns - 0.1) * pitch > length or (rows - 0.1) * pitch > width:
        pitch = round(min(length / (columns + 0.8), width / (rows + 0.8)), 3)
    size = round(min(ball_mm or share * pitch, 0.9 * pitch), 4)
    return tuple(
        Joint(round(x, 4), round(y, 4), size, size, round=share == _BALL)
        for y in _places(rows, pitch)
        for x in _places(columns, pitch)
    )


def _grid_counts(package: Package) -> tuple[int, int]:
    """How many fit: the outer ones stand about a pitch from the edge (0.8 from their middles)."""
    length, width, pins = package.length_mm, package.width_mm, package.pins
    root = math.isqrt(pins)
    square = abs(length - width) < 0.05 * length
    if square and root * root == pins and pins:
        return root, root
    pitch = package.sizes.pitch_mm
    if pitch is None:
        pitch = math.sqrt(length * width / pins) * 0.95 if pins else max(FINE_PITCH_MM, 0.8)
    columns, rows = (max(int(side / pitch - 0.6 + 1e-6), 1) for side in (length, width))
    return columns, rows


def _lands_at(package: Package, size: tuple[float, float], places: _Places) -> tuple[Joint, ...]:
    """Lay out lands at the ends or in the corners; sizes are parts of the underside's."""
    length_mm, width_mm = package.sides_mm
    long, wide = round(size[0] * length_mm, 4), round(size[1] * width_mm, 4)
    x, y = round((length_mm - long) / 2.0, 4), round((width_mm - wide) / 2.0, 4)
    return tuple(Joint(sx * x, sy * y, long, wide) for sx, sy in places)


def _corner_distance_mm(count: int, pitch_mm: float, side_mm: float) -> float:
    """How far from the corner a row's last land ends."""
    return (side_mm - (count - 0.5) * pitch_mm) / 2.0


def _row_count(pitch_mm: float, side_mm: float) -> int:
    """Guess how many lands of a pitch stand along a side."""
    return int(max(side_mm - _ROW_MARGIN_MM, 0.6 * side_mm) / pitch_mm + 1e-6) + 1


def _row_pair(
    count: int, pitch_mm: float, sides_mm: tuple[float, float], along: Literal[0, 1], land_mm: float = _LAND_MM
) -> Iterator[Joint]:
    """Lay lands along two opposite edges, ``count`` along each and ``land_mm`` deep.

    Args:
        count: Along each edge.
        pitch_mm: From one land to the next.
        sides_mm: Length and width of the underside.
        along: 0 for the front and the back edge, which go along the length, 1 for those along the width.
        land_mm: How far a land reaches inwards.
    """
    side, across = sides_mm[along], sides_mm[1 - along]
    size = round(min(0.5 * pitch_mm, _WIDEST_LAND_MM, side - (count - 1) * pitch_mm), 4)
    inward = round(min(land_mm, 0.25 * across), 4)
    edge = round((across - inward) / 2.0, 4)
    for sign in (-1.0, 1.0):
        for place in _places(count, pitch_mm):
            if along:
                yield Joint(sign * edge, round(place, 4), inward, size)
            else:
                yield Joint(round(place, 4), sign * edge, size, inward)


def _places(count: int, pitch_mm: float) -> Iterator[float]:
    return ((k - (count - 1) / 2.0) * pitch_mm for k in range(count))


def joints_under(pads: Sequence[Pad], rectangle: Rectangle) -> tuple[Joint, ...]:
    """Find what of the pads lies under the body: those along its edges are cut off there.

    Round pads, and those that stand askew, count as a whole if their middle is under the body.

    Args:
        pads: Of the component. Board frame, mm.
        rectangle: The underside.
    """
    joints: list[Joint] = []
    for pad in pads:
        x, y = rectangle.to_local(np.array([[pad.x_mm, pad.y_mm]]))[0].tolist()
        turn = math.remainder(pad.turn_rad - rectangle.turn_rad, math.pi)
        quarters = round(turn / (math.pi / 2.0))
        if not pad.round and abs(turn - quarters * math.pi / 2.0) < _SKEW_RAD:
            sizes = (pad.width_mm, pad.length_mm) if quarters % 2 else (pad.length_mm, pad.width_mm)
            # An upright rectangle is cut at the edges of the underside; next to nothing may remain.
            left, right = _overlap(x, sizes[0], rectangle.length_mm)
            front, back = _overlap(y, sizes[1], rectangle.width_mm)
            place = _tidy((left + right) / 2.0), _tidy((front + back) / 2.0)
            if min(right - left, back - front) >= _LEAST_MM + _EDGE_MM:
                joints.append(Joint(*place, _tidy(right - left), _tidy(back - front)))
        elif _is_amid(pad, rectangle):
            angle = 0.0 if pad.round else round(turn, 6)
            joints.append(Joint(_tidy(x), _tidy(y), _tidy(pad.length_mm), _tidy(pad.width_mm), pad.round, angle))
    return tuple(joints)


def joints_amid(pads: Sequence[Pad], rectangle: Rectangle) -> tuple[Joint, ...]:
    """Find the pads whose middle is under the body: those of leads beside it begin there, but do not reach it."""
    return joints_under([pad for pad in pads if _is_amid(pad, rectangle)], rectangle)


def joints_at_ends(pads: Sequence[Pad], rectangle: Rectangle) -> tuple[Joint, ...]:
    """Find what of a chip's pads lies under its two terminations: solder does not hold to the body between them."""
    ends: list[Joint] = []
    inner = (0.5 - _LONGEST_END) * rectangle.length_mm
    for joint in joints_under(pads, rectangle):
        near, far = abs(joint.x_mm) - joint.length_mm / 2.0, abs(joint.x_mm) + joint.length_mm / 2.0
        if far - inner < _LEAST_MM + _EDGE_MM:
            continue
        if near < inner and not joint.round and joint.turn_rad == 0.0:
            middle = math.copysign((inner + far) / 2.0, joint.x_mm)
            joint = replace(joint, x_mm=_tidy(middle), length_mm=_tidy(far - inner))
        ends.append(joint)
    return tuple(ends)


def body_between(pads: Sequence[Pad], rectangle: Rectangle, frame: GridFrame) -> Rectangle:
    """Make an outline that was drawn around the leads as narrow as the space between their pads.

    The pad of a lead is longer the way the lead goes. A heat pad in the middle may remain; where no more than one pad
    begins under the outline, it is the body's.
    """
    middle = replace(rectangle, length_mm=rectangle.length_mm / 4.0, width_mm=rectangle.width_mm / 4.0)
    leads = [pad for pad in pads if not _is_amid(pad, middle)]
    if not any(_is_amid(pad, rectangle) for pad in leads):
        return rectangle
    half = [rectangle.length_mm / 2.0, rectangle.width_mm / 2.0]
    for pad in leads:
        spot = np.abs(rectangle.to_local(np.array([[pad.x_mm, pad.y_mm]]))[0])
        turn = math.remainder(pad.turn_rad - rectangle.turn_rad, math.pi)
        sizes = (pad.length_mm, pad.width_mm) if abs(turn) < math.pi / 4.0 else (pad.width_mm, pad.length_mm)
        along = 0 if sizes[0] > sizes[1] else 1
        inner = float(spot[along]) - sizes[along] / 2.0
        if inner > _LEAST_BODY * half[along] and max(sizes) > _LONGER * min(sizes):
            half[along] = min(half[along], round(inner, 4))
    return lengthwise(replace(rectangle, length_mm=2.0 * half[0], width_mm=2.0 * half[1]), frame)


def _is_amid(pad: Pad, rectangle: Rectangle) -> bool:
    x, y = rectangle.to_local(np.array([[pad.x_mm, pad.y_mm]]))[0]
    half = rectangle.length_mm / 2.0 - _EDGE_MM, rectangle.width_mm / 2.0 - _EDGE_MM
    return bool(abs(x) < half[0] and abs(y) < half[1])


def _overlap(middle: float, size_mm: float, side_mm: float) -> tuple[float, float]:
    return max(middle - size_mm / 2.0, -side_mm / 2.0), min(middle + size_mm / 2.0, side_mm / 2.0)


def _tidy(value: float) -> float:
    return round(value, 4) + 0.0
