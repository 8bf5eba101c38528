"""Loose triangles: the connected bodies in a heap, and which of them belong to one part."""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from boards.formats.tree import Part
from geometry.arrays import Indices, Triangles
from geometry.polygons import project

_TOUCH_MM = 0.005
_CELLS = 1_000_000.0


def split_bodies(patches: Triangles) -> list[Triangles]:
    """Cut a heap into bodies connected over edges that exactly two patches share, in file order.

    An edge of four patches is where two closed bodies touch: it does not connect them.
    """
    from trimesh.graph import connected_component_labels, face_adjacency

    faces = _share_vertices(patches)
    solid = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    faces, patches = faces[solid], patches[solid]
    if not len(faces):
        return []
    labels = np.asarray(connected_component_labels(face_adjacency(faces), node_count=len(faces)), dtype=np.int64)
    _, first, label = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))[label]
    order = np.argsort(rank, kind="stable")
    return np.split(patches[order], np.flatnonzero(np.diff(rank[order])) + 1)


def _share_vertices(patches: Triangles) -> Indices:
    """Number equal vertices equally; (n, 3). Equal means the same cell of a millionth of the heap's size."""
    points = patches.reshape(-1, 3)
    low = points.min(axis=0)
    size = float((points.max(axis=0) - low).max())
    cells = np.rint((points - low) * (_CELLS / size if size > 0.0 else 1.0)).astype(np.int64)
    keys = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
    return np.unique(keys, return_inverse=True)[1].reshape(-1, 3).astype(np.int64)


def plan_hull(patches: Triangles) -> BaseGeometry:
    """Convex hull of the projection onto the board's plane."""
    return shapely.LineString(patches[:, :, :2].reshape(-1, 2)).convex_hull


def height_range(patches: Triangles) -> tuple[float, float]:
    """Lowest and highest z."""
    z = patches[:, :, 2]
    return float(z.min()), float(z.max())


def touching_groups(heaps: Sequence[Triangles], within_mm: float) -> list[list[int]]:
    """Group the heaps that come as close as that both in plan and in height; groups in the order of their first.

    Hulls find the candidates, true projections decide: what stands in the recess of another part stays apart.
    """
    from trimesh.graph import connected_component_labels

    hulls = np.array([plan_hull(heap) for heap in heaps], dtype=object)
    pairs = shapely.STRtree(hulls).query(hulls, predicate="dwithin", distance=within_mm).T.astype(np.int64)
    spans = np.array([height_range(heap) for heap in heaps])
    i, j = pairs[:, 0], pairs[:, 1]
    level = (spans[i, 0] <= spans[j, 1] + within_mm) & (spans[j, 0] <= spans[i, 1] + within_mm)
    pairs = pairs[level & (i < j)]
    shadows = hulls.copy()
    for row in np.unique(pairs).tolist():
        shadow = project(heaps[row])
        shadows[row] = hulls[row] if shadow.is_empty else shadow  # a sheet on edge has no shadow
    close = shapely.distance(shadows[pairs[:, 0]], shadows[pairs[:, 1]]) <= within_mm
    labels = connected_component_labels(pairs[close], node_count=len(heaps))
    groups: dict[int, list[int]] = {}
    for row, label in enumerate(np.asarray(labels).tolist()):
        groups.setdefault(label, []).append(row)
    return list(groups.values())


def join_touching(bodies: Sequence[Part]) -> list[Part]:
    """Join unnamed bodies that lie over each other in plan and touch: the pins and the case of one part.

    Returns:
        Parts, the largest in plan first, then in file order: an order that does not change when the board is moved.
    """
    if not bodies:
        return []
    groups = touching_groups([body.patches() for body in bodies], _TOUCH_MM)
    parts = [Part("", None, tuple(own for row in rows for own in bodies[row].geometry), False) for rows in groups]
    return sorted(parts, key=lambda part: -round(float(plan_hull(part.patches()).area), 2))
