"""Joints in rows and grids. Frame of the underside: x along its length, origin in its middle, mm."""

from collections.abc import Iterator
from dataclasses import replace

from boards.undersides.joint import Joint

LAND_MM = 0.4
"""Length of a land of QFN and DFN (JEDEC MO-220 and MO-229, L nominal)."""

_WIDEST_LAND_MM = 0.8

_ROW_MARGIN_MM = 1.5
"""What the row of lands is shorter than the side it stands along, from the first land's middle to the last's."""


def grid(columns: int, rows: int, pitch_mm: float, joint: Joint) -> tuple[Joint, ...]:
    """Repeat a joint on a full grid about the middle."""
    return tuple(
        replace(joint, x_mm=round(x, 4), y_mm=round(y, 4))
        for y in _places(rows, pitch_mm)
        for x in _places(columns, pitch_mm)
    )


def ends(length_mm: float, width_mm: float, size: tuple[float, float]) -> tuple[Joint, ...]:
    """Lay out two terminals at the ends of the length; sizes are parts of the underside's."""
    long, wide = round(size[0] * length_mm, 4), round(size[1] * width_mm, 4)
    x = round((length_mm - long) / 2.0, 4)
    return Joint(-x, 0.0, long, wide), Joint(x, 0.0, long, wide)


def corners(length_mm: float, width_mm: float, size: tuple[float, float]) -> tuple[Joint, ...]:
    """Lay out a land in each corner; sizes are parts of the underside's."""
    long, wide = round(size[0] * length_mm, 4), round(size[1] * width_mm, 4)
    x, y = round((length_mm - long) / 2.0, 4), round((width_mm - wide) / 2.0, 4)
    return tuple(Joint(sx * x, sy * y, long, wide) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1)))


def lands_in_front(
    count: int, pitch_mm: float, length_mm: float, width_mm: float, land_mm: float = LAND_MM
) -> Iterator[Joint]:
    """Lay lands along the front and the back edge, ``count`` along each and ``land_mm`` deep."""
    for x, y, along, inward in _row_pair(count, pitch_mm, length_mm, width_mm, land_mm):
        yield Joint(x, y, along, inward)


def lands_beside(
    count: int, pitch_mm: float, length_mm: float, width_mm: float, land_mm: float = LAND_MM
) -> Iterator[Joint]:
    """Lay lands along the right and the left edge, ``count`` along each and ``land_mm`` deep."""
    for y, x, along, inward in _row_pair(count, pitch_mm, width_mm, length_mm, land_mm):
        yield Joint(x, y, inward, along)


def clear_of_corner_mm(count: int, pitch_mm: float, side_mm: float) -> float:
    """How far from the corner a row's last land ends."""
    return (side_mm - (count - 0.5) * pitch_mm) / 2.0


def row_pitch_mm(count: int, side_mm: float) -> float:
    """Guess the pitch of a row from the side it stands along."""
    return max(side_mm - _ROW_MARGIN_MM, 0.6 * side_mm) / max(count - 1, 1)


def row_count(pitch_mm: float, side_mm: float) -> int:
    """Guess how many lands of a pitch stand along a side."""
    return int(max(side_mm - _ROW_MARGIN_MM, 0.6 * side_mm) / pitch_mm + 1e-6) + 1


def _row_pair(
    count: int, pitch_mm: float, side_mm: float, across_mm: float, land_mm: float
) -> Iterator[tuple[float, float, float, float]]:
    """Yield place along the side, place across, size along and size inward of two opposite rows."""
    along = round(min(0.5 * pitch_mm, _WIDEST_LAND_MM, side_mm - (count - 1) * pitch_mm), 4)
    inward = round(min(land_mm, 0.25 * across_mm), 4)
    edge = round((across_mm - inward) / 2.0, 4)
    for sign in (-1.0, 1.0):
        for place in _places(count, pitch_mm):
            yield round(place, 4), sign * edge, along, inward


def _places(count: int, pitch_mm: float) -> Iterator[float]:
    return ((k - (count - 1) / 2.0) * pitch_mm for k in range(count))
