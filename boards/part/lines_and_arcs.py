"""A closed outline of many points as few lines and arcs, fitted by least squares: corners are where these meet.

The division is the one of least squares with a price for each piece, by dynamic programming over all pairs of points
(Bellman 1961; for curves Perez and Vidal 1994). Sums of the points' powers give the fit between any two in one step:
lines by their covariance, circles by Kasa's (1976) linear equations.
"""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from geometry.arrays import Indices, Points, Scalars

_STEP_PX, _MOST = 0.5, 1200
"""Pixels between the points that are fitted, and how many of them at most."""
_SIGMA_PX = 0.15
"""How far a point lies from its piece by camera and light."""
_LINE, _ARC = 25.0, 45.0
"""Prices of a piece, in squares of ``_SIGMA_PX`` a point."""
_AWAY_PX = 1.25
"""From a corner, where a picture is rounded: points so near do not count."""
_LEAST_PX, _LEAST_POINTS = 3.0, 3
_LEAST_BOW_PX, _LEAST_TURN = 0.5, np.radians(8.0)
"""Of an arc: a flatter one is a line."""
_CHORD_PX = 0.03
_JOINED_PX = 2.0
"""A corner of two pieces lies so near to the point that divides them, over the sine of half the corner's angle: of tips
a picture cuts the more the more acute they are. Otherwise the pieces are joined at the point."""
_LONGEST_LINE = 1e12

_Sums: TypeAlias = NDArray[np.float64]
"""(n + 1, 9) running sums of x, y, xx, xy, yy, zx, zy, z, zz with z = xx + yy, about the ring's middle."""


@dataclass(frozen=True, slots=True, eq=False)
class _Piece:
    """A line (radius 0: a point of it and its direction), or an arc (its centre, radius)."""

    first: int
    last: int
    """Points of the ring that it goes from and to; the last may be beyond the end of the ring."""
    at: Points
    """(2,) a point of a line, or the centre."""
    way: Points
    """(2,) direction of a line."""
    radius: float

    def nearest(self, point: Points) -> Points:
        """Give the point of the line or circle that is nearest to a point."""
        if self.radius == 0.0:
            return self.at + ((point - self.at) @ self.way) * self.way
        away = point - self.at
        return self.at + self.radius * away / max(float(np.hypot(*away)), 1e-12)

    def direction(self, point: Points, towards: Points) -> Points:
        """Give the direction of the piece at a point, (2,), the one of two that goes rather towards another."""
        away = point - self.at
        way = self.way if self.radius == 0.0 else np.array([-away[1], away[0]]) / max(float(np.hypot(*away)), 1e-12)
        return way if way @ (towards - point) >= 0.0 else -way


def fit_outline(outline: Polygon, within: float) -> Polygon:
    """Replace an outline and its holes by lines and arcs; those whose fit is farther off than allowed stay.

    Args:
        outline: Pixels.
        within: How far a corner of the outline may be from the fit.
    """
    rings: list[Points] = []
    for ring in (outline.exterior, *outline.interiors):
        corners = np.asarray(ring.coords, dtype=np.float64)[:-1]
        fitted = fit_ring(corners)
        off = (
            shapely.distance(shapely.points(corners), shapely.linearrings(fitted)).max() if len(fitted) > 2 else np.inf
        )
        rings.append(fitted if off <= within else corners)
    whole = Polygon(rings[0], rings[1:])
    return whole if whole.is_valid else outline


def fit_ring(corners: Points) -> Points:
    """Replace a closed outline by lines and arcs; arcs become chords that are 0.03 pixels off at most.

    Args:
        corners: (n, 2) pixels, the first not repeated.

    Returns:
        (m, 2) corners, in the same sense; those given where there are too few points for a fit.
    """
    ring = _even(corners)
    if len(ring) < 4 * _LEAST_POINTS:
        return corners
    whole = _circle(ring)
    if whole is not None:
        return whole
    start = _sharpest(ring)
    pieces = _divide(np.roll(ring, -start, axis=0))
    if len(pieces) > 1:  # once more from a corner that was found: the sharpest point is beside one, or is none
        again = (start + pieces[len(pieces) // 2].first) % len(ring)
        ring = np.roll(ring, -again, axis=0)
        pieces = _divide(ring)
    if len(pieces) < 2:
        return corners
    return _drawn(ring, pieces)


def _even(corners: Points) -> Points:
    """(n, 2) points along the ring, evenly."""
    closed = np.vstack([corners, corners[:1]])
    way = np.append(0.0, np.cumsum(np.hypot(*np.diff(closed, axis=0).T)))
    count = min(int(way[-1] / _STEP_PX), _MOST)
    at = np.linspace(0.0, way[-1], max(count, 1), endpoint=False)
    return np.column_stack([np.interp(at, way, closed[:, axis]) for axis in (0, 1)])


def _spacing(ring: Points) -> float:
    return float(np.hypot(*(np.roll(ring, -1, axis=0) - ring).T).mean())


def _circle(ring: Points) -> Points | None:
    """Give the ring as one circle, if it is one."""
    sums = _sums(ring)
    squares, at, radius = _arcs(sums, np.zeros(1, dtype=np.int64), len(ring))
    if not np.isfinite(squares[0]) or squares[0] > len(ring) * _SIGMA_PX**2:
        return None
    centre = ring.mean(axis=0) + at[0]
    turn = np.arctan2(*(ring[0] - centre)[::-1])
    sense = 1.0 if _area(ring) > 0.0 else -1.0
    count = _chords(2.0 * np.pi, float(radius[0]))
    angles = turn + sense * 2.0 * np.pi * np.arange(count) / count
    return centre + radius[0] * np.column_stack([np.cos(angles), np.sin(angles)])


def _area(ring: Points) -> float:
    x, y = ring.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def _sharpest(ring: Points) -> int:
    """Give the point at which the ring bends most within a few pixels."""
    reach = max(round(4.0 / _spacing(ring)), 1)
    before, after = ring - np.roll(ring, reach, axis=0), np.roll(ring, -reach, axis=0) - ring
    cosine = np.einsum("ni,ni->n", before, after)
    cosine /= np.maximum(np.hypot(*before.T) * np.hypot(*after.T), 1e-12)
    return int(np.argmin(np.round(cosine, 9)))


def _sums(ring: Points) -> _Sums:
    x, y = (ring - ring.mean(axis=0)).T
    z = x * x + y * y
    rows = np.column_stack([x, y, x * x, x * y, y * y, z * x, z * y, z, z * z])
    return np.vstack([np.zeros(9), np.cumsum(rows, axis=0)])


def _divide(ring: Points) -> list[_Piece]:
    """Divide a ring, that begins at a corner, into the pieces of least price."""
    count, spacing = len(ring), _spacing(ring)
    away = max(round(_AWAY_PX / spacing), 1)
    least = max(int(np.ceil(_LEAST_PX / spacing)), _LEAST_POINTS) + 2 * away
    # Points that stand for several pixels weigh as many as those would.
    weight = spacing / _STEP_PX
    sums = _sums(ring)
    price, before = np.full(count + 1, np.inf), np.zeros(count + 1, dtype=np.int64)
    is_arc = np.zeros(count + 1, dtype=np.bool_)
    price[0] = 0.0
    for end in range(least, count + 1):
        begins = np.arange(0, end - least + 1)
        begins = begins[np.isfinite(price[begins])]
        if not len(begins):
            continue
        straight = price[begins] + _LINE + weight * _lines(sums, begins + away, end - away) / _SIGMA_PX**2
        round_ = price[begins] + _ARC + weight * _arcs(sums, begins + away, end - away)[0] / _SIGMA_PX**2
        cost = np.minimum(straight, round_)
        best = int(np.argmin(cost))
        price[end], before[end], is_arc[end] = cost[best], begins[best], bool(round_[best] < straight[best])
    if not np.isfinite(price[count]):
        return []
    pieces, end = list[_Piece](), count
    while end > 0:
        first = int(before[end])
        pieces.append(_piece(ring, sums, (first, end), away, is_arc=bool(is_arc[end])))
        end = first
    return pieces[::-1]


def _moments(sums: _Sums, begins: Indices, end: int) -> tuple[Scalars, NDArray[np.float64]]:
    """Give how many points there are from each begin to the end, (m,), and the means of their powers, (9, m)."""
    n = (end - begins).astype(np.float64)
    return n, ((sums[end] - sums[begins]) / n[:, None]).T


def _lines(sums: _Sums, begins: Indices, end: int) -> Scalars:
    """(m,) sum of squares of the distances from the best lines."""
    n, (x, y, xx, xy, yy, *_) = _moments(sums, begins, end)
    a, b, c = xx - x * x, xy - x * y, yy - y * y
    least = 0.5 * (a + c - np.sqrt((a - c) ** 2 + 4.0 * b * b))
    return n * np.maximum(least, 0.0)


def _arcs(sums: _Sums, begins: Indices, end: int) -> tuple[Scalars, Points, Scalars]:
    """(m,) sum of squares of the distances from the best circles, (m, 2) their centres, (m,) radii.

    Infinite where points lie on a line, or the arc is flat.
    """
    n, (x, y, xx, xy, yy, zx, zy, z, zz) = _moments(sums, begins, end)
    a, b, c = xx - x * x, xy - x * y, yy - y * y  # of the points about their middle
    p, q, r = zx - z * x, zy - z * y, zz - z * z
    det = a * c - b * b
    safe = np.where(det > 1e-12, det, 1.0)
    u, v = (c * p - b * q) / safe, (a * q - b * p) / safe  # twice the centre
    squares = np.maximum(r - u * p - v * q, 0.0)
    cx, cy = 0.5 * u, 0.5 * v
    radius2 = z - u * x - v * y + cx * cx + cy * cy
    ok = (det > 1e-12) & (radius2 > 0.0) & (radius2 < _LONGEST_LINE)
    radius = np.sqrt(np.where(ok, radius2, 1.0))
    spread = np.sqrt(12.0 * np.maximum(0.5 * (a + c + np.sqrt((a - c) ** 2 + 4.0 * b * b)), 0.0))  # about the chord
    flat = (spread**2 / (8.0 * radius) < _LEAST_BOW_PX) | (spread / radius < _LEAST_TURN)
    found = np.where(ok & ~flat, n * squares / (4.0 * np.maximum(radius2, 1e-12)), np.inf)
    return found, np.column_stack([cx, cy]), radius


def _piece(ring: Points, sums: _Sums, ends: tuple[int, int], away: int, *, is_arc: bool) -> _Piece:
    """Fit a piece to the points between its ends, but for those beside them."""
    first, last = ends
    middle, points = ring.mean(axis=0), ring[first + away : last - away]
    if is_arc:
        _, at, radius = _arcs(sums, np.array([first + away]), last - away)
        return _Piece(first, last, middle + at[0], np.zeros(2), float(radius[0]))
    at = points.mean(axis=0)
    way = np.linalg.svd(points - at, full_matrices=False)[2][0]
    way = way if way @ (points[-1] - points[0]) >= 0.0 else -way
    return _Piece(first, last, at, way, 0.0)


def _drawn(ring: Points, pieces: list[_Piece]) -> Points:
    """Give the corners of the pieces, with those of the chords of arcs."""
    count = len(ring)
    joints = [_joint(ring, pieces[number - 1], each) for number, each in enumerate(pieces)]
    drawn: list[Points] = []
    for number, (each, begin) in enumerate(zip(pieces, joints, strict=True)):
        drawn.append(begin[None])
        if each.radius > 0.0:
            end, middle = joints[(number + 1) % len(joints)], ring[(each.first + each.last) // 2 % count]
            drawn.append(_chorded(each, begin, end, middle))
    return np.vstack(drawn)


def _joint(ring: Points, one: _Piece, other: _Piece) -> Points:
    """Give where two pieces meet: their crossing that is nearest to a point, or the middle between them there."""
    near = ring[other.first % len(ring)]
    between = 0.5 * (one.nearest(near) + other.nearest(near))
    before, after = (each.direction(near, ring[(each.first + each.last) // 2 % len(ring)]) for each in (one, other))
    reach = _JOINED_PX / np.sqrt(max(0.5 * (1.0 - float(before @ after)), 1e-6))
    crossings = [each for each in _crossings(one, other) if np.hypot(*(each - near)) <= reach]
    return min(crossings, key=lambda each: float(np.hypot(*(each - near))), default=between)


def _crossings(one: _Piece, other: _Piece) -> list[Points]:
    """Give the points, at most two, at which two pieces cross if they go on."""
    if one.radius > 0.0 and other.radius == 0.0:
        one, other = other, one
    if other.radius == 0.0:
        cross = float(one.way[0] * other.way[1] - one.way[1] * other.way[0])
        if abs(cross) < 1e-3:
            return []
        away = other.at - one.at
        return [one.at + (away[0] * other.way[1] - away[1] * other.way[0]) / cross * one.way]
    if one.radius == 0.0:
        foot, way = one.nearest(other.at), one.way
        half = other.radius**2 - float(np.sum((foot - other.at) ** 2))
    else:
        apart = float(np.hypot(*(other.at - one.at)))
        if apart < 1e-9:
            return []
        towards = (other.at - one.at) / apart
        along = (apart**2 + one.radius**2 - other.radius**2) / (2.0 * apart)
        foot, way = one.at + along * towards, np.array([-towards[1], towards[0]])
        half = one.radius**2 - along**2
    return [foot + sign * np.sqrt(half) * way for sign in (-1.0, 1.0)] if half >= 0.0 else []


def _chords(turn: float, radius: float) -> int:
    """Give into how many chords an arc is divided: none is farther from it than allowed."""
    each = 2.0 * np.arccos(max(1.0 - _CHORD_PX / max(radius, _CHORD_PX), -1.0))
    return max(int(np.ceil(abs(turn) / each)), 2)


def _chorded(arc: _Piece, begin: Points, end: Points, middle: Points) -> Points:
    """(m, 2) points between the ends of an arc, that goes past a point in the middle."""
    angles = [float(np.arctan2(*(each - arc.at)[::-1])) for each in (begin, middle, end)]
    half, whole = (float(np.mod(each - angles[0], 2.0 * np.pi)) for each in angles[1:])
    turn = whole if half <= whole else whole - 2.0 * np.pi
    count = _chords(turn, arc.radius)
    at = angles[0] + turn * np.arange(1, count) / count
    return arc.at + arc.radius * np.column_stack([np.cos(at), np.sin(at)])
