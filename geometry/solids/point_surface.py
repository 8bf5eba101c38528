"""A surface through a cloud of points: normals, one side, and a mesh that ends where the points end.

The signed distance to the tangent planes of the points is taken on a grid around them (Hoppe, DeRose, Duchamp, McDonald
and Stuetzle, Surface reconstruction from unorganized points, 1992), and a corner is set in each cell that it passes
through (surface nets: Gibson, Constrained elastic surface nets, 1998), so that triangles are well shaped.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import KDTree

from geometry.arrays import Directions, Indices, Points, Scalars, Triangles
from geometry.solids.soundness import find_edges

_CELLS = 7_000
"""Cells with points in them that a cloud is thinned to, or fewer."""
_SPACINGS = 2.5
"""Least edge of a cell, in distances between neighbouring points: fewer leave cells of the surface empty."""
_NEAR = 12
"""Points that a normal is fitted to."""
_REACH = 1.8
"""Of the grid around the points, in cells."""
_BLENDED = 8
"""Tangent planes that are blended at a place."""
_TRIM, _TRIM_SPACINGS = 0.6, 2.2
"""Triangles whose middle is farther from every point, in cells and in spacings, are beyond the end of the surface."""
_ASIDE = 0.4
"""Of a cell: what is farther from the plane through its neighbours is at a sharp edge, or beside the surface."""
_SPARSE = 0.25
"""Of the points in the cells around it: what has fewer is no sharp edge."""
_LEAST_SHARE = 0.02
"""Of all points: what hangs together and is less is no surface."""
_MOST_NODES = 30_000_000
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
_PAIRS = [(a, b) for a in range(8) for b in range(a + 1, 8) if np.abs(_CORNERS[a] - _CORNERS[b]).sum() == 1]


@dataclass(frozen=True, slots=True, eq=False)
class PointSurface:
    """What was made of a cloud; in its own unit."""

    patches: Triangles
    """(n, 3, 3) wound so that their normals look to the side that is taken for the outer one."""
    points: Points
    """(m, 3) the cloud, thinned: middles of the points of each cell."""
    normals: Directions
    """(m, 3) outward unit normals there."""
    cell: float
    """Edge of a cell."""
    noise: float
    """Root mean square of the distances of the points from the tangent planes of their cells."""
    left_out: int
    """Points beside the surface, or in pieces of less than a fiftieth of all."""
    farthest: tuple[float, ...]
    """The one of them, ``x, y, z``, that is farthest from the rest; none where none was left out."""
    openings: tuple[float, ...]
    """Lengths of the rims at which it ends, longest first."""


def surface_of_points(cloud: Points, cell: float | None = None) -> PointSurface:
    """Lay a surface through points.

    The outer side of a closed piece is its outside. An open one has two; taken is the one that looks up (+z) on the
    whole, and of an upright one the one that looks along +x, or +y.

    Args:
        cloud: (n, 3) finite places in any order.
        cell: Edge of a cell; left out, as small as ``_CELLS`` of them allow and the points are dense enough for.

    Raises:
        ValueError: they are too few, or lie on a line; the message is a sentence's end.
    """
    cloud = np.unique(cloud, axis=0)  # in one order, whatever the file's
    size = np.ptp(cloud, axis=0) if len(cloud) else np.zeros(3)
    if len(cloud) < 3 * _NEAR or np.sort(size)[1] <= 1e-6 * size.max():
        raise ValueError(f"holds {len(cloud)} different points, which are no surface. Scan it more densely.")
    # Cells begin between points, so that a plane at a round height is not cut by rounding.
    low = cloud.min(axis=0)
    low = low - 0.37 * (cell or 1e-3 * float(size.max()))
    # Of points at random, a neighbour is half as far on the mean as were they on a grid.
    some = cloud[:: max(1, len(cloud) // 2000)]
    spacing = 2.0 * float(np.median(KDTree(cloud).query(some, k=2)[0][:, 1]))
    cell = cell or _fitting_cell(cloud, low, spacing)
    every = cloud
    _, owner, counts = np.unique(_keys(cloud, low, cell), return_inverse=True, return_counts=True)
    sums = np.column_stack([np.bincount(owner, cloud[:, axis], len(counts)) for axis in range(3)])
    points = sums / counts[:, None]  # middles of those in each cell
    for choose in (_large_pieces, _on_the_surface, _large_pieces):
        keep = choose(points, counts, cell)
        cloud, owner = cloud[keep[owner]], (np.cumsum(keep) - 1)[owner[keep[owner]]]
        points, counts = points[keep], counts[keep]
        if len(points) < _NEAR:
            raise ValueError("has too few points that hang together. Scan it more densely.")
    tree = KDTree(points)
    near = _neighbours(tree, points, _NEAR)
    normals = _fitted_normals(points, near)
    normals *= _signs(normals, near)[:, None]
    patches = _net(points, normals, tree, cell)
    reach = max(_TRIM * cell, _TRIM_SPACINGS * spacing)
    kept = KDTree(cloud)
    patches = patches[np.isfinite(kept.query(patches.mean(axis=1), distance_upper_bound=reach)[0])]
    if not len(patches):
        raise ValueError("has points too far apart for a surface. Scan it more densely.")
    patches, normals = _outside_out(patches, points, normals, tree)
    own = tree.query(cloud)[1]
    off = ((cloud - points[own]) * normals[own]).sum(axis=1)
    noise = float(np.sqrt(np.mean(off**2)))
    left_out = len(every) - len(cloud)
    farthest = tuple(every[int(np.argmax(kept.query(every)[0]))].tolist()) if left_out else ()
    return PointSurface(patches, points, normals, cell, noise, left_out, farthest, _rims(patches))


def _fitting_cell(cloud: Points, low: Points, spacing: float) -> float:
    """Edge of the cells that the points fill without gaps, and of which there are not too many."""
    cell = max(_SPACINGS * spacing, 1e-3 * float(np.ptp(cloud, axis=0).max()))
    for _ in range(20):
        count = len(np.unique(_keys(cloud, low, cell)))
        if count <= _CELLS:
            break
        cell *= max(1.02, float(np.sqrt(count / _CELLS)))
    return cell


def _keys(cloud: Points, low: Points, cell: float) -> NDArray[np.int64]:
    at = np.floor((cloud - low) / cell).astype(np.int64)
    return (at[:, 0] << 42) | (at[:, 1] << 21) | at[:, 2]


def _neighbours(tree: KDTree, points: Points, count: int) -> Indices:
    """(n, count) nearest points of a tree, nearest first."""
    return np.asarray(tree.query(points, k=count)[1]).reshape(len(points), count)


def _pieces(tree: KDTree, reach: float) -> Indices:
    """(m,) number of the piece of each point: neighbours within reach hang together."""
    pairs = tree.query_pairs(reach, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(tree.n, tree.n))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _large_pieces(points: Points, counts: Indices, cell: float) -> NDArray[np.bool_]:
    """(m,) whether a cell hangs together with a fiftieth of all points or more."""
    piece = _pieces(KDTree(points), 2.0 * cell)
    share = np.bincount(piece, counts) / counts.sum()
    return share[piece] >= _LEAST_SHARE


def _on_the_surface(points: Points, counts: Indices, cell: float) -> NDArray[np.bool_]:
    """(m,) whether a cell lies about in the plane through those around it, or has as many points as they have."""
    near = _neighbours(KDTree(points), points, _NEAR)[:, 1:]
    aside = ((points - points[near].mean(axis=1)) * _fitted_normals(points, near)).sum(axis=1)
    return (np.abs(aside) <= _ASIDE * cell) | (counts >= _SPARSE * np.median(counts[near], axis=1))


def _fitted_normals(points: Points, near: Indices) -> Directions:
    """(m, 3) normals of the planes through the neighbours of each point, on either side."""
    around = points[near] - points[near].mean(axis=1, keepdims=True)
    return np.linalg.eigh(np.einsum("mki,mkj->mij", around, around))[1][:, :, 0]


def _signs(normals: Directions, near: Indices) -> Scalars:
    """(m,) 1 or -1 so that neighbours look to the same side, along the tree that bends least; each piece by itself."""
    rows = np.repeat(np.arange(len(normals)), near.shape[1] - 1)
    columns = near[:, 1:].ravel()
    bend = 1.0 - np.abs((normals[rows] * normals[columns]).sum(axis=1)) + 1e-6
    shape = (len(normals), len(normals))
    graph = coo_array((bend, (rows, columns)), shape=shape).tocsr()
    forest = minimum_spanning_tree(graph.maximum(graph.T))
    count, piece = connected_components(forest, directed=False)
    signs = np.zeros(len(normals))
    for number in range(count):
        first = int(np.flatnonzero(piece == number)[0])
        order, before = breadth_first_order(forest, first, directed=False)
        signs[first] = 1.0
        for one in order[1:].tolist():
            other = before[one]
            signs[one] = signs[other] if normals[one] @ normals[other] >= 0 else -signs[other]
    return signs


def _net(points: Points, normals: Directions, tree: KDTree, cell: float) -> Triangles:
    """Triangles between the corners of the cells that the surface passes through, on both sides of each."""
    low = points.min(axis=0) - 2.63 * cell
    shape = np.ceil((points.max(axis=0) - low) / cell).astype(np.int64) + 3
    if float(np.prod(shape.astype(np.float64))) > _MOST_NODES:
        raise ValueError("is too fine for its size. State a larger cell_mm.")
    strides = np.array([shape[1] * shape[2], shape[2], 1])
    nodes = _nodes_near(points, low, cell, shape, strides)
    places = low + cell * np.stack(np.unravel_index(nodes, tuple(shape.tolist())), axis=1)
    height, _ = _seen_from(places, points, normals, tree)
    field = np.full(int(np.prod(shape)), np.nan)
    field[nodes] = height
    # Cells all of whose eight nodes are near the points, and that have some on both sides.
    corner = field[nodes[:, None] + _CORNERS @ strides]
    inside = (corner > 0).sum(axis=1)
    active = np.isfinite(corner).all(axis=1) & (inside > 0) & (inside < 8)
    cells, corner = nodes[active], corner[active]
    at = np.stack(np.unravel_index(cells, tuple(shape.tolist())), axis=1) + _crossings(corner)
    vertex = np.full(int(np.prod(shape)), -1)
    vertex[cells] = np.arange(len(cells))
    where = low + cell * at
    for _ in range(2):  # onto the blended tangent planes
        height, slope = _seen_from(where, points, normals, tree)
        where = where - height[:, None] * slope
    quads = [_quads(field, vertex, nodes, strides, axis) for axis in range(3)]
    found = np.concatenate(quads)
    return np.concatenate([where[found[:, [0, 1, 2]]], where[found[:, [0, 2, 3]]]])


def _nodes_near(points: Points, low: Points, cell: float, shape: Indices, strides: Indices) -> Indices:
    """Numbers of the nodes of the grid within reach of a point, in ascending order."""
    reach = int(np.ceil(_REACH))
    span = np.arange(-reach, reach + 2)
    around = np.stack(np.meshgrid(span, span, span, indexing="ij"), axis=-1).reshape(-1, 3)
    base = np.floor((points - low) / cell).astype(np.int64)
    found = [
        (base[close] + offset) @ strides
        for offset in around
        if (close := ((low + cell * (base + offset) - points) ** 2).sum(axis=1) <= (_REACH * cell) ** 2).any()
    ]
    return np.unique(np.concatenate(found))


def _seen_from(places: Points, points: Points, normals: Directions, tree: KDTree) -> tuple[Scalars, Directions]:
    """(n,) signed distances from the tangent planes of the nearest points, blended, and (n, 3) their unit normals.

    Points that look away from the nearest have no weight.
    """
    found = tree.query(places, k=_BLENDED)
    away, near = np.asarray(found[0]), np.asarray(found[1])
    around = normals[near]
    weights = np.exp(-((away / np.maximum(away[:, [3]], 1e-12)) ** 2))
    weights[np.einsum("nki,ni->nk", around, around[:, 0]) < 0] = 0.0
    weights /= weights.sum(axis=1, keepdims=True)
    mean = np.einsum("nk,nki->ni", weights, around)
    heights = np.einsum("nk,nki,nki->n", weights, places[:, None] - points[near], around)
    return heights, mean / np.linalg.norm(mean, axis=1, keepdims=True)


def _crossings(corner: NDArray[np.float64]) -> Points:
    """(n, 3) middle of where the surface crosses the edges of each cell, in cells."""
    total, count = np.zeros((len(corner), 3)), np.zeros(len(corner))
    for a, b in _PAIRS:
        crossed = (corner[:, a] > 0) != (corner[:, b] > 0)
        share = corner[crossed, a] / (corner[crossed, a] - corner[crossed, b])
        total[crossed] += _CORNERS[a] + share[:, None] * (_CORNERS[b] - _CORNERS[a])
        count[crossed] += 1
    return total / count[:, None]


def _quads(field: Scalars, vertex: Indices, nodes: Indices, strides: Indices, axis: int) -> Indices:
    """(q, 4) vertices around each edge of the grid along an axis that is crossed, wound towards the heights."""
    here, there = field[nodes], field[nodes + strides[axis]]
    crossed = np.isfinite(here) & np.isfinite(there) & ((here > 0) != (there > 0))
    begin, up = nodes[crossed], there[crossed] > 0
    one, two = strides[(axis + 1) % 3], strides[(axis + 2) % 3]
    around = np.stack([begin - one - two, begin - two, begin, begin - one], axis=1)
    found = vertex[around]
    whole = (found >= 0).all(axis=1)
    return np.where(up[:, None], found, found[:, ::-1])[whole]


def _outside_out(patches: Triangles, points: Points, normals: Directions, tree: KDTree) -> tuple[Triangles, Directions]:
    """Turn each piece of the surface so that its outer side is out."""
    piece = _pieces(tree, 2.0 * float(np.median(tree.query(points, k=2)[0][:, 1])))
    own = piece[tree.query(patches.mean(axis=1))[1]]
    patches, normals = patches.copy(), normals.copy()
    for number in range(int(piece.max()) + 1):
        mine = own == number
        if mine.any() and _looks_in(patches[mine]):
            patches[mine] = patches[mine][:, ::-1]
            normals[piece == number] *= -1.0
    return patches, normals


def _looks_in(patches: Triangles) -> bool:
    """Whether the side that the normals look to is the inner one, or that of an open piece which is not taken."""
    crossed = np.cross(patches[:, 1] - patches[:, 0], patches[:, 2] - patches[:, 0])
    total = crossed.sum(axis=0)
    area = float(np.linalg.norm(crossed, axis=1).sum())
    if np.linalg.norm(total) < 0.05 * area:  # closed, but for what was not scanned
        middle = patches.mean(axis=(0, 1))
        return float(((patches.mean(axis=1) - middle) * crossed).sum()) < 0
    for axis in (2, 0, 1):
        if abs(total[axis]) > 0.05 * area:
            return bool(total[axis] < 0)
    return False


def _rims(patches: Triangles) -> tuple[float, ...]:
    """Lengths of the rings of edges that belong to one triangle alone, longest first."""
    edges = find_edges(patches)
    places = np.zeros((int(edges.corners.max()) + 1, 3))
    places[edges.corners.ravel()] = patches.reshape(-1, 3)
    begin, end = edges.rim.T
    graph = coo_array((np.ones(len(begin)), (begin, end)), shape=(len(places), len(places)))
    ring = connected_components(graph, directed=False)[1]
    lengths = np.bincount(ring[begin], np.linalg.norm(places[end] - places[begin], axis=1))
    return tuple(sorted((length for length in lengths.tolist() if length > 0), reverse=True))
