"""Passes as segments with their knots, the moves of a timed program, and the cells that they reach and must serve."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from boards.board import Board, Part, Side
from boards.part.cells import film_cells
from cleaning.exposure.segment_rates import Segments
from cleaning.surface.facets import build_facets, build_scene
from geometry.arrays import Directions, Indices, Points, Scalars
from geometry.rays import RayScene, cast
from programs.plan import SprayPass
from rulesengine.levelling.report import FilmSpread, Goal

_SAME_MM = 0.02
"""Places nearer than this are one."""
_ABOVE_MM = 50.0
_LONGEST_MM, _CELL_MM = 2.0, 1.5
"""Edges of facets at most, and about the size of cells, as the cleaning model has them."""
_FLATTEST = 0.2
"""Least cosine between a face and the board for its places to count: walls are seen from aside."""
_TENTH = 0.1
_UNSHIFTED = 0.5
_LEAST_SHARE = 0.1
"""A cell that gets less than this share of the mean is taken as hidden: it is for the paths around components."""


def divided(each: SprayPass, longest_mm: float) -> SprayPass:
    """Divide the segments of a pass evenly, none longer; directions turn evenly along them."""
    lengths = np.linalg.norm(np.diff(each.tcp, axis=0), axis=1)
    counts = np.maximum(np.ceil(lengths / longest_mm - 1e-9), 1).astype(np.int64)
    segment = np.repeat(np.arange(len(lengths)), counts)
    share = (np.arange(len(segment)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[segment]

    def mixed(values: NDArray[np.float64], *, unit: bool) -> NDArray[np.float64]:
        between = values[segment] + share[:, None] * (values[segment + 1] - values[segment])
        between = np.concatenate([between, values[-1:]])
        return between / np.linalg.norm(between, axis=1, keepdims=True) if unit else between

    return replace(
        each,
        tcp=mixed(each.tcp, unit=False),
        approach=mixed(each.approach, unit=True),
        reference=mixed(each.reference, unit=True),
        speeds_mm_s=each.speeds_mm_s[segment],
    )


def segments_of(passes: Iterable[SprayPass]) -> Segments:
    """Segments of passes in their order."""
    ends = [
        [np.stack([values[:-1], values[1:]], axis=1) for values in (each.tcp, each.approach, each.reference)]
        for each in passes
    ]
    return Segments(*(np.concatenate([each[k] for each in ends]) for k in range(3)))


def knots_of(counts: Sequence[int], apart: int) -> tuple[csr_array, Indices]:
    """(segments, knots) pace in the middle of each segment from those at knots, and (c, 2) neighbouring knots.

    Args:
        counts: Segments of each pass.
        apart: Segments from knot to knot.
    """
    return interpolated(counts, _intervals(counts, apart), 0.5)


def interpolated(counts: Sequence[int], parts: Sequence[int], where: float) -> tuple[csr_array, Indices]:
    """(segments, knots) shares of knots, evenly along each pass, in a value linear between them; (c, 2) neighbours.

    Args:
        counts: Segments of each pass.
        parts: Intervals between knots of each pass.
        where: Of each segment: 0 at its begin, 1 at its end.
    """
    segments, knots = np.array(counts), np.array(parts) + 1
    begins, of_pass = np.cumsum(knots) - knots, np.repeat(np.arange(len(counts)), segments)
    along = np.arange(segments.sum()) - np.repeat(np.cumsum(segments) - segments, segments)
    place = (along + where) / segments[of_pass] * (knots - 1)[of_pass]
    low = np.minimum(place.astype(np.int64), knots[of_pass] - 2)
    rows = np.tile(np.arange(len(along)), 2)
    columns = np.tile(begins[of_pass] + low, 2) + np.repeat([0, 1], len(along))
    values = np.concatenate([1.0 - (place - low), place - low])
    weights = csr_array((values, (rows, columns)), shape=(len(along), int(knots.sum())))
    firsts = np.delete(np.arange(knots.sum()), np.cumsum(knots) - 1)
    return weights, np.column_stack([firsts, firsts + 1]).astype(np.int64)


def _intervals(counts: Sequence[int], apart: int) -> list[int]:
    """Intervals between knots of each pass."""
    return [max(1, round(count / apart)) for count in counts]


def from_end(counts: Sequence[int], apart: int) -> Scalars:
    """(knots,) how many knots each is from the nearer end of its pass; arguments as for ``knots_of``."""
    each = [np.minimum(np.arange(part + 1), part - np.arange(part + 1)) for part in _intervals(counts, apart)]
    return np.concatenate(each).astype(np.float64)


def seconds_on(segments: Segments, moves: Segments, seconds: Scalars) -> Scalars:
    """(segments,) time that moves of a timed program along them spend on each, by the share of the way.

    Way and moves are compared from gap to gap: a transfer with the jet off, or passes that are not meant.

    Raises:
        ValueError: they have not as many gaps.
    """

    def runs_of(way: Segments) -> list[tuple[int, int]]:
        """First segment of each piece without a gap, and the one after its last."""
        gaps = np.linalg.norm(way.tcp[1:, 0] - way.tcp[:-1, 1], axis=1) > _SAME_MM
        return list(pairwise([0, *(np.flatnonzero(gaps) + 1).tolist(), len(way.tcp)]))

    runs, timed = runs_of(segments), runs_of(moves)
    if len(runs) != len(timed):
        raise ValueError(f"{len(runs)} runs of passes are {len(timed)} in the timed program")
    found = np.zeros(len(segments.lengths))
    for (begin, end), (first, last) in zip(runs, timed, strict=True):
        ends, way, clock = (
            np.concatenate([[0.0], np.cumsum(each)])
            for each in (segments.lengths[begin:end], moves.lengths[first:last], seconds[first:last])
        )
        scaled = ends * (way[-1] / max(float(ends[-1]), _SAME_MM))
        found[begin:end] = np.diff(np.interp(scaled, way, clock))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class SeenCells:
    """n places of a surface. Board frame, mm."""

    points: Points
    """(n, 3)"""
    normals: Directions
    """(n, 3) outward."""
    surface: Indices
    """(n,) index into the board's components; -1 for the bare board and fixtures."""


def cells_of_side(board: Board, side: Side, scene: RayScene, pitch_mm: float, shift: float) -> SeenCells:
    """Find the places that are seen straight from above a side, of the bare board and of what stands on it.

    Args:
        board: Whose outline bounds the grid, which turns with its longest edge.
        side: From which.
        scene: All bodies of the board.
        pitch_mm: Of the grid.
        shift: Share of the pitch by which the grid is shifted in both directions.
    """
    x_axis = np.array([*board.axis, 0.0])
    y_axis = np.array([-board.axis[1], board.axis[0], 0.0])
    corners = np.array(board.outline.exterior.coords)[:, :2]
    along, aside = corners @ x_axis[:2], corners @ y_axis[:2]
    u, v = (np.arange(each.min() + shift * pitch_mm, each.max(), pitch_mm) for each in (along, aside))
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    up = 1.0 if side == "top" else -1.0
    heights = scene.triangles[:, :, 2] * up
    origins = grid[:, :1] * x_axis + grid[:, 1:] * y_axis
    origins[:, 2] = up * (float(heights.max()) + _ABOVE_MM)
    faces, distances = cast(scene, origins, np.tile([0.0, 0.0, -up], (len(grid), 1)))
    normals = scene.normals[np.maximum(faces, 0)]
    seen = (faces >= 0) & np.isfinite(distances) & (normals[:, 2] * up >= _FLATTEST)
    points = origins[seen]
    points[:, 2] -= up * distances[seen]
    return SeenCells(points, normals[seen], np.full(len(points), -1, dtype=np.int64))


def exposed_cells(board: Board, finer: float) -> SeenCells:
    """Find the cells of the cleaning model that see the open sky, walls and all.

    Args:
        board: Whose bodies.
        finer: 1 for cells of the model's size, less for smaller ones.
    """
    facets = build_facets(board, build_scene(board, _LONGEST_MM * finer), _CELL_MM * finer)
    some = np.flatnonzero(facets.cell_exposed)
    return SeenCells(facets.cell_centres[some], facets.cell_normals[some], facets.cell_component[some])


def cells_of_faces(part: Part, pitch_mm: float, shift: float) -> SeenCells:
    """Give corners of the served faces cut about a pitch wide; shifted from 0.5, places inside in their stead."""
    cells = film_cells(part, pitch_mm, at_corners=shift == _UNSHIFTED)
    return SeenCells(cells.points, cells.normals, cells.face)


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """Cells that the levelled passes reach, and what each is to have."""

    cells: SeenCells
    rates: csr_array
    """(m, segments) of the passes that are levelled."""
    others: Scalars
    """(m,) film of the other passes of the step, timed."""
    before: Scalars
    """(m,) film at the present speeds, timed, others included."""
    surface: Indices
    """(m,) from 0: which component, or the bare board; all 0 with one film for all."""
    least: Scalars
    """(m,) film of all cells of a surface but its least tenth; or the film to reach."""
    film_um: float | None
    """The film to reach, the same for all; None where surfaces keep what they had."""

    def required(self, goal: Goal, factors: Scalars) -> Scalars:
        """(m,) that each cell is to have, with (surfaces,) factors; 0 where it is free."""
        if goal == "even-film":
            return self.least
        return np.where(self.before >= self.least, self.least * factors[self.surface], 0.0)

    def shares(self, film: Scalars) -> Scalars:
        """(surfaces,) what all cells but the least tenth have, as a share of what they had."""
        return least_tenths(film, self.surface) / least_tenths(self.before, self.surface)

    def spread(self, film: Scalars, goal: Goal) -> FilmSpread:
        """Compare (m,) films with what is to be had."""
        if self.film_um is None:
            off = 1.0 - self.shares(film)
        else:
            required = self.required(goal, np.ones(int(self.surface.max(initial=0)) + 1))
            some = required > 0.0
            off = (required - film)[some] / required[some]
            off = off if goal == "least-time" else np.abs(off)
        worst = float(np.max(off, initial=0.0))
        return FilmSpread(len(film), float(film.min()), float(film.mean()), float(film.max()), worst)


def aim(
    cells: SeenCells, rates: csr_array, films: tuple[Scalars, Scalars], goal: Goal, film_um: float | None
) -> Target:
    """Find what each cell that the levelled passes reach is to have.

    Args:
        cells: m of them.
        rates: (m, segments) of the levelled passes.
        films: (m,) of the levelled passes and of the others, timed, at the present speeds.
        goal: What the speeds are for.
        film_um: To be reached. Left out: each surface keeps its least tenth (least time), or the mean (even film).
    """
    own, others = films
    before = own + others
    equal = goal == "least-time" and film_um is None
    seen = np.flatnonzero(own > (0.0 if equal else _LEAST_SHARE * float(before.mean())))
    before = before[seen]
    surface = np.zeros(len(seen), dtype=np.int64)
    if equal:
        _, surface = np.unique(cells.surface[seen], return_inverse=True)
        least = least_tenths(before, surface)[surface]
    else:
        film_um = float(before.mean()) if film_um is None else film_um
        least = np.full(len(before), film_um)
    kept = SeenCells(cells.points[seen], cells.normals[seen], cells.surface[seen])
    return Target(kept, csr_array(rates[seen]), others[seen], before, surface.astype(np.int64), least, film_um)


def least_tenths(film: Scalars, surface: Indices) -> Scalars:
    """(surfaces,) the greatest film that at least nine tenths of the cells of a surface have.

    Args:
        film: (m,)
        surface: (m,) from 0, none without a cell.
    """
    order = np.lexsort((film, surface))
    counts = np.bincount(surface)
    first = np.cumsum(counts) - counts
    return film[order[first + np.floor(_TENTH * counts).astype(np.int64)]]
