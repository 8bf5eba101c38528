"""Faces of a mesh: regions grown over its edges, flat ones first where they are large."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import Directions, Indices, Scalars
from geometry.solids.soundness import Edges

FLAT_DEG = 1.0
"""Patches whose normals differ by less lie in one plane."""
_FLAT_SHARE = 0.08
"""Of a smooth region: a flat piece so large is a face by itself. A facet of a round face is always smaller: at a split
of 20 degrees a full turn has at least 18 of them."""
_LEAST_SHARE = 0.01
_TIMES_NEIGHBOUR = 4.0
"""A smaller flat piece stands alone too where it is so much larger than every piece that it passes over into smoothly:
a flat with rounded edges, and no facet of a round face, whose neighbours are like it."""


@dataclass(frozen=True, slots=True, eq=False)
class Regions:
    """Faces of a mesh."""

    face: Indices
    """(n,) face of each patch; faces are numbered by their first patch."""
    flat: NDArray[np.bool_]
    """(faces,) whether all patches of a face lie in one plane."""


def find_regions(
    normals: Directions, areas_mm2: Scalars, edges: Edges, split_deg: float, least_mm2: float = 0.0
) -> Regions:
    """Grow regions over edges at which the surface bends by less than an angle; large flat pieces stand alone.

    Single patches are regions too (trimesh's ``facets`` leaves them out).

    Args:
        normals: (n, 3) outward.
        areas_mm2: (n,)
        edges: ``find_edges`` of the patches, wound outwards.
        split_deg: From this angle on an edge ends a face.
        least_mm2: A smaller region joins the one that it has the longest border with.
    """
    bends = np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", normals[edges.first], normals[edges.second]), -1, 1)))
    smooth = _components(len(normals), edges, bends < split_deg)
    plane = _components(len(normals), edges, bends < FLAT_DEG)
    areas = np.bincount(plane, areas_mm2).astype(np.float64)
    first_of_plane = np.unique(plane, return_index=True)[1]
    whole = np.bincount(smooth, areas_mm2)[smooth[first_of_plane]]
    alone = (areas >= _FLAT_SHARE * whole) | (
        (areas >= _LEAST_SHARE * whole)
        & (areas >= _TIMES_NEIGHBOUR * _largest_beside(areas, plane, edges, bends < split_deg))
    )
    alone &= _planar(normals, areas_mm2, plane)
    rest = _components(
        len(normals), edges, (bends < split_deg) & ~alone[plane[edges.first]] & ~alone[plane[edges.second]]
    )
    label = np.where(alone[plane], plane, plane.max() + 1 + rest)
    if least_mm2 > 0:
        label = _without_small(label, areas_mm2, edges, least_mm2)
    _, first, face = np.unique(label, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))
    face = rank[face]
    return Regions(face, _planar(normals, areas_mm2, face))


def _without_small(label: Indices, areas_mm2: Scalars, edges: Edges, least_mm2: float) -> Indices:
    """Regions, those that are too small joined to a neighbour, round by round."""
    while True:
        label = np.unique(label, return_inverse=True)[1]
        small = np.bincount(label, areas_mm2) < least_mm2
        one, two = label[edges.first], label[edges.second]
        border = one != two
        count = len(small)
        pairs = np.concatenate([one[border] * count + two[border], two[border] * count + one[border]])
        pairs, lengths = np.unique(pairs, return_counts=True)
        own, other = pairs // count, pairs % count
        longest = np.lexsort((other, -lengths, own))
        longest = longest[np.unique(own[longest], return_index=True)[1]]
        longest = longest[small[own[longest]]]
        if not len(longest):
            return label
        graph = coo_array((np.ones(len(longest)), (own[longest], other[longest])), shape=(count, count))
        label = connected_components(graph, directed=False)[1].astype(np.int64)[label]


def _components(count: int, edges: Edges, joined: NDArray[np.bool_]) -> Indices:
    first, second = edges.first[joined], edges.second[joined]
    graph = coo_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(count, count))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _largest_beside(areas: Scalars, plane: Indices, edges: Edges, smooth: NDArray[np.bool_]) -> Scalars:
    """(planes,) area of the largest other piece that each passes over into without a sharp edge."""
    one, two = plane[edges.first[smooth]], plane[edges.second[smooth]]
    other = one != two
    largest = np.zeros(len(areas))
    np.maximum.at(largest, one[other], areas[two[other]])
    np.maximum.at(largest, two[other], areas[one[other]])
    return largest


def _planar(normals: Directions, areas_mm2: Scalars, label: Indices) -> NDArray[np.bool_]:
    """(labels,) whether the normals of a region's patches are all within a degree of their mean."""
    count = int(label.max()) + 1
    means = np.column_stack([np.bincount(label, areas_mm2 * normals[:, axis], count) for axis in range(3)])
    means /= np.maximum(np.linalg.norm(means, axis=1, keepdims=True), 1e-12)
    cosines = np.einsum("ij,ij->i", normals, means[label])
    least = np.ones(count)
    np.minimum.at(least, label, np.where(areas_mm2 > 0, cosines, 1.0))
    return least > np.cos(np.radians(FLAT_DEG))
