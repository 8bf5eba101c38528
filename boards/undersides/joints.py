"""The joints beneath a package, from its family, its name, its pins and the size of its underside."""

import math
from dataclasses import dataclass

from boards.packages.package_sizes import PackageSizes
from boards.packages.underside_family import FINE_PITCH_MM, UndersideFamily
from boards.undersides.joint import Joint
from boards.undersides.joint_rows import (
    LAND_MM,
    clear_of_corner_mm,
    corners,
    ends,
    grid,
    lands_beside,
    lands_in_front,
    row_count,
    row_pitch_mm,
)

_BALL = 0.55
"""Diameter of a soldered ball in pitches: 0.55 mm at 1.0, 0.44 at 0.8, 0.28 at 0.5 (JEDEC MO-192 and MO-195)."""

_LAND = 0.6
"""Side of a land of an LGA in pitches (maker's typical)."""

_FEW_LANDS = 32
"""An LGA with no more pins than this, and no grid in its name, has its lands along the edges, as sensors do."""

_MANY = 0.5
"""Length and width of the heat pad, as shares of the underside, where joints are unknown and many are assumed."""

_DEFAULT_PITCH_MM = 0.5
_LEAST_LAND_MM = 0.1


@dataclass(frozen=True, slots=True)
class Package:
    """What is known of one package and its underside."""

    sizes: PackageSizes
    pins: int
    """0 if unknown; exposed pads are not counted."""
    length_mm: float
    width_mm: float


def joints_of(family: UndersideFamily, package: Package) -> tuple[Joint, ...] | None:
    """Lay out the joints of a family; ``None`` where they are unknown."""
    match family.joints:
        case "outside":
            return _exposed_pad(package) if package.sizes.has_pad else ()
        case "ends" | "folded" | "corners":
            return _terminals(family, package)
        case "tab":
            length, width = (round(part * side, 4) for part, side in zip(family.size, _sides(package), strict=True))
            return (Joint(0.0, 0.0, length, width),)
        case "quad":
            return _quad(package) + _thermal(package)
        case "dual":
            return _dual(package) + _thermal(package)
        case "balls":
            return _grid(package, _BALL, package.sizes.ball_mm)
        case "lands":
            return _lands(package)
        case "unknown" | "none":
            return None


def _sides(package: Package) -> tuple[float, float]:
    return package.length_mm, package.width_mm


def _terminals(family: UndersideFamily, package: Package) -> tuple[Joint, ...]:
    """Two terminals at the ends; more of them in the corners, or of a chip array along the length."""
    length, width = _sides(package)
    half = package.pins // 2
    match family.joints:
        case "ends" if half > 1:
            return tuple(lands_in_front(half, length / half, length, width))
        case "ends":
            return ends(length, width, (family.share / 2.0, 1.0))
        case "corners" if half > 1:
            return corners(length, width, family.size)
        case _:
            return ends(length, width, family.size)


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
    return sizes_mm if _is_x_along_length(package) else (sizes_mm[1], sizes_mm[0])


def _is_x_along_length(package: Package) -> bool:
    """Whether the first size of the name lies along the length; of a square it does not, so rows lie along it."""
    body = package.sizes.body_mm
    return body is not None and body[0] > body[1]


def _quad(package: Package) -> tuple[Joint, ...]:
    length, width = package.length_mm, package.width_mm
    pitch = package.sizes.pitch_mm
    half = package.pins // 2
    if half >= 2:
        # a + b = half of the pins, and the longer side holds more by the difference of the sides.
        more = (length - width) / pitch if pitch else half * (length - width) / (length + width)
        front = min(max(round((half + more) / 2.0), 1), half - 1)
        beside = half - front
    else:
        front = row_count(pitch or _DEFAULT_PITCH_MM, length)
        beside = row_count(pitch or _DEFAULT_PITCH_MM, width)
        pitch = pitch or _DEFAULT_PITCH_MM
    in_front = front, _fitting(pitch, front, length), length
    at_side = beside, _fitting(pitch, beside, width), width
    # Where two rows meet in a corner the lands are as much shorter as keeps them apart.
    land = min(LAND_MM, max(clear_of_corner_mm(*in_front), clear_of_corner_mm(*at_side), _LEAST_LAND_MM))
    rows = lands_in_front(*in_front, width, land), lands_beside(*at_side[:2], length, width, land)
    return (*rows[0], *rows[1])


def _dual(package: Package) -> tuple[Joint, ...]:
    length, width = package.length_mm, package.width_mm
    beside = _is_x_along_length(package)
    side = width if beside else length
    pitch = package.sizes.pitch_mm
    count = package.pins // 2 if package.pins >= 2 else row_count(pitch or _DEFAULT_PITCH_MM, side)
    rows = lands_beside if beside else lands_in_front
    return tuple(rows(count, _fitting(pitch, count, side), length, width))


def _fitting(pitch_mm: float | None, count: int, side_mm: float) -> float:
    """The pitch, or one with which the row fits along its side."""
    if pitch_mm is not None and (count - 0.5) * pitch_mm <= side_mm:
        return pitch_mm
    return row_pitch_mm(count, side_mm)


def _lands(package: Package) -> tuple[Joint, ...]:
    if package.sizes.layout is None and package.pins <= _FEW_LANDS:
        return _quad(package)
    return _grid(package, _LAND, None)


def _grid(package: Package, share: float, ball_mm: float | None) -> tuple[Joint, ...]:
    """Lay out the whole grid: which places are empty is not known from a name."""
    length, width = _sides(package)
    pitch = package.sizes.pitch_mm
    if package.sizes.layout is not None:
        columns, rows = (round(count) for count in _turned(package, package.sizes.layout))
    else:
        columns, rows = _grid_counts(package)
    if pitch is None or (columns - 0.1) * pitch > length or (rows - 0.1) * pitch > width:
        pitch = round(min(length / (columns + 0.8), width / (rows + 0.8)), 3)
    size = round(min(ball_mm or share * pitch, 0.9 * pitch), 4)
    return grid(columns, rows, pitch, Joint(0.0, 0.0, size, size, round=share == _BALL))


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
