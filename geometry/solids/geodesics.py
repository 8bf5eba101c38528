"""Geodesics on a mesh that halve its area, and the distance over the surface from them.

Lines are straightened by flipping edges of an intrinsic triangulation until no corner of theirs can be cut (Sharp and
Crane, You can find geodesic paths in triangle meshes by just flipping edges, 2020): exact on the mesh. Distances are
found by fast marching (Kimmel and Sethian, Computing geodesic paths on manifolds, 1998). Both are those of potpourri3d.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from geometry.arrays import Directions, Indices, Points, Scalars
from geometry.solids.sections import Section, SurfaceMesh, chains_of, find_crossings, level_below, share_above

_HALVED = 0.005
"""Of the area, by which the two sides may differ from a half before the line is shifted again."""
_SHIFTS = 6
_CONTRACTED = 0.3
"""Of its length before: what is shorter after straightening has slipped off over an end of the surface."""
_HELD = 4
_ON = 1e-6
"""Of the longest edge: distances below are zero."""
_FAR = 1e9


@dataclass(frozen=True, slots=True, eq=False)
class Halving:
    """Geodesics that divide a surface in two."""

    lines: tuple[Section, ...]
    distances: Scalars
    """(v,) over the surface from the lines, mm: positive on one side, negative on the other."""
    share: float
    """Of the area, on the positive side."""


@dataclass(slots=True, eq=False)
class Geodesics:
    """Solvers over one surface, which is connected."""

    mesh: SurfaceMesh
    flips: Any = field(init=False)
    marching: Any = field(init=False)
    edges: Indices = field(init=False)
    """(e, 2) corners of all edges."""
    tree: KDTree = field(init=False)
    """Of the middles of the patches."""
    longest_mm: float = field(init=False)
    """The longest edge."""

    def __post_init__(self) -> None:
        # Imported late: it is compiled code that no other path class needs.
        from potpourri3d import EdgeFlipGeodesicSolver, MeshFastMarchingDistanceSolver

        points, corners = self.mesh.points, self.mesh.corners
        self.flips = EdgeFlipGeodesicSolver(points, corners)
        self.marching = MeshFastMarchingDistanceSolver(points, corners)
        both = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
        self.edges = np.unique(np.sort(both, axis=1), axis=0)
        self.tree = KDTree(points[corners].mean(axis=1))
        self.longest_mm = float(np.linalg.norm(points[self.edges[:, 0]] - points[self.edges[:, 1]], axis=1).max())

    def halve(self, direction: Points) -> Halving | None:
        """Geodesics along the section across a direction (3,) that leave half of the area on either side.

        The section of the plane that halves the area is straightened, its ends on the rim held, and shifted where its
        straightened lines leave more on one side. A ring on a surface without a rim is held at four points:
        nothing else keeps it from contracting.

        Returns:
            The lines; ``None`` where a ring contracts to a point.
        """
        heights = self.mesh.points @ direction
        best: tuple[float, list[Section], Scalars] | None = None
        above, low, high = 0.5, 0.0, 1.0
        for _ in range(_SHIFTS):
            lines = self._straightened(direction, level_below(self.mesh, heights, above))
            if lines is None:
                break
            near = self._near(lines)
            share = share_above(self.mesh, near, 0.0)
            if best is None or abs(share - 0.5) < abs(best[0] - 0.5):
                best = share, lines, near
            if abs(share - 0.5) <= _HALVED:
                break
            low, high = (above, high) if share < 0.5 else (low, above)
            shifted = above + 0.5 - share
            above = shifted if low < shifted < high else (low + high) / 2
        if best is None:
            return None
        share, lines, near = best
        known = np.flatnonzero(np.abs(near) < _FAR)
        sources = [(int(corner), []) for corner in known]
        found = self.marching.compute_distance([sources], [np.abs(near[known]).tolist()], False)
        return Halving(tuple(lines), np.copysign(np.asarray(found, dtype=np.float64), near), share)

    def _straightened(self, direction: Points, level: float) -> list[Section] | None:
        """Geodesics of the section at a level along a direction, between its ends or around; what is higher is left."""
        heights = self.mesh.points @ direction
        crossings = find_crossings(self.mesh, heights, level)
        nearest = np.where(
            np.abs(heights[crossings.low] - level) <= np.abs(heights[crossings.high] - level),
            crossings.low, crossings.high,
        )  # fmt: skip
        lines: list[Section] = []
        for chain, closed in chains_of(crossings):
            corners = _without_spurs(nearest[chain], closed=closed)
            if len(corners) < (4 if closed else 2):
                continue
            lefts = np.cross(self.mesh.normals[corners[:-1]], np.diff(self.mesh.points[corners], axis=0))
            if float(lefts.sum(axis=0) @ direction) < 0:
                corners = corners[::-1]
            points = self._ring(corners) if closed else self.straighten(corners)
            if points is None:
                return None
            lines.append(Section(points, self._normals_at(points), closed))
        return lines or None

    def straighten(self, corners: Indices) -> Points | None:
        """(k, 3) geodesic between the ends of a line over corners; ``None`` where it has no length."""
        try:
            return np.asarray(self.flips.find_geodesic_path_poly(corners.tolist()), dtype=np.float64)
        except RuntimeError:
            return None

    def _ring(self, corners: Indices) -> Points | None:
        """(k, 3) closed geodesic near a ring over corners, its first point once; ``None`` where it contracts."""
        before = _length(np.vstack([self.mesh.points[corners], self.mesh.points[corners[:1]]]))
        try:
            points = np.asarray(self.flips.find_geodesic_loop(corners.tolist()), dtype=np.float64)
        except RuntimeError:
            points = np.empty((0, 3))
        if len(points) > 3 and _length(points) > _CONTRACTED * before:
            return points[:-1]
        has_rim = 2 * len(self.edges) != 3 * len(self.mesh.corners)
        if has_rim:
            return None
        places = self.mesh.points[corners]
        away = np.linalg.norm(places - places.mean(axis=0), axis=1)
        corners = np.roll(corners, -int(np.argmax(np.round(away / self.longest_mm, 2))))
        corners = np.append(corners, corners[0])
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.mesh.points[corners], axis=0), axis=1))])
        held = np.searchsorted(along, along[-1] * np.linspace(0.0, 1.0, _HELD + 1) - 1e-9)
        arcs = [self.straighten(corners[one : two + 1]) for one, two in pairwise(held.tolist())]
        whole = [arc[:-1] for arc in arcs if arc is not None]
        return np.vstack(whole) if len(whole) == _HELD else None

    def _normals_at(self, points: Points) -> Directions:
        """(k, 3) normals of the surface at points on it, smoothed as at its corners."""
        row, patch = self._candidates(points)
        weights, off = self._foot(points[row], patch)
        order = np.lexsort((patch, np.round(off / (_ON * self.longest_mm)), row))
        best = order[np.unique(row[order], return_index=True)[1]]
        normals = np.einsum("kc,kci->ki", weights[best], self.mesh.normals[self.mesh.corners[patch[best]]])
        return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)

    def _candidates(self, points: Points) -> tuple[Indices, Indices]:
        """Rows of points (k, 3) on the surface, and patches that they may lie on."""
        found = self.tree.query_ball_point(points, self.longest_mm, return_sorted=True)
        row = np.repeat(np.arange(len(points)), [len(each) for each in found])
        return row, np.concatenate([np.asarray(each, dtype=np.int64) for each in found])

    def _foot(self, points: Points, patch: Indices) -> tuple[Points, Scalars]:
        """(k, 3) barycentric weights of about the nearest place of a patch to each point, and how far off that is."""
        a, b, c = (self.mesh.points[self.mesh.corners[patch, corner]] for corner in range(3))
        e1, e2, w = b - a, c - a, points - a
        d11, d12, d22 = (np.einsum("ij,ij->i", *each) for each in ((e1, e1), (e1, e2), (e2, e2)))
        d1, d2 = np.einsum("ij,ij->i", w, e1), np.einsum("ij,ij->i", w, e2)
        square = np.maximum(d11 * d22 - d12**2, 1e-30)
        u, v = (d22 * d1 - d12 * d2) / square, (d11 * d2 - d12 * d1) / square
        weights = np.clip(np.column_stack([1 - u - v, u, v]), 0.0, None)
        weights /= weights.sum(axis=1, keepdims=True)
        feet = np.einsum("kc,kci->ki", weights, np.stack([a, b, c], axis=1))
        return weights, np.linalg.norm(points - feet, axis=1)

    def _near(self, lines: list[Section]) -> Scalars:
        """(v,) signed distances at the corners of the patches that lines pass; beyond them a large number, signed."""
        begin, end = (np.concatenate(each) for each in zip(*(_segments(line) for line in lines), strict=True))
        row, patch = self._candidates((begin + end) / 2)
        # Each segment lies in one patch, or in the edge of two: on its corners' sides there is no doubt.
        off = np.maximum(*(self._foot(each[row], patch)[1] for each in (begin, end)))
        row, patch = row[off <= _ON * self.longest_mm], patch[off <= _ON * self.longest_mm]
        corners = self.mesh.corners[patch]
        place = self.mesh.points[corners]
        along = (end - begin)[row]
        aside = np.cross(self.mesh.facing[patch], along)
        height = np.einsum("kci,ki->kc", place - begin[row][:, None], aside)
        height /= np.maximum(np.linalg.norm(aside, axis=1), 1e-12)[:, None]
        reach = _to_segments(place.reshape(-1, 3), np.repeat(begin[row], 3, axis=0), np.repeat(end[row], 3, axis=0))
        flat, height = corners.ravel(), height.ravel()
        order = np.lexsort((-np.abs(height), np.round(reach / (_ON * self.longest_mm)), flat))
        known, first = np.unique(flat[order], return_index=True)
        sign = np.sign(height[order[first]])
        distance = _to_segments(self.mesh.points[known][:, None], begin[None], end[None]).min(axis=1)
        values = np.zeros(len(self.mesh.points))
        values[known] = sign * distance
        return self._flooded(values, known)

    def _flooded(self, values: Scalars, known: Indices) -> Scalars:
        """Signs of the known corners' sides, spread over all others, which no edge leads to from the other side."""
        tiny = _ON * self.longest_mm
        values = np.where(np.abs(values) < tiny, 0.0, values)
        is_known = np.zeros(len(values), dtype=np.bool_)
        is_known[known] = True
        on_it = is_known & (values == 0.0)
        one, two = self.edges.T
        apart = (is_known[one] & is_known[two] & (values[one] * values[two] < 0)) | on_it[one] | on_it[two]
        one, two = one[~apart], two[~apart]
        graph = coo_array((np.ones(len(one), dtype=np.int8), (one, two)), shape=(len(values),) * 2)
        side = connected_components(graph, directed=False)[1]
        sign = np.sign(np.bincount(side, np.sign(values)))[side]
        return np.where(on_it, 0.0, sign * np.where(is_known, np.abs(values), _FAR))


def _without_spurs(corners: Indices, *, closed: bool) -> Indices:
    """Corners along a line without those between two visits to the same one: flips do not straighten a way back."""
    corners = corners[np.concatenate([[True], np.diff(corners) != 0])]
    if closed:  # begin where the ring passes once
        corners = corners[:-1] if len(corners) > 1 and corners[0] == corners[-1] else corners
        found, visits = np.unique(corners, return_counts=True)
        once = np.flatnonzero(np.isin(corners, found[visits == 1]))
        corners = np.roll(corners, -int(once[0])) if len(once) else corners
    kept: dict[int, None] = {}
    for corner in corners.tolist():
        while corner in kept and next(reversed(kept)) != corner:
            kept.popitem()
        kept[corner] = None
    return np.array(list(kept), dtype=np.int64)


def _length(points: Points) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _segments(line: Section) -> tuple[Points, Points]:
    """(m, 3) beginnings and ends of the segments of a line that have a length."""
    points = np.vstack([line.points, line.points[:1]]) if line.closed else line.points
    solid = np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9
    return points[:-1][solid], points[1:][solid]


def _to_segments(points: Points, begin: Points, end: Points) -> Scalars:
    """(k,) distances of points (k, 3) from the segments between (k, 3) ends."""
    ways = end - begin
    share = np.einsum("...i,...i->...", points - begin, ways) / np.maximum(
        np.einsum("...i,...i->...", ways, ways), 1e-18
    )
    return np.linalg.norm(points - begin - np.clip(share, 0.0, 1.0)[..., None] * ways, axis=-1)
