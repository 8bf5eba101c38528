"""Lines on which a field over a surface has one value, such as sections by planes, with the surface's normals there."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import Directions, Indices, Points, Scalars, Triangles
from geometry.mesh import areas_and_normals
from geometry.rays import split_patches
from geometry.solids.soundness import find_edges

_ASIDE = 1e-7
"""Of the level: a line does not go through a corner, where it would fork."""
_ALIKE_MM = 2e-3
"""Rounding of coordinates to 0.0001 mm does not decide which of two equal edges is halved."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceMesh:
    """A piece of surface without edges that more than two patches share. Millimetres."""

    points: Points
    """(v, 3) corners, in the order in which the patches name them first."""
    corners: Indices
    """(n, 3) corners of each patch, wound outwards."""
    areas_mm2: Scalars
    """(n,) of the patches."""
    facing: Directions
    """(n, 3) outward normals of the patches."""
    normals: Directions = field(init=False)
    """(v, 3) of the surface at the corners: means of the patches that meet there, weighted by area."""

    def __post_init__(self) -> None:
        weighted = np.repeat(self.facing * self.areas_mm2[:, None], 3, axis=0)
        flat = self.corners.ravel()
        sums = np.column_stack([np.bincount(flat, weighted[:, axis], len(self.points)) for axis in range(3)])
        normals = sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-12)
        object.__setattr__(self, "normals", normals)


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """One line on a surface."""

    points: Points
    """(k, 3) in order; a closed one does not repeat its first point."""
    normals: Directions
    """(k, 3) of the surface there."""
    closed: bool


@dataclass(frozen=True, slots=True, eq=False)
class Crossings:
    """Where a field passes a level, patch by patch."""

    low: Indices
    """(k,) lower numbered corner of each edge that is crossed, ascending by both."""
    high: Indices
    """(k,) the other."""
    pairs: Indices
    """(m, 2) the two of them that each crossed patch joins, in the order of the patches."""


def surface_mesh(patches: Triangles, longest_mm: float | None = None) -> SurfaceMesh:
    """Number the corners of patches, so that each edge belongs to two of them at most, and each corner to one fan.

    Args:
        patches: (n, 3, 3) wound outwards, mm.
        longest_mm: Patches are halved until no edge is longer; left out, they stay.
    """
    if longest_mm is not None:
        patches, _ = split_patches(patches, longest_mm, _ALIKE_MM)
    areas, facing = areas_and_normals(patches.copy())
    keep = areas > 0
    patches, areas, facing = patches[keep], areas[keep], facing[keep]
    edges = find_edges(patches)
    # Two patches have a corner in common only where they share an edge at it: a pinched corner becomes two.
    whole = ~edges.against
    at = [
        3 * patch[:, None] + np.argmax(edges.corners[patch][:, None] == edges.ends[whole][:, :, None], axis=2)
        for patch in (edges.first[whole], edges.second[whole])
    ]
    one, two = (each.ravel() for each in at)
    count = 3 * len(patches)
    graph = coo_array((np.ones(len(one), dtype=np.int8), (one, two)), shape=(count, count))
    label = connected_components(graph, directed=False)[1]
    _, first, number = np.unique(label, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))
    return SurfaceMesh(patches.reshape(-1, 3)[np.sort(first)], rank[number].reshape(-1, 3), areas, facing)


def connected_pieces(mesh: SurfaceMesh) -> list[SurfaceMesh]:
    """Give the pieces of a surface that do not hang together, in the order of their first patches."""
    corners = mesh.corners
    one, two = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    graph = coo_array((np.ones(len(one), dtype=np.int8), (one, two)), shape=(len(mesh.points),) * 2)
    count, piece = connected_components(graph, directed=False)
    if count == 1:
        return [mesh]
    own = piece[corners[:, 0]]
    found: list[SurfaceMesh] = []
    for number in dict.fromkeys(own.tolist()):
        keep = own == number
        kept, renumbered = np.unique(corners[keep], return_inverse=True)
        renumbered = renumbered.reshape(-1, 3)
        found.append(SurfaceMesh(mesh.points[kept], renumbered, mesh.areas_mm2[keep], mesh.facing[keep]))
    return found


def share_above(mesh: SurfaceMesh, values: Scalars, level: float) -> float:
    """Share of the area on which a field, linear over each patch, is above a level; (v,) values at the corners."""
    return _share_of(_in_order(values[mesh.corners]), mesh.areas_mm2, level)


def level_below(mesh: SurfaceMesh, values: Scalars, share: float) -> float:
    """Level that a field (v,) is above on a share of the area."""
    ordered = _in_order(values[mesh.corners])
    low, high = float(ordered[0].min()), float(ordered[2].max())
    for _ in range(36):
        middle = (low + high) / 2
        low, high = (middle, high) if _share_of(ordered, mesh.areas_mm2, middle) > share else (low, middle)
    return (low + high) / 2


def _in_order(values: NDArray[np.float64]) -> tuple[Scalars, Scalars, Scalars]:
    """(n,) least, middle and greatest of three values of each row: sorting rows takes ten times as long."""
    a, b, c = values.T
    least, most = np.minimum(a, b), np.maximum(a, b)
    return np.minimum(least, c), np.maximum(least, np.minimum(most, c)), np.maximum(most, c)


def _share_of(ordered: tuple[Scalars, Scalars, Scalars], areas_mm2: Scalars, level: float) -> float:
    low, middle, high = ordered
    whole = low >= level
    cut = np.flatnonzero(~whole & (high > level))
    least, most = low[cut], high[cut]
    under = level >= middle[cut]
    near, far = np.where(under, most, least), np.where(under, least, most)
    corner = (near - level) ** 2 / ((near - middle[cut]) * (near - far))  # of the corner that is alone on its side
    shares = np.where(under, corner, 1.0 - corner)
    return float((areas_mm2[whole].sum() + (shares * areas_mm2[cut]).sum()) / areas_mm2.sum())


def find_crossings(mesh: SurfaceMesh, values: Scalars, level: float) -> Crossings:
    """Find the edges on which a field (v,) passes a level; an edge that ends on it passes above."""
    above = _beside(values, level) > 0
    own = above[mesh.corners]
    patch = np.flatnonzero(own.any(axis=1) & ~own.all(axis=1))
    corners, own = mesh.corners[patch], own[patch]
    onward, after = np.roll(corners, -1, axis=1), np.roll(own, -1, axis=1)
    rows, columns = np.nonzero(own != after)  # two of each patch, in the order of its edges
    one, two = corners[rows, columns], onward[rows, columns]
    keys, number = np.unique(np.minimum(one, two) * len(values) + np.maximum(one, two), return_inverse=True)
    return Crossings(keys // len(values), keys % len(values), number.reshape(-1, 2))


def _beside(values: Scalars, level: float) -> Scalars:
    heights = values - level
    return np.where(np.abs(heights) < _ASIDE, _ASIDE, heights)


def _shares(crossings: Crossings, values: Scalars, level: float) -> Scalars:
    """(k,) where each edge is crossed, from its lower numbered corner to the other."""
    heights = _beside(values, level)
    return heights[crossings.low] / (heights[crossings.low] - heights[crossings.high])


def section_lengths(mesh: SurfaceMesh, values: Scalars, level: float) -> Scalars:
    """(lines,) lengths of the lines on which a field (v,) has one value, mm, in no order."""
    found = find_crossings(mesh, values, level)
    if not len(found.pairs):
        return np.empty(0)
    share = _shares(found, values, level)[:, None]
    places = mesh.points[found.low] * (1 - share) + mesh.points[found.high] * share
    one, two = found.pairs.T
    graph = coo_array((np.ones(len(one), dtype=np.int8), (one, two)), shape=(len(places), len(places)))
    line = connected_components(graph, directed=False)[1]
    return np.asarray(np.bincount(line[one], np.linalg.norm(places[one] - places[two], axis=1)), dtype=np.float64)


def cut_section(mesh: SurfaceMesh, values: Scalars, level: float) -> list[Section]:
    """Lines on which a field over a surface has one value: sections by a plane, if it is the height above one.

    Args:
        mesh: The surface.
        values: (v,) field at its corners, linear over each patch.
        level: The value.

    Returns:
        The lines, in the order of their first patches; of a closed surface all are closed.
    """
    found = find_crossings(mesh, values, level)
    share = _shares(found, values, level)[:, None]
    places, normals = (each[found.low] * (1 - share) + each[found.high] * share for each in (mesh.points, mesh.normals))
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return [Section(places[chain], normals[chain], closed) for chain, closed in chains_of(found)]


def chains_of(crossings: Crossings) -> list[tuple[list[int], bool]]:
    """Crossings in their order along each line, and whether it closes; a closed one does not repeat its first."""
    segments: list[tuple[int, int]] = [(int(one), int(two)) for one, two in crossings.pairs]
    at: dict[int, list[int]] = {}
    for number, pair in enumerate(segments):
        for key in pair:
            at.setdefault(key, []).append(number)
    left = dict.fromkeys(range(len(segments)))
    chains: list[tuple[list[int], bool]] = []
    ends = [number for number, pair in enumerate(segments) if any(len(at[key]) == 1 for key in pair)]
    for start in (*ends, *range(len(segments))):  # open lines from their ends first, then rings
        if start not in left:
            continue
        one, two = segments[start]
        chain = [one, two] if len(at[one]) == 1 or len(at[two]) != 1 else [two, one]
        del left[start]
        while True:
            onward = next((number for number in at[chain[-1]] if number in left), None)
            if onward is None:
                break
            del left[onward]
            first, second = segments[onward]
            chain.append(second if first == chain[-1] else first)
        closed = len(chain) > 3 and chain[0] == chain[-1]
        chains.append((chain[:-1] if closed else chain, closed))
    return chains


def resample(section: Section, step_mm: float) -> Section:
    """Place points evenly along a section, no farther apart than a step; ends and first points stay."""
    points, normals = section.points, section.normals
    if section.closed:
        points, normals = np.vstack([points, points[:1]]), np.vstack([normals, normals[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    kept = np.concatenate([[True], np.diff(along) > 1e-9])
    points, normals, along = points[kept], normals[kept], along[kept]
    count = max(1, int(np.ceil(along[-1] / step_mm - 1e-6)))
    places = np.linspace(0.0, along[-1], count + 1)
    placed = np.column_stack([np.interp(places, along, points[:, axis]) for axis in range(3)])
    turned = np.column_stack([np.interp(places, along, normals[:, axis]) for axis in range(3)])
    turned /= np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-12)
    last = len(placed) - 1 if section.closed else len(placed)
    return Section(placed[:last], turned[:last], section.closed)


def length_of(section: Section) -> float:
    """Length of a section, mm."""
    points = np.vstack([section.points, section.points[:1]]) if section.closed else section.points
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def least_bent_axis(normals: Directions, areas_mm2: NDArray[np.float64], first: Points) -> Points:
    """(3,) direction that the normals are least along, such as the axis of a cylinder; ``first`` decides its sign.

    Where two directions are as good (a ball, a plane's two), the one nearest to ``first`` (3,) is taken.
    """
    spread = np.einsum("n,ni,nj->ij", areas_mm2, normals, normals) / areas_mm2.sum()
    values, vectors = np.linalg.eigh(spread)
    good = vectors[:, values < values[0] + 0.02]
    inside = good @ (good.T @ first)
    length = float(np.linalg.norm(inside))
    axis = inside / length if length > 1e-3 else good[:, 0]
    return axis / np.linalg.norm(axis)
