"""The rectangle of a component's body, without the leads beside it, in a frame that moves with the board."""

import math
from dataclasses import dataclass, replace

import numpy as np
import shapely

from boards.board import Board, Body, Component
from geometry.arrays import Points2
from geometry.gridframe import GridFrame
from geometry.mesh import areas_and_normals
from geometry.polygons import polygons_of, project

_HIGHEST_MM = 1.0
_LEVEL_MM = 0.01
_FLAT = 0.99
_SLACK_MM = 0.3
_SQUARE = 0.01
_ANGLE_RAD = 1e-6
_LENGTH_MM = 1e-4
_ALIKE = 1.001
"""Rectangles whose areas differ by less are equally small: tessellated arcs must not choose the direction."""


@dataclass(frozen=True, slots=True)
class Rectangle:
    """Where an underside is. Board frame, mm; the length is never less than the width."""

    x_mm: float
    y_mm: float
    turn_rad: float
    """From the board's x to the direction of the length."""
    length_mm: float
    width_mm: float

    def to_local(self, points: Points2) -> Points2:
        """Bring (n, 2) points of the board into the frame of the rectangle."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        return (points - np.array([self.x_mm, self.y_mm])) @ np.array([[cos, -sin], [sin, cos]])


def frame_of(board: Board) -> GridFrame:
    """Take the frame in which directions and ties are decided from the board's outline."""
    x, y = board.outline.exterior.coords[0][:2]
    return GridFrame((float(x), float(y)), board.axis)


def outline_rectangle(component: Component, frame: GridFrame) -> Rectangle | None:
    """Smallest rectangle around everything that a component shows from the top; ``None`` where it has no area."""
    return smallest_rectangle(np.asarray(component.outline.exterior.coords)[:, :2], frame)


def body_rectangle(body: Body, component: Component, surface_z_mm: float, frame: GridFrame) -> Rectangle | None:
    """Smallest rectangle around the underside of the body, found in its mesh.

    That is the lowest level, not above 1 mm, whose faces that look at the board have at least half the area of the
    largest: the feet of leads are lower but small. ``None`` where no level has a tenth of the outline's area.
    """
    up = 1.0 if component.side == "top" else -1.0
    heights = up * (body.patches[:, :, 2] - surface_z_mm)
    low = (heights.max(axis=1) <= _HIGHEST_MM) & (up * body.normals[:, 2] < -_FLAT)
    levels = np.round(np.maximum(heights[low, 0], 0.0) / _LEVEL_MM).astype(np.int64)
    if not len(levels):
        return None
    faces = body.patches[low]
    areas = np.round(np.bincount(levels, areas_and_normals(faces)[0]), 4)
    if areas.max() < 0.1 * component.outline.area:
        return None
    lowest = int(np.argmax(areas >= 0.5 * areas.max()))
    pieces = polygons_of(project(frame.triangles_to_frame(faces[levels == lowest])))
    largest = max(piece.area for piece in pieces)
    points = [shapely.get_coordinates(piece.exterior) for piece in pieces if piece.area > 0.45 * largest]
    return _smallest_in_frame(np.concatenate(points), frame)


def smallest_rectangle(points: Points2, frame: GridFrame) -> Rectangle | None:
    """Smallest rectangle around points; of equally small ones the one that lies most along the board's axis.

    A square's length lies along the axis as well. A rectangle has area only if both of its sides have length.
    """
    return _smallest_in_frame(frame.to_frame(points), frame)


def _smallest_in_frame(points: Points2, frame: GridFrame) -> Rectangle | None:
    hull = shapely.convex_hull(shapely.MultiPoint(np.unique(points, axis=0)))
    if hull.geom_type != "Polygon":
        return None
    ring = shapely.get_coordinates(hull)
    edges = np.diff(ring, axis=0)
    edges = edges[np.hypot(edges[:, 0], edges[:, 1]) > 10 * _LENGTH_MM]
    quarter = math.pi / 2.0
    turns = np.arctan2(edges[:, 1], edges[:, 0])
    turns = np.append(turns - quarter * np.round(np.round(turns / quarter, 9)), 0.0)
    cos, sin = np.cos(turns), np.sin(turns)
    along = np.outer(cos, ring[:, 0]) + np.outer(sin, ring[:, 1])
    across = np.outer(cos, ring[:, 1]) - np.outer(sin, ring[:, 0])
    areas = np.ptp(along, axis=1) * np.ptp(across, axis=1)
    good = np.flatnonzero(areas <= _ALIKE * areas.min())
    size = np.round(np.abs(turns[good]) / _ANGLE_RAD)
    # As near to the axis on one side as on the other: the anticlockwise one.
    best = good[np.lexsort((-turns[good], size))[0]]
    spans = np.round([np.ptp(along[best]), np.ptp(across[best])], 4)
    middle = np.array(
        [np.mean([along[best].min(), along[best].max()]), np.mean([across[best].min(), across[best].max()])]
    )
    c, s = float(cos[best]), float(sin[best])
    x, y = frame.from_frame(np.array([[c * middle[0] - s * middle[1], s * middle[0] + c * middle[1]]]))[0]
    turn = math.atan2(frame.axis[1], frame.axis[0]) + float(turns[best])
    if spans.min() < 10 * _LENGTH_MM:
        return None
    return lengthwise(Rectangle(float(x), float(y), turn, float(spans[0]), float(spans[1])), frame)


def lengthwise(rectangle: Rectangle, frame: GridFrame) -> Rectangle:
    """Lay the length along the longer side, within a quarter turn of the board's axis."""
    turn, length, width = rectangle.turn_rad, rectangle.length_mm, rectangle.width_mm
    if width > length:
        turn, length, width = turn + math.pi / 2.0, width, length
    axis = math.atan2(frame.axis[1], frame.axis[0])
    half_turns = math.floor((turn - axis - _ANGLE_RAD) / math.pi + 0.5)
    turn = math.remainder(turn - math.pi * half_turns, 2.0 * math.pi)
    return replace(rectangle, turn_rad=turn, length_mm=length, width_mm=width)


def lying_along(square: Rectangle, other: Rectangle) -> Rectangle:
    """Lay the length of a square along that of another rectangle; what is not square stays as it is."""
    if square.length_mm - square.width_mm > _SQUARE * square.length_mm:
        return square
    return replace(square, turn_rad=other.turn_rad)


def shrink_to(rectangle: Rectangle, sizes_mm: tuple[float, float]) -> Rectangle:
    """Make a rectangle about its middle no longer and no wider than sizes that are known; it never grows."""
    length, width = min(max(sizes_mm), rectangle.length_mm), min(min(sizes_mm), rectangle.width_mm)
    return replace(rectangle, length_mm=length, width_mm=width)


def shrink_between_leads(rectangle: Rectangle, sizes_mm: tuple[float, float], frame: GridFrame) -> Rectangle:
    """Make a rectangle that may hold leads as small as the body is known to be, about its middle; it never grows.

    Leads stand beside two sides or beside all four: of the two ways to turn the sizes the one that leaves the least
    beside one pair of edges is taken, then the one that keeps more.
    """
    here = (rectangle.length_mm, rectangle.width_mm)

    def loss(way: tuple[float, float]) -> tuple[float, float]:
        left = [max(side - size, 0.0) for side, size in zip(here, way, strict=True)]
        least = round(min(left), 3)
        return least if least > _SLACK_MM else 0.0, -round((here[0] - left[0]) * (here[1] - left[1]), 3)

    long, short = max(sizes_mm), min(sizes_mm)
    best = min(((long, short), (short, long)), key=loss)
    length, width = min(best[0], here[0]), min(best[1], here[1])
    return lengthwise(replace(rectangle, length_mm=length, width_mm=width), frame)
