"""Whether a mesh bounds a solid: corners joined, edges that two patches share, one winding, no crossing."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from geometry.arrays import Indices, Triangles
from geometry.compiled import compiled
from geometry.mesh import cross_products
from geometry.solids.tree import Tree, build_tree, crossing_patches

_CELLS = 1_000_000.0
"""Corners in one cell of a millionth of the mesh's size are one corner."""


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """The edges of a mesh whose corners are joined."""

    corners: Indices
    """(n, 3) corner of each patch at each of its vertices."""
    first: Indices
    """(k,) patch on one side of each edge that exactly two patches share."""
    second: Indices
    """(k,) patch on its other side."""
    ends: Indices
    """(k, 2) corners that each of them joins."""
    against: NDArray[np.bool_]
    """(k,) whether both patches run along it in the same sense: their windings contradict each other."""
    rim: Indices
    """(k, 2) corners of the edges that belong to one patch alone."""
    crowded: int
    """Edges that belong to three patches or more."""

    @property
    def open(self) -> int:
        """Edges that belong to one patch alone."""
        return len(self.rim)


def join_corners(patches: Triangles) -> Indices:
    """Give (n, 3) numbers of the corners of patches; vertices within a millionth of the mesh's size are one."""
    points = patches.reshape(-1, 3)
    low = points.min(axis=0)
    size = float((points.max(axis=0) - low).max())
    cells = np.rint((points - low) * (_CELLS / size if size > 0 else 1.0)).astype(np.int64)
    keys = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
    return np.unique(keys, return_inverse=True)[1].reshape(-1, 3).astype(np.int64)


def join_near(patches: Triangles, within: float) -> Triangles:
    """Give patches (n, 3, 3) in which corners that are nearer to each other than a length are the first of them."""
    points, own = np.unique(patches.reshape(-1, 3), axis=0, return_inverse=True)
    pairs = KDTree(points).query_pairs(within, output_type="ndarray")
    if not len(pairs):
        return patches
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    group = connected_components(graph, directed=False)[1]
    first = np.unique(group, return_index=True)[1]
    return points[first[group[own.ravel()]]].reshape(patches.shape)


def find_edges(patches: Triangles) -> Edges:
    """Find which patches (n, 3, 3) share which edges."""
    corners = join_corners(patches)
    begin, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    order = np.lexsort((np.arange(len(low)), high, low))
    low, high, begin = low[order], high[order], begin[order]
    patch = order // 3
    starts = np.flatnonzero(np.concatenate([[True], (np.diff(low) != 0) | (np.diff(high) != 0)]))
    counts = np.diff(np.append(starts, len(low)))
    pairs, alone = starts[counts == 2], starts[counts == 1]
    return Edges(
        corners=corners,
        first=patch[pairs],
        second=patch[pairs + 1],
        ends=np.column_stack([low[pairs], high[pairs]]),
        against=begin[pairs] == begin[pairs + 1],
        rim=np.column_stack([low[alone], high[alone]]),
        crowded=int(np.count_nonzero(counts > 2)),
    )


def outward(patches: Triangles, edges: Edges) -> tuple[NDArray[np.bool_], bool]:
    """Find which patches to turn around so that all of a piece are wound alike, and those of a closed one outwards.

    Args:
        patches: (n, 3, 3) mm.
        edges: ``find_edges`` of them.

    Returns:
        (n,) which to turn, and whether any piece has no two sides (like a Möbius strip), where it cannot be done.
    """
    begin = np.concatenate([edges.first, edges.second])
    order = np.argsort(begin, kind="stable")
    starts = np.searchsorted(begin[order], np.arange(len(patches) + 1)).astype(np.int64)
    neighbours = np.concatenate([edges.second, edges.first])[order]
    piece, turned, twisted = _wind(starts, neighbours, np.concatenate([edges.against, edges.against])[order])
    wound = np.where(turned[:, None, None], patches[:, ::-1], patches)
    middle = patches.reshape(-1, 3).mean(axis=0)
    volumes = np.bincount(piece, np.einsum("ij,ij->i", wound[:, 0] - middle, cross_products(wound)) / 6.0)
    volumes = volumes.astype(np.float64)
    closed = edges.open == 0
    # Of a sheet neither side is the inner one: most of its patches stay as they are.
    kept = np.bincount(piece, np.where(turned, -1.0, 1.0))
    inverted = volumes < 0 if closed else kept < 0
    if closed:
        inverted &= ~_are_cavities(wound, piece, volumes)
    return turned ^ inverted[piece], bool(twisted)


def _are_cavities(patches: Triangles, piece: Indices, volumes: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(pieces,) whether a piece that is wound inwards lies within the box of a larger one: it bounds a cavity."""
    count = len(volumes)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, piece, patches.min(axis=1))
    np.maximum.at(high, piece, patches.max(axis=1))
    within = (low[:, None] > low[None]).all(axis=2) & (high[:, None] < high[None]).all(axis=2)
    return (within & (volumes[None, :] > 0)).any(axis=1) & (volumes < 0)


@compiled
def _wind(
    starts: Indices, neighbours: Indices, opposed: NDArray[np.bool_]
) -> tuple[Indices, NDArray[np.bool_], NDArray[np.bool_]]:
    count = len(starts) - 1
    piece = np.full(count, -1, dtype=np.int64)
    turned = np.zeros(count, dtype=np.bool_)
    twisted = np.zeros(1, dtype=np.bool_)
    queue = np.empty(count, dtype=np.int64)
    pieces = 0
    for seed in range(count):
        if piece[seed] >= 0:
            continue
        piece[seed] = pieces
        queue[0] = seed
        first, last = 0, 1
        while first < last:
            here = queue[first]
            first += 1
            for k in range(starts[here], starts[here + 1]):
                other = neighbours[k]
                expected = turned[here] != opposed[k]
                if piece[other] < 0:
                    piece[other] = pieces
                    turned[other] = expected
                    queue[last] = other
                    last += 1
                elif turned[other] != expected:
                    twisted[0] = True
        pieces += 1
    return piece, turned, twisted


def count_crossings(patches: Triangles, edges: Edges, tree: Tree | None = None) -> int:
    """Count patches that another one, which shares no corner with them, passes through."""
    found = build_tree(patches) if tree is None else tree
    return int(crossing_patches(found, np.ascontiguousarray(patches), edges.corners).sum())
