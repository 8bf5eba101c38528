"""Holes of a mesh, closed by the triangles of least area between their corners."""

from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from geometry.arrays import Points, Scalars, Triangles
from geometry.solids.soundness import find_edges

_MOST_CORNERS = 300


def fill_holes(patches: Triangles, widest: float) -> tuple[Triangles, tuple[tuple[float, Points], ...]]:
    """Close the rings of edges that belong to one patch alone and are no wider than a length.

    A ring that touches another, or has more than ``_MOST_CORNERS``, is left open. Area: Barequet and Sharir, Filling
    gaps in the boundary of a polyhedron, 1995.

    Args:
        patches: (n, 3, 3)
        widest: Longest distance between two corners of a hole.

    Returns:
        (m, 3, 3) with the new ones at the end, wound as the patch beside them, and each hole's width and middle (3,).
    """
    found: list[Triangles] = []
    holes: list[tuple[float, Points]] = []
    for ring in _rings(patches):
        width = (
            float(np.linalg.norm(ring[:, None] - ring[None], axis=2).max()) if len(ring) <= _MOST_CORNERS else np.inf
        )
        if width <= widest:
            found.append(ring[_between(ring)])
            holes.append((width, ring.mean(axis=0)))
    return np.concatenate([patches, *found]), tuple(holes)


def _rings(patches: Triangles) -> Iterator[Points]:
    """Yield the corners (k, 3) of each ring, against the sense of the patch that its first edge belongs to."""
    edges = find_edges(patches)
    places = np.zeros((int(edges.corners.max()) + 1, 3))
    places[edges.corners.ravel()] = patches.reshape(-1, 3)
    beside: dict[int, list[int]] = defaultdict(list)
    for one, other in edges.rim.tolist():
        beside[one].append(other)
        beside[other].append(one)
    begins, ends = edges.corners, np.roll(edges.corners, -1, axis=1)
    done: set[int] = set()
    for first in sorted(beside):
        if first in done:
            continue
        ring = [first]
        while len(beside[ring[-1]]) == 2 and (onward := [each for each in beside[ring[-1]] if each not in ring[-2:]]):
            if onward[0] == first:
                break
            ring.append(onward[0])
        done.update(ring)
        if len(ring) > 2 and all(len(beside[each]) == 2 for each in ring):
            is_along = ((begins == ring[0]) & (ends == ring[1])).any()
            yield places[ring[::-1] if is_along else ring]


def _between(ring: Points) -> list[list[int]]:
    """Triangles (k - 2, 3) between the corners of a ring, of the least area in all."""
    count = len(ring)
    least: Scalars = np.zeros((count, count))
    parted = np.zeros((count, count), dtype=np.int64)
    for span in range(2, count):
        for begin in range(count - span):
            end = begin + span
            middles = ring[begin + 1 : end]
            areas = 0.5 * np.linalg.norm(np.cross(middles - ring[begin], ring[end] - ring[begin]), axis=1)
            costs = least[begin, begin + 1 : end] + least[begin + 1 : end, end] + areas
            at = int(np.argmin(costs))
            least[begin, end], parted[begin, end] = costs[at], begin + 1 + at
    found: list[list[int]] = []
    todo = [(0, count - 1)]
    while todo:
        begin, end = todo.pop()
        if end - begin > 1:
            middle = int(parted[begin, end])
            found.append([begin, middle, end])
            todo += [(begin, middle), (middle, end)]
    return found
