"""Closed solids from which the sample parts are put together.

A solid is an (n, 3, 3) array of triangular patches in mm, closed, wound so that its normals point outwards.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from geometry.arrays import Points2, Triangles

Ring: TypeAlias = Sequence[tuple[float, float]]


def prism(outline: Ring, low: float, high: float, holes: Sequence[Ring] = ()) -> Triangles:
    """Pull a polygon up from z = ``low`` to z = ``high``; rings may be given in either direction."""
    rings = [_wound(outline, 1.0), *(_wound(hole, -1.0) for hole in holes)]
    caps = _triangles(rings)
    faces = [_lift(caps, high), _lift(caps[:, ::-1], low)]
    for ring in rings:
        here, there = ring, np.roll(ring, -1, axis=0)
        faces.append(np.stack([_lift(here, low), _lift(there, low), _lift(there, high)], axis=1))
        faces.append(np.stack([_lift(here, low), _lift(there, high), _lift(here, high)], axis=1))
    return np.concatenate(faces)


def bar(profile: Ring, width: float, holes: Sequence[Ring] = ()) -> Triangles:
    """Pull a profile of (x, z) points sideways, ``width`` along y and centred on y = 0."""
    u, v, w = np.moveaxis(prism(profile, -width / 2, width / 2, holes), 2, 0)
    return np.stack([u, -w, v], axis=2)


def block(size: tuple[float, float], low: float, high: float, centre: tuple[float, float] = (0.0, 0.0)) -> Triangles:
    """Make a box on its plan size (x, y) and between two heights."""
    return prism(rectangle(size, centre), low, high)


def turned(profile: Ring, sides: int, centre: tuple[float, float] = (0.0, 0.0)) -> Triangles:
    """Turn a profile of (radius, z) points, listed upwards, about the vertical through ``centre``."""
    levels = [_lift(np.asarray(circle(radius, sides, centre)), z) for radius, z in profile]
    fan = np.stack([np.zeros(sides - 2, int), np.arange(1, sides - 1), np.arange(2, sides)], axis=1)
    faces = [levels[-1][fan], levels[0][fan[:, ::-1]]]
    for below, above in pairwise(levels):
        faces.append(np.stack([below, np.roll(below, -1, axis=0), np.roll(above, -1, axis=0)], axis=1))
        faces.append(np.stack([below, np.roll(above, -1, axis=0), above], axis=1))
    return np.concatenate(faces)


def rectangle(size: tuple[float, float], centre: tuple[float, float] = (0.0, 0.0), corner: float = 0.0) -> Ring:
    """List the corners of a rectangle, each cut off by ``corner`` at 45 degrees if that is not zero."""
    x, y = centre
    a, b = size[0] / 2, size[1] / 2
    if corner == 0.0:
        return [(x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)]
    c = corner
    ring = [(-a + c, -b), (a - c, -b), (a, -b + c), (a, b - c), (a - c, b), (-a + c, b), (-a, b - c), (-a, -b + c)]
    return [(x + dx, y + dy) for dx, dy in ring]


def circle(radius: float, sides: int, centre: tuple[float, float] = (0.0, 0.0)) -> Ring:
    """List the corners of a regular polygon whose corners lie on the circle."""
    angles = [2 * math.pi * k / sides for k in range(sides)]
    return [(centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle)) for angle in angles]


def slot(length: float, width: float, centre: tuple[float, float], sides: int = 12) -> Ring:
    """List the corners of a slot along x with round ends."""
    half = length / 2 - width / 2
    ends = circle(width / 2, sides)
    quarter = sides // 4
    right = [*ends[-quarter:], *ends[: quarter + 1]]
    left = ends[quarter : sides - quarter + 1]
    ring = [(half + x, y) for x, y in right] + [(x - half, y) for x, y in left]
    return [(centre[0] + x, centre[1] + y) for x, y in ring]


def rounded(ring: Ring, radius: float, steps: int = 5) -> Ring:
    """Round the corners of a polygon that has right angles only, inward ones included."""
    points = np.asarray(ring, dtype=np.float64)
    angles = np.linspace(0.0, math.pi / 2, steps + 1)
    out: list[tuple[float, float]] = []
    for here, before, after in zip(points, np.roll(points, 1, axis=0), np.roll(points, -1, axis=0), strict=True):
        u = (before - here) / np.linalg.norm(before - here)
        v = (after - here) / np.linalg.norm(after - here)
        arc = here + radius * (u + v - np.outer(np.cos(angles), v) - np.outer(np.sin(angles), u))
        out += [(float(x), float(y)) for x, y in arc]
    return out


def shifted(solid: Triangles, x: float, y: float, z: float = 0.0) -> Triangles:
    """Move a solid."""
    return solid + np.array([x, y, z])


def rotated(solid: Triangles, angle_deg: float) -> Triangles:
    """Turn a solid about the z axis, counter-clockwise; multiples of 90 degrees are exact."""
    quarters, rest = divmod(angle_deg, 90.0)
    cos, sin = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][int(quarters) % 4]
    c, s = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    cos, sin = cos * c - sin * s, sin * c + cos * s
    return solid @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])


def flipped(solid: Triangles) -> Triangles:
    """Turn a solid upside down about the y axis, as a part of the bottom side lies when seen from the top."""
    return solid * np.array([-1.0, 1.0, -1.0])


def _triangles(rings: Sequence[Points2]) -> NDArray[np.float64]:
    """Fill a ring and its holes with counter-clockwise triangles, (n, 3, 2), that have no other corners."""
    filling = shapely.constrained_delaunay_triangles(shapely.Polygon(rings[0], rings[1:]))
    triangles = shapely.get_coordinates(filling).reshape(-1, 4, 2)[:, :3]
    a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    clockwise = a[:, 0] * b[:, 1] < a[:, 1] * b[:, 0]
    return np.where(clockwise[:, None, None], triangles[:, ::-1], triangles)


def _lift(points: NDArray[np.float64], z: float) -> NDArray[np.float64]:
    return np.concatenate([points, np.full((*points.shape[:-1], 1), z)], axis=-1)


def _wound(ring: Ring, direction: float) -> Points2:
    points = np.asarray(ring, dtype=np.float64)
    x, y = points.T
    area = np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))
    return points if area * direction > 0 else points[::-1].copy()
