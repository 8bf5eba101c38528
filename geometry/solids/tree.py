"""A tree of boxes over triangles, and how near a rod with round ends (a capsule) comes to them."""

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Points, Scalars, Triangles
from geometry.compiled import compiled, inner, quick

Vector: TypeAlias = Any  # three numbers
_LEAF = 4
_DEPTH = 64


class Tree(NamedTuple):
    """Boxes over triangles, each split at the median of its longest side. Millimetres.

    Node k has the children 2 k + 1 and 2 k + 2 where it is no leaf.
    """

    patches: Triangles
    """(n, 3, 3) in the order of the leaves."""
    order: Indices
    """(n,) number of each of them as it was given."""
    low: Points
    """(m, 3) lowest corner of each node's box."""
    high: Points
    """(m, 3)"""
    left: Indices
    """(m,) first child, the other follows; -1 for a leaf."""
    begin: Indices
    """(m,) first triangle of a leaf."""
    end: Indices
    """(m,)"""


def build_tree(patches: Triangles) -> Tree:
    """Build the tree of (n, 3, 3) triangles, mm; n may be 0."""
    order, low, high, left, begin, end = _build(np.ascontiguousarray(patches, dtype=np.float64))
    return Tree(np.ascontiguousarray(patches[order], dtype=np.float64), order, low, high, left, begin, end)


@compiled
def _build(patches: Triangles) -> tuple[Indices, Points, Points, Indices, Indices, Indices]:
    count = len(patches)
    most = max(1, 2 * count)
    low, high = np.zeros((most, 3)), np.zeros((most, 3))
    left = np.full(most, -1, dtype=np.int64)
    begin, end = np.zeros(most, dtype=np.int64), np.zeros(most, dtype=np.int64)
    order = np.arange(count)
    centres = np.zeros((count, 3))
    for i in range(count):
        for axis in range(3):
            centres[i, axis] = (patches[i, 0, axis] + patches[i, 1, axis] + patches[i, 2, axis]) / 3
    end[0] = count
    nodes = 1
    todo = 0
    while todo < nodes:
        node = todo
        todo += 1
        first, last = begin[node], end[node]
        for axis in range(3):
            low[node, axis] = np.inf
            high[node, axis] = -np.inf
        for k in range(first, last):
            for corner in range(3):
                for axis in range(3):
                    value = patches[order[k], corner, axis]
                    low[node, axis] = min(low[node, axis], value)
                    high[node, axis] = max(high[node, axis], value)
        if last - first <= _LEAF:
            continue
        axis = int(np.argmax(high[node] - low[node]))
        keys = centres[order[first:last], axis]
        order[first:last] = order[first:last][np.argsort(keys)]
        middle = (first + last) // 2
        left[node] = nodes
        begin[nodes], end[nodes] = first, middle
        begin[nodes + 1], end[nodes + 1] = middle, last
        nodes += 2
    return order, low[:nodes].copy(), high[:nodes].copy(), left[:nodes].copy(), begin[:nodes].copy(), end[:nodes].copy()


@compiled
def patches_near_box(tree: Tree, low: Scalars, high: Scalars, found: Indices) -> int:
    """Collect the triangles whose leaf's box meets a box; ``found`` has room for all. Gives their count."""
    count = 0
    if len(tree.patches) == 0:
        return 0
    stack = np.empty(_DEPTH * 2, dtype=np.int64)
    stack[0] = 0
    depth = 1
    while depth:
        depth -= 1
        node = stack[depth]
        apart = False
        for axis in range(3):
            apart = apart or tree.low[node, axis] > high[axis] or tree.high[node, axis] < low[axis]
        if apart:
            continue
        if tree.left[node] < 0:
            for k in range(tree.begin[node], tree.end[node]):
                found[count] = tree.order[k]
                count += 1
        else:
            stack[depth] = tree.left[node]
            stack[depth + 1] = tree.left[node] + 1
            depth += 2
    return count


@quick
def _at(values: Any, row: Any) -> Vector:
    """Take a row of (n, 3) as three numbers: they need no memory."""
    return values[row, 0], values[row, 1], values[row, 2]


@inner
def _sub(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@quick
def _dot(a: Vector, b: Vector) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@quick
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@quick
def _along(a: Vector, d: Vector, share: Any) -> Vector:
    return a[0] + d[0] * share, a[1] + d[1] * share, a[2] + d[2] * share


@quick
def _limit(value: Any) -> Any:
    return min(max(value, 0.0), 1.0)


@inner
def _point_to_inside(p: Vector, a: Vector, e1: Vector, e2: Vector) -> Any:
    """Square of the distance of a point from a triangle's plane where its foot lies inside it, else infinity."""
    normal, w = _cross(e1, e2), _sub(p, a)
    square = _dot(normal, normal)
    if square <= 0.0:
        return math.inf
    v, u = _dot(_cross(e1, w), normal), _dot(_cross(w, e2), normal)
    if v < 0.0 or u < 0.0 or u + v > square:
        return math.inf
    height = _dot(w, normal)
    return height * height / square


@quick
def _segments(p: Vector, q: Vector, a: Vector, b: Vector) -> Any:
    """Square of the distance of two segments (Ericson, Real-Time Collision Detection, 5.1.9)."""
    d1, d2, r = _sub(q, p), _sub(b, a), _sub(p, a)
    s1, s2, f = _dot(d1, d1), _dot(d2, d2), _dot(d2, r)
    s, t = 0.0, 0.0
    if s1 <= 1e-18:
        t = _limit(f / s2) if s2 > 1e-18 else 0.0
    else:
        c = _dot(d1, r)
        if s2 <= 1e-18:
            s = _limit(-c / s1)
        else:
            e = _dot(d1, d2)
            denominator = s1 * s2 - e * e
            s = _limit((e * f - c * s2) / denominator) if denominator > 1e-12 * s1 * s2 else 0.0
            t = (e * s + f) / s2
            if t < 0.0:
                t, s = 0.0, _limit(-c / s1)
            elif t > 1.0:
                t, s = 1.0, _limit((e - c) / s1)
    away = _sub(_along(p, d1, s), _along(a, d2, t))
    return _dot(away, away)


@inner
def passes_through(p: Vector, q: Vector, a: Vector, e1: Vector, e2: Vector, tiny: Any) -> Any:
    """Whether a segment goes through a triangle with corner a and edges e1, e2; ``tiny`` leaves out its rim."""
    normal = _cross(e1, e2)
    above, below = _dot(normal, _sub(p, a)), _dot(normal, _sub(q, a))
    if above * below >= 0.0:
        return False
    share = above / (above - below)
    w = _sub(_along(p, _sub(q, p), share), a)
    square = _dot(normal, normal)
    u, v = _dot(_cross(w, e2), normal) / square, _dot(_cross(e1, w), normal) / square
    return tiny < share < 1.0 - tiny and u > tiny and v > tiny and u + v < 1.0 - tiny


@inner
def segment_to_patch(p: Vector, q: Vector, patch: Any) -> Any:
    """Square of the distance of a segment from a triangle (3, 3); 0 where it goes through."""
    a, b, c = _at(patch, 0), _at(patch, 1), _at(patch, 2)
    e1, e2 = _sub(b, a), _sub(c, a)
    if passes_through(p, q, a, e1, e2, -1e-12):
        return 0.0
    best = min(_point_to_inside(p, a, e1, e2), _point_to_inside(q, a, e1, e2))
    return min(best, min(_segments(p, q, a, b), min(_segments(p, q, b, c), _segments(p, q, c, a))))


@inner
def _misses(p: Vector, d: Vector, low: Vector, high: Vector, radius: Any) -> Any:
    """Whether a segment from p along d stays farther from a box than a radius, judged by slabs."""
    enter, leave = 0.0, 1.0
    for axis in range(3):
        a, b = low[axis] - radius - p[axis], high[axis] + radius - p[axis]
        if abs(d[axis]) < 1e-12:
            if a > 0.0 or b < 0.0:
                return True
        else:
            one, two = a / d[axis], b / d[axis]
            enter, leave = max(enter, min(one, two)), min(leave, max(one, two))
            if enter > leave:
                return True
    return False


@inner
def _hit(tree: Tree, p: Vector, q: Vector, radius: Any, stack: Indices) -> Any:
    d = _sub(q, p)
    stack[0] = 0
    depth = 1
    while depth > 0:
        depth -= 1
        node = stack[depth]
        if _misses(p, d, _at(tree.low, node), _at(tree.high, node), radius):
            continue
        if tree.left[node] < 0:
            for k in range(tree.begin[node], tree.end[node]):
                if segment_to_patch(p, q, tree.patches[k]) < radius * radius:
                    return tree.order[k]
        else:
            stack[depth] = tree.left[node]
            stack[depth + 1] = tree.left[node] + 1
            depth += 2
    return -1


@compiled
def capsule_hits(tree: Tree, begin: Points, end: Points, radius: float) -> Indices:
    """Which triangle each capsule comes nearer to than its radius: (n,) its number as given, or -1.

    Args:
        tree: ``build_tree`` of the triangles.
        begin: (n, 3) one end of each capsule's axis, mm.
        end: (n, 3) the other; where it is the same, the capsule is a ball.
        radius: Of all, mm; exactly touching is no hit.
    """
    hits = np.full(len(begin), -1, dtype=np.int64)
    stack = np.empty(2 * _DEPTH, dtype=np.int64)
    if len(tree.patches) > 0:
        for row in range(len(begin)):
            hits[row] = _hit(tree, _at(begin, row), _at(end, row), radius, stack)
    return hits


@compiled
def crossing_patches(tree: Tree, patches: Triangles, corners: Indices) -> NDArray[np.bool_]:
    """(n,) whether a patch and another one, which shares no corner with it, go through each other.

    Args:
        tree: ``build_tree`` of the patches.
        patches: (n, 3, 3) mm.
        corners: (n, 3) numbers of their corners.
    """
    crossed = np.zeros(len(patches), dtype=np.bool_)
    near = np.empty(len(patches), dtype=np.int64)
    low, high = np.empty(3), np.empty(3)
    for i in range(len(patches)):
        for axis in range(3):
            a, b, c = patches[i, 0, axis], patches[i, 1, axis], patches[i, 2, axis]
            low[axis] = min(a, min(b, c))
            high[axis] = max(a, max(b, c))
        for k in range(patches_near_box(tree, low, high, near)):
            j = near[k]
            shared = False
            for m in range(9):
                shared = shared or corners[i, m // 3] == corners[j, m % 3]
            if not shared:
                a, b, c = _at(patches[j], 0), _at(patches[j], 1), _at(patches[j], 2)
                for m in range(3):
                    if passes_through(
                        _at(patches[i], m), _at(patches[i], (m + 1) % 3), a, _sub(b, a), _sub(c, a), 1e-6
                    ):
                        crossed[i] = True
                        crossed[j] = True
    return crossed


def winding_numbers(patches: Triangles, points: Points) -> NDArray[np.float64]:
    """How often closed triangles go around each of (k, 3) points: 1 inside a solid, 0 outside.

    Solid angles by Van Oosterom and Strackee (1983), equation 8.
    """
    numbers = np.zeros(len(points))
    for row, point in enumerate(points):
        a, b, c = (patches[:, corner] - point for corner in range(3))
        la, lb, lc = (np.linalg.norm(each, axis=1) for each in (a, b, c))
        triple = np.einsum("ij,ij->i", a, np.cross(b, c))
        below = la * lb * lc + lc * np.einsum("ij,ij->i", a, b)
        below += la * np.einsum("ij,ij->i", b, c) + lb * np.einsum("ij,ij->i", a, c)
        numbers[row] = 2.0 * np.arctan2(triple, below).sum() / (4.0 * math.pi)
    return numbers
