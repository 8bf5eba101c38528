"""A sheet as a smooth height over a plane, continued beyond its rim, and curves on it that are equally far apart.

The height is a thin plate: nodes of a grid that a ray finds the surface at hold it there, all others it bends through
as little as it can, so that holes close and the surface runs on past ragged rims. Geodesics of a height z(x, y) obey
x'' = -z_x Q / (1 + z_x² + z_y²) with Q = z_xx x'² + 2 z_xy x' y' + z_yy y'² (do Carmo, Differential geometry of curves
and surfaces, 4.4); those at right angles to a geodesic stay as far from it as they are long (Gauss's lemma).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline
from scipy.sparse import csc_array, diags_array, eye_array, kron
from scipy.sparse.linalg import splu

from geometry.arrays import Directions, Points, Points2, Scalars
from geometry.rays import RayScene, cast
from geometry.solids.sections import Section, SurfaceMesh, resample

_LEAST_FACING = 0.2
"""Cosine between patches and the mean normal from which on they look to its side."""
_TURNED = 0.01
"""Of the area, that may look away from it."""
_ABOVE_MM = 10.0
_MOST_NODES = 40_000
_STEP_MM = 2.0
"""Of the integration of geodesics."""
_LONGER = 1.3
"""Than straight: ways over the surface from its middle to its rim."""
_CROWDED = 0.3
"""Of their distance on the start, at which neighbouring geodesics have run together."""


@dataclass(frozen=True, slots=True, eq=False)
class SheetField:
    """A surface as a height over the plane of its mean normal."""

    origin: Points
    """(3,) of the plane."""
    axes: Directions
    """(3, 3) rows: x along the curves, y across them, z the mean normal."""
    x: Scalars
    """(nx,) nodes of the grid."""
    y: Scalars
    """(ny,)"""
    covered: NDArray[np.bool_]
    """(nx, ny) nodes that the surface is over."""
    height: Any
    """Spline."""

    def slopes(self, places: Points2) -> tuple[Scalars, Scalars]:
        """(n,) dz/dx and dz/dy at places (n, 2)."""
        x, y = places.T
        return self.height.ev(x, y, dx=1), self.height.ev(x, y, dy=1)

    def lift(self, places: Points2) -> tuple[Points, Directions]:
        """(n, 3) points of the surface over places (n, 2) of the plane, and its normals there."""
        slope_x, slope_y = self.slopes(places)
        normals = np.column_stack([-slope_x, -slope_y, np.ones(len(places))])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        flat = np.column_stack([places, self.height.ev(*places.T)])
        return self.origin + flat @ self.axes, normals @ self.axes

    def are_covered(self, places: Points2) -> NDArray[np.bool_]:
        """(n,) whether the surface is over places (n, 2)."""
        steps = (places - [self.x[0], self.y[0]]) / [self.x[1] - self.x[0], self.y[1] - self.y[0]]
        rows, columns = np.round(steps).astype(np.int64).T
        nx, ny = self.covered.shape
        on_grid = (rows >= 0) & (rows < nx) & (columns >= 0) & (columns < ny)
        return on_grid & self.covered[np.clip(rows, 0, nx - 1), np.clip(columns, 0, ny - 1)]

    def geodesics(self, places: Points2, ways: Points2, length_mm: float) -> NDArray[np.float64]:
        """(n, k, 2) places along geodesics from (n, 2) places, 2 mm from one to the next, the first included.

        Args:
            places: Where they begin.
            ways: (n, 2) how far the plane's coordinates move for a millimetre over the surface.
            length_mm: Of each.
        """
        state = np.concatenate([places, ways], axis=1)
        found = [state]
        for _ in range(int(np.ceil(length_mm / _STEP_MM))):
            one = self._turn(state)
            two = self._turn(state + 0.5 * _STEP_MM * one)
            three = self._turn(state + 0.5 * _STEP_MM * two)
            four = self._turn(state + _STEP_MM * three)
            state = state + _STEP_MM / 6.0 * (one + 2.0 * two + 2.0 * three + four)
            found.append(state)
        return np.stack(found, axis=1)[:, :, :2]

    def _turn(self, state: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y, along, aside = state.T
        slope_x, slope_y = self.slopes(state[:, :2])
        bends = [self.height.ev(x, y, dx=2 - each, dy=each) for each in range(3)]
        bend = bends[0] * along**2 + 2.0 * bends[1] * along * aside + bends[2] * aside**2
        pull = -bend / (1.0 + slope_x**2 + slope_y**2)
        return np.column_stack([along, aside, pull * slope_x, pull * slope_y])

    def unit_ways(self, places: Points2, ways: Points2) -> tuple[Points2, Points2]:
        """(n, 2) ways over the surface of length 1, and those at right angles to them on their left."""
        slope_x, slope_y = self.slopes(places)
        rise = slope_x * ways[:, 0] + slope_y * ways[:, 1]
        along = np.column_stack([ways, rise]) / np.hypot(np.linalg.norm(ways, axis=1), rise)[:, None]
        normals = np.column_stack([-slope_x, -slope_y, np.ones(len(places))])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return along[:, :2], np.cross(normals, along)[:, :2]


def is_sheet(mesh: SurfaceMesh) -> bool:
    """Whether a surface looks to one side on the whole, so that it is a height over a plane."""
    mean = (mesh.facing * mesh.areas_mm2[:, None]).sum(axis=0)
    length = float(np.linalg.norm(mean))
    if length < 1e-9 * float(mesh.areas_mm2.sum()):
        return False
    away = mesh.facing @ (mean / length) < _LEAST_FACING
    return float(mesh.areas_mm2[away].sum()) <= _TURNED * float(mesh.areas_mm2.sum())


def sheet_field(
    mesh: SurfaceMesh, scene: RayScene, across: Directions, beyond_mm: float, smooth_mm: float
) -> SheetField:
    """Lay a smooth height through a sheet, and continue it beyond its rim.

    Args:
        mesh: ``is_sheet``.
        scene: Of its patches alone.
        across: (3,) direction at right angles to its mean normal, that y is to be along.
        beyond_mm: How far past the rim.
        smooth_mm: Waves much shorter than this are levelled out.
    """
    z = (mesh.facing * mesh.areas_mm2[:, None]).sum(axis=0)
    z /= np.linalg.norm(z)
    y = across - z * float(across @ z)
    y /= np.linalg.norm(y)
    axes = np.stack([np.cross(y, z), y, z])
    origin = mesh.points.mean(axis=0)
    flat = (mesh.points - origin) @ axes.T
    low, high = flat[:, :2].min(axis=0) - beyond_mm, flat[:, :2].max(axis=0) + beyond_mm
    pitch = max(smooth_mm / 2.0, float(np.sqrt(np.prod(high - low) / _MOST_NODES)))
    nodes = [np.linspace(a, b, max(8, int(np.ceil((b - a) / pitch)) + 1)) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1).reshape(-1, 2)
    top = float(flat[:, 2].max()) + _ABOVE_MM
    starts = origin + np.column_stack([grid, np.full(len(grid), top)]) @ axes
    faces, ways = cast(scene, starts, np.tile(-z, (len(grid), 1)))
    covered = faces >= 0
    seen = np.where(covered, top - np.where(covered, ways, 0.0), 0.0)
    shape = len(nodes[0]), len(nodes[1])
    heights = _thin_plate(seen, covered, shape, (smooth_mm / pitch) ** 4)
    return SheetField(
        origin, axes, nodes[0], nodes[1], covered.reshape(shape), RectBivariateSpline(*nodes, heights, s=0.0)
    )


def _thin_plate(
    seen: Scalars, covered: NDArray[np.bool_], shape: tuple[int, int], stiffness: float
) -> NDArray[np.float64]:
    """(nx, ny) heights that bend least and are near those seen (n,), where they are."""

    def bending(count: int) -> csc_array:
        return csc_array(diags_array([1.0, -2.0, 1.0], offsets=[0, 1, 2], shape=(count - 2, count)))  # pyright: ignore[reportArgumentType]

    def slope(count: int) -> csc_array:
        return csc_array(diags_array([-1.0, 1.0], offsets=[0, 1], shape=(count - 1, count)))  # pyright: ignore[reportArgumentType]

    nx, ny = shape
    bends = (
        (1.0, kron(bending(nx), eye_array(ny))),
        (1.0, kron(eye_array(nx), bending(ny))),
        (2.0, kron(slope(nx), slope(ny))),
    )
    matrix = csc_array(diags_array(covered.astype(np.float64)))
    for weight, each in bends:
        matrix = matrix + stiffness * weight * (each.T @ each)
    return splu(csc_array(matrix), permc_spec="MMD_AT_PLUS_A").solve(seen).reshape(shape)


@dataclass(frozen=True, slots=True, eq=False)
class CurveNet:
    """Places on a sheet by how far along the first curve, and how far from it over the surface."""

    field: SheetField
    along: Scalars
    """(u,) mm along the first curve, ascending."""
    aside: Scalars
    """(s,) mm from it, ascending."""
    places: NDArray[np.float64]
    """(u, s, 2)"""
    inside: NDArray[np.bool_]
    """(u, s) whether the surface is there."""

    @property
    def width(self) -> tuple[float, float]:
        """Least and greatest distance from the first curve at which the surface is."""
        rows = np.flatnonzero(self.inside.any(axis=0))
        return float(self.aside[rows[0]]), float(self.aside[rows[-1]])

    @property
    def is_crowded(self) -> bool:
        """Whether curves that begin apart have run together somewhere over the surface."""
        points, _ = self.field.lift(self.places.reshape(-1, 2))
        ways = np.linalg.norm(np.diff(points.reshape(*self.inside.shape, 3), axis=0), axis=2)
        both = self.inside[1:] & self.inside[:-1]
        return bool((ways[both] < _CROWDED * float(self.along[1] - self.along[0])).any())

    def curve(self, aside_mm: float, over_mm: float, reach_mm: float, step_mm: float) -> list[Section]:
        """Pieces of the curve at a distance from the first: from before what it passes to behind it.

        Args:
            aside_mm: The distance.
            over_mm: By which a piece begins before the surface and ends behind it.
            reach_mm: Surface up to so far aside counts: a curve beside the rim is as long as those on it.
            step_mm: Between points.
        """
        near = np.abs(self.aside - aside_mm) <= reach_mm
        rows = np.flatnonzero(self.inside[:, near].any(axis=1))
        if not len(rows):
            return []
        breaks = np.flatnonzero(np.diff(self.along[rows]) > 2.0 * over_mm + 1.5 * (self.along[1] - self.along[0]))
        firsts, lasts = rows[np.append(0, breaks + 1)], rows[np.append(breaks, len(rows) - 1)]
        at = int(np.clip(np.searchsorted(self.aside, aside_mm), 1, len(self.aside) - 1))
        share = (aside_mm - self.aside[at - 1]) / (self.aside[at] - self.aside[at - 1])
        line = (1.0 - share) * self.places[:, at - 1] + share * self.places[:, at]
        found: list[Section] = []
        for first, last in zip(firsts.tolist(), lasts.tolist(), strict=True):
            ends = self.along[first] - over_mm, self.along[last] + over_mm
            some = (self.along > ends[0] + 1e-9) & (self.along < ends[1] - 1e-9)
            where = np.concatenate([ends[:1], self.along[some], ends[1:]])
            places = np.column_stack([np.interp(where, self.along, line[:, axis]) for axis in range(2)])
            found.append(resample(Section(*self.field.lift(places), closed=False), step_mm))
        return found


def geodesic_net(field: SheetField, step_mm: float) -> CurveNet:
    """Geodesics at right angles to one along x through the middle of a sheet: rows are equally far apart everywhere."""
    middle, reach = _middle(field)
    along, _ = field.unit_ways(middle[None], np.array([[1.0, 0.0]]))
    ahead, back = (field.geodesics(middle[None], sign * along, reach)[0] for sign in (1.0, -1.0))
    start = np.concatenate([back[:0:-1], ahead])
    where: Scalars = (np.arange(len(start), dtype=np.float64) - (len(back) - 1)) * _STEP_MM
    every = max(1, round(step_mm / _STEP_MM))
    first = (len(back) - 1) % every
    ways = np.gradient(start, axis=0)[first::every]
    start, where = start[first::every], where[first::every]
    _, left = field.unit_ways(start, ways)
    sides = [field.geodesics(start, sign * left, reach) for sign in (1.0, -1.0)]
    places = np.concatenate([sides[1][:, :0:-1], sides[0]], axis=1)
    count = sides[0].shape[1]
    aside: Scalars = (np.arange(2 * count - 1, dtype=np.float64) - (count - 1)) * _STEP_MM
    return _net(field, where, aside, places)


def plane_net(field: SheetField, step_mm: float) -> CurveNet:
    """Sections by planes along x, as far apart as is measured over the surface in the middle of a sheet."""
    middle, reach = _middle(field)
    y = np.linspace(field.y[0], field.y[-1], 8 * len(field.y))
    height = field.height.ev(np.full_like(y, middle[0]), y)
    over = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(height)))])
    over -= np.interp(middle[1], y, over)
    count = int(np.ceil(reach / _STEP_MM))
    aside: Scalars = np.arange(-count, count + 1, dtype=np.float64) * _STEP_MM
    aside = aside[(aside >= over[0]) & (aside <= over[-1])]
    every = max(1, round(step_mm / _STEP_MM))
    steps: Scalars = np.arange(-(count // every), count // every + 1, dtype=np.float64) * (every * _STEP_MM)
    x = middle[0] + steps
    some = (x >= field.x[0]) & (x <= field.x[-1])
    places = np.stack(np.meshgrid(x[some], np.interp(aside, over, y), indexing="ij"), axis=-1)
    return _net(field, steps[some], aside, places)


def _middle(field: SheetField) -> tuple[Points2, float]:
    """(2,) middle of what is covered, and the length of ways that leave the grid."""
    rows, columns = np.nonzero(field.covered)
    low = np.array([field.x[rows.min()], field.y[columns.min()]])
    middle = (low + np.array([field.x[rows.max()], field.y[columns.max()]])) / 2.0
    diagonal = float(np.hypot(field.x[-1] - field.x[0], field.y[-1] - field.y[0]))
    return middle, _LONGER * diagonal / 2.0


def _net(field: SheetField, along: Scalars, aside: Scalars, places: NDArray[np.float64]) -> CurveNet:
    inside = field.are_covered(places.reshape(-1, 2)).reshape(places.shape[:2])
    return CurveNet(field, along, aside, places, inside)
