"""The nearest triangle to each of many line segments, and the nearest points. Any unit of length.

Triangles lie in a balanced tree of boxes: each half of those of a node, along the longest side of its box, belongs to
one of its two children, so that where they stand needs not be stored. After Ericson, "Real-Time Collision Detection"
(2005), sections 5.1.9 (two segments), 5.2.8 and 5.3.6 (segment and triangle).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Points, Scalars, Triangles
from geometry.compiled import compiled, inner

_MOST_IN_LEAF = 4
_DEEPEST = 40
_FLAT = 1e-24
"""Squared size below which an edge or a triangle's normal has no direction."""


class TriangleTree(NamedTuple):
    """Triangles (n, 3, 3) in the order of their tree, with the boxes of its nodes: children of i are 2i + 1, 2i + 2."""

    triangles: Triangles
    order: Indices
    """(n,) which triangle each was before."""
    boxes: NDArray[np.float64]
    """(nodes, 2, 3) lowest and highest corner"""
    levels: int


class NearestTriangles(NamedTuple):
    """Of m segments."""

    distances: Scalars
    """(m,) infinite where no triangle is as near as was allowed."""
    triangle: Indices
    """(m,) -1 where none is."""
    points: NDArray[np.float64]
    """(m, 2, 3) the nearest point of the segment, and of the triangle."""


def build_tree(triangles: Triangles) -> TriangleTree:
    """Sort triangles (n, 3, 3) into a tree; n > 0."""
    levels = max(0, math.ceil(math.log2(max(len(triangles) / _MOST_IN_LEAF, 1.0))))
    order, ends, boxes = np.arange(len(triangles)), np.array([0, len(triangles)]), list[NDArray[np.float64]]()
    for level in range(levels + 1):
        sorted_ = triangles[order]
        low = np.minimum.reduceat(sorted_.min(axis=1), ends[:-1])
        high = np.maximum.reduceat(sorted_.max(axis=1), ends[:-1])
        boxes.append(np.stack((low, high), axis=1))
        if level < levels:
            node = np.repeat(np.arange(len(low)), np.diff(ends))
            longest = np.argmax(high - low, axis=1)[node]
            corners = sorted_[np.arange(len(order)), :, longest]
            order = order[np.lexsort((corners[:, 0] + corners[:, 1] + corners[:, 2], node))]
            ends = np.sort(np.concatenate((ends, (ends[:-1] + ends[1:]) // 2)))
    return TriangleTree(np.ascontiguousarray(triangles[order]), order, np.concatenate(boxes), levels)


def nearest_triangles(tree: TriangleTree, begin: Points, end: Points, most: float) -> NearestTriangles:
    """Find the nearest triangle to segments from (m, 3) to (m, 3), as far as it is no farther than ``most``."""
    distances, place = np.full(len(begin), np.inf), np.full(len(begin), -1, dtype=np.int64)
    points = np.zeros((len(begin), 2, 3))
    _search(tree.triangles, tree.boxes, tree.levels, (begin, end), most, (distances, place, points))
    return NearestTriangles(distances, np.where(place < 0, -1, tree.order[place]), points)


@compiled
def _search(
    triangles: Triangles,
    boxes: NDArray[np.float64],
    levels: int,
    ends: tuple[Points, Points],
    most: float,
    found: tuple[Scalars, Indices, NDArray[np.float64]],
) -> None:
    """Go through the tree once for each segment, the nearer child first."""
    distances, place, points = found
    stack = np.empty((2 * _DEEPEST, 3), dtype=np.int64)  # node, first triangle, the one after the last
    bounds, near = np.empty(2 * _DEEPEST), np.empty((2, 3))
    inner = 2**levels - 1
    for row in range(len(distances)):
        p, q = ends[0][row], ends[1][row]
        best = most
        stack[0, 0], stack[0, 1], stack[0, 2] = 0, 0, len(triangles)
        bounds[0] = _box_bound(boxes[0], p, q)
        count = 1
        while count > 0:
            count -= 1
            node, first, last = stack[count, 0], stack[count, 1], stack[count, 2]
            if bounds[count] > best:
                continue
            if node >= inner:
                for index in range(first, last):
                    apart = _apart(triangles[index], p, q, near)
                    if apart < best or (apart == best and place[row] < 0):
                        best = apart
                        distances[row], place[row] = apart, index
                        points[row] = near
                continue
            half = (first + last) // 2
            left, right = _box_bound(boxes[2 * node + 1], p, q), _box_bound(boxes[2 * node + 2], p, q)
            for side in range(2):  # the farther one first: the nearer is taken next
                lower = (side == 0) == (left > right)
                stack[count, 0] = 2 * node + (1 if lower else 2)
                stack[count, 1], stack[count, 2] = (first, half) if lower else (half, last)
                bounds[count] = left if lower else right
                count += 1


@inner
def _box_bound(box: NDArray[np.float64], p: Scalars, q: Scalars) -> float:
    """Give a lower bound of the distance of a segment and a box: of their boxes, and of the box's ball."""
    outside, along, length, size, off = 0.0, 0.0, 0.0, 0.0, 0.0
    for axis in range(3):
        low, high = min(p[axis], q[axis]), max(p[axis], q[axis])
        gap = max(max(low - box[1, axis], box[0, axis] - high), 0.0)
        outside += gap * gap
        middle, way = 0.5 * (box[0, axis] + box[1, axis]) - p[axis], q[axis] - p[axis]
        along += middle * way
        length += way * way
        size += 0.25 * (box[1, axis] - box[0, axis]) ** 2
    share = min(max(along / length, 0.0), 1.0) if length > _FLAT else 0.0
    for axis in range(3):
        off += (0.5 * (box[0, axis] + box[1, axis]) - p[axis] - share * (q[axis] - p[axis])) ** 2
    return max(math.sqrt(outside), math.sqrt(off) - math.sqrt(size))


@compiled
def _dot(a: Scalars, b: Scalars) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def _apart(triangle: Points, p: Scalars, q: Scalars, near: Points) -> float:
    """Give the distance of a segment and a triangle; write the nearest points of both."""
    best = np.inf
    for corner in range(3):
        best = min(best, _edge_apart(p, q, triangle[corner], triangle[(corner + 1) % 3], near, best))
    a, b, c = triangle[0], triangle[1], triangle[2]
    one, two = b - a, c - a
    normal = np.array(
        [one[1] * two[2] - one[2] * two[1], one[2] * two[0] - one[0] * two[2], one[0] * two[1] - one[1] * two[0]]
    )
    size = math.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    if size * size < _FLAT * _FLAT:
        return best
    normal /= size
    above = _dot(normal, p - a), _dot(normal, q - a)
    if above[0] * above[1] < 0.0:
        through = p + above[0] / (above[0] - above[1]) * (q - p)
        if _is_over(triangle, normal, through):
            near[0] = through
            near[1] = through
            return 0.0
    for side in range(2):
        point, height = (p, above[0]) if side == 0 else (q, above[1])
        if abs(height) < best and _is_over(triangle, normal, point):
            best = abs(height)
            near[0] = point
            near[1] = point - height * normal
    return best


@compiled
def _is_over(triangle: Points, normal: Scalars, point: Scalars) -> bool:
    """Whether a point lies within a triangle as seen along its normal."""
    for corner in range(3):
        a, b = triangle[corner], triangle[(corner + 1) % 3]
        e, d = b - a, point - a
        side = (
            normal[0] * (e[1] * d[2] - e[2] * d[1])
            + normal[1] * (e[2] * d[0] - e[0] * d[2])
            + normal[2] * (e[0] * d[1] - e[1] * d[0])
        )
        if side < 0.0:
            return False
    return True


@compiled
def _edge_apart(p: Scalars, q: Scalars, a: Scalars, b: Scalars, near: Points, best: float) -> float:
    """Give the distance of two segments; write their nearest points if it is less than ``best``."""
    along, edge, between = q - p, b - a, p - a
    pp, ee, ep = _dot(along, along), _dot(edge, edge), _dot(along, edge)
    pb, eb = _dot(along, between), _dot(edge, between)
    s = t = 0.0
    if pp <= _FLAT:
        t = min(max(eb / ee, 0.0), 1.0) if ee > _FLAT else 0.0
    elif ee <= _FLAT:
        s = min(max(-pb / pp, 0.0), 1.0)
    else:
        parallel = pp * ee - ep * ep
        s = min(max((ep * eb - pb * ee) / parallel, 0.0), 1.0) if parallel > 1e-12 * pp * ee else 0.0
        t = (ep * s + eb) / ee
        if t < 0.0 or t > 1.0:
            t = min(max(t, 0.0), 1.0)
            s = min(max((t * ep - pb) / pp, 0.0), 1.0)
    total = 0.0
    for axis in range(3):
        total += (between[axis] + s * along[axis] - t * edge[axis]) ** 2
    apart = math.sqrt(total)
    if apart < best:
        for axis in range(3):
            near[0, axis] = p[axis] + s * along[axis]
            near[1, axis] = a[axis] + t * edge[axis]
    return apart


_SAME_DIGITS = 9
"""Faces whose planes agree to so many digits are one: a hull is made of triangles."""


class Hull(NamedTuple):
    """A convex hull."""

    faces: NDArray[np.float64]
    """(f, 4) outward unit normal n, and d: n · x + d <= 0 inside."""
    corners: Points
    """(v, 3)"""


def build_hull(corners: Points, equations: NDArray[np.float64]) -> Hull:
    """Give a hull of its corners (v, 3) and the planes of its facets (k, 4), of which many may lie in one plane."""
    return Hull(np.unique(np.round(equations, _SAME_DIGITS), axis=0), np.ascontiguousarray(corners))


def is_apart(tree: TriangleTree, hull: Hull, turn: NDArray[np.float64], offset: Scalars, margin: float) -> bool:
    """Whether it is proven that a hull is farther than a margin from every triangle of a tree.

    Args:
        tree: Of the triangles.
        hull: In a frame of its own.
        turn: (3, 3) from the hull's axes to those of the triangles.
        offset: (3,) origin of the hull's frame in that of the triangles.
        margin: Length, 0 or more.
    """
    return _is_apart(tree.triangles, tree.boxes, tree.levels, (hull.faces, hull.corners), (turn, offset), margin)


@compiled
def _is_apart(
    triangles: NDArray[np.float64],
    boxes: NDArray[np.float64],
    levels: int,
    hull: tuple[NDArray[np.float64], Points],
    pose: tuple[NDArray[np.float64], Scalars],
    margin: float,
) -> bool:
    """Go down the tree wherever no plane separates a node's box from the hull, to triangles that none separates."""
    faces, corners, low, high = _moved(hull, pose)
    stack = np.empty((2 * _DEEPEST, 3), dtype=np.int64)  # node, first triangle, the one after the last
    stack[0, 0], stack[0, 1], stack[0, 2] = 0, 0, len(triangles)
    count, inner = 1, 2**levels - 1
    while count > 0:
        count -= 1
        node, first, last = stack[count, 0], stack[count, 1], stack[count, 2]
        if _is_box_apart(boxes[node], faces, low, high, margin):
            continue
        if node >= inner:
            for index in range(first, last):
                if not _is_triangle_apart(triangles[index], faces, corners, margin):
                    return False
            continue
        half = (first + last) // 2
        stack[count, 0], stack[count, 1], stack[count, 2] = 2 * node + 1, first, half
        stack[count + 1, 0], stack[count + 1, 1], stack[count + 1, 2] = 2 * node + 2, half, last
        count += 2
    return True


@compiled
def _moved(
    hull: tuple[NDArray[np.float64], Points], pose: tuple[NDArray[np.float64], Scalars]
) -> tuple[NDArray[np.float64], Points, Scalars, Scalars]:
    """Give faces and corners of a hull in the frame of the triangles, and the corners' box there."""
    turn, offset = pose
    faces, corners = np.empty(hull[0].shape), np.empty(hull[1].shape)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for index in range(len(faces)):
        normal, height = hull[0][index], hull[0][index, 3]
        for axis in range(3):
            faces[index, axis] = turn[axis, 0] * normal[0] + turn[axis, 1] * normal[1] + turn[axis, 2] * normal[2]
            height -= faces[index, axis] * offset[axis]
        faces[index, 3] = height
    for index in range(len(corners)):
        own = hull[1][index]
        for axis in range(3):
            value = offset[axis] + turn[axis, 0] * own[0] + turn[axis, 1] * own[1] + turn[axis, 2] * own[2]
            corners[index, axis] = value
            low[axis], high[axis] = min(low[axis], value), max(high[axis], value)
    return faces, corners, low, high


@inner
def _is_box_apart(
    box: NDArray[np.float64], faces: NDArray[np.float64], low: Scalars, high: Scalars, margin: float
) -> bool:
    """Whether an axis of the box or a face of the hull, whose box is from low to high, separates them."""
    for axis in range(3):
        if box[0, axis] - high[axis] > margin or low[axis] - box[1, axis] > margin:
            return True
    for index in range(len(faces)):
        least = faces[index, 3]
        for axis in range(3):
            least += faces[index, axis] * (box[0, axis] if faces[index, axis] > 0.0 else box[1, axis])
        if least > margin:
            return True
    return False


@compiled
def _is_triangle_apart(
    triangle: NDArray[np.float64], faces: NDArray[np.float64], corners: Points, margin: float
) -> bool:
    """Whether a face of the hull or the triangle's own plane separates them."""
    for index in range(len(faces)):
        least = np.inf
        for corner in range(3):
            height = faces[index, 3]
            for axis in range(3):
                height += faces[index, axis] * triangle[corner, axis]
            least = min(least, height)
        if least > margin:
            return True
    one, two = triangle[1] - triangle[0], triangle[2] - triangle[0]
    x, y, z = one[1] * two[2] - one[2] * two[1], one[2] * two[0] - one[0] * two[2], one[0] * two[1] - one[1] * two[0]
    size = math.sqrt(x * x + y * y + z * z)
    if size == 0.0:
        return False
    lowest, highest = np.inf, -np.inf
    for index in range(len(corners)):
        apart = corners[index] - triangle[0]
        height = x * apart[0] + y * apart[1] + z * apart[2]
        lowest, highest = min(lowest, height), max(highest, height)
    return lowest > margin * size or -highest > margin * size
