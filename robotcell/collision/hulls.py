"""Proof that a convex hull is farther from all triangles of a tree than a margin. Any unit of length.

A plane with the hull on its one side and a triangle on the other, apart by the margin, proves that (separating axes:
Ericson, "Real-Time Collision Detection" (2005), section 5.2.1). Planes of the hull's faces, of the tree's axes and of
the triangles are tried, no crosses of edges: where none separates, nothing is known.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Points, Scalars
from geometry.compiled import compiled
from robotcell.collision.segments import TriangleTree

_DEEPEST = 40
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


@compiled
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
