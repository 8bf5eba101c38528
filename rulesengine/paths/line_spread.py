"""How far lines of a hollow cone are drawn together: by what they leave on the whole side of the board."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, affinity

from geometry.arrays import Directions2, Points2, Scalars
from geometry.compiled import compiled
from recipes.footprint import spray_rays
from rulesengine.strokes.stroke import Site, Stroke, reference_axes

SPREADS = tuple(round(1.0 - 0.05 * step, 2) for step in range(15))
"""Tried, even lines first."""
MOST_LINES = 16
"""With more of them little of a board lies so near the rim that the hole of the ring matters."""
_WORTH = 0.02
"""Gain of the least tenth below which lines stay as even as they are."""
_PLACES = 32
"""Of the grid along the longer side of the board."""
_RAYS = 20_000
_BINS = 64
"""Of the pattern, across."""
_STEPS = 32
"""Poses along a line while the nozzle moves by the width of the pattern."""
_INSIDE_MM = 1e-6
"""Places on the very edge are outside, wherever the board lies."""


@dataclass(frozen=True, slots=True, eq=False)
class _Pattern:
    """What a resting jet leaves on the surface, around the foot of the orifice."""

    corner: Points2
    """(2,) middle of the first cell, mm"""
    cell: float
    """mm"""
    flux: NDArray[np.float64]
    """(n, n) share of the flow per mm²"""


def choose_spread(
    strokes_at: Callable[[float], Sequence[Stroke]], least: float, site: Site, travel: Directions2
) -> float:
    """Find the spread at which the tenth of the board's side that gets least gets most.

    Everything that the strokes spray counts: lines to their ends, what overshoots, pauses, and the moves that join
    lines with the jet on. The flux is that of the ring on the plane of the board, at the programmed speed.

    Args:
        strokes_at: Gives the strokes for a spread, in the side frame.
        least: Least spread that lines may have, at most 1; it is taken for a smaller one.
        site: Board and nozzle.
        travel: (2,) direction of the lines; the places of the grid lie along it.

    Returns:
        One of ``SPREADS``, or the least: 1, even lines, unless another and both beside it are better by a fiftieth; of
        those as good, the most even.
    """
    # In a frame of the lines, so that a board that is moved gets the lines moved with it.
    level = np.array([travel, [-travel[1], travel[0]]]).T
    places = _places(site.board.outline, travel)
    patterns: dict[bytes, _Pattern] = {}

    @cache  # on a small board most are the least one
    def tenth_at(spread: float) -> float:
        return _least_tenth(_deposit(strokes_at(spread), site, places, (level, patterns)))

    tenths = np.array([tenth_at(max(spread, least)) for spread in SPREADS])
    # Where the ring of a line no longer reaches a corner its deposit breaks off: lines keep a step away from there.
    sure = np.minimum(np.minimum(tenths[:-2], tenths[1:-1]), tenths[2:])
    if sure.max() <= (1 + _WORTH) * tenths[0]:
        return SPREADS[0]
    return max(SPREADS[1 + int(np.argmax((1 + _WORTH) * sure >= sure.max()))], least)


def _places(outline: Polygon, travel: Directions2) -> Points2:
    """(n, 2) middles of the cells of a grid that lie on the board, along the travel, in ascending order, and across."""
    angle = np.degrees(np.arctan2(travel[1], travel[0]))
    level = affinity.rotate(outline, -angle, origin=(0, 0))
    low_x, low_y, high_x, high_y = level.bounds
    step = max(high_x - low_x, high_y - low_y) / _PLACES
    across, up = (max(1, round(length / step)) for length in (high_x - low_x, high_y - low_y))
    x = low_x + (np.arange(across) + 0.5) * (high_x - low_x) / across
    y = low_y + (np.arange(up) + 0.5) * (high_y - low_y) / up
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    inside = level.buffer(-_INSIDE_MM)
    return grid[shapely.contains_xy(inside, grid[:, 0], grid[:, 1])]


def _least_tenth(deposit: Scalars) -> float:
    """Mean of the tenth of the places that gets least."""
    return float(np.sort(deposit)[: max(1, len(deposit) // 10)].mean())


def _deposit(
    strokes: Sequence[Stroke], site: Site, places: Points2, frame: tuple[NDArray[np.float64], dict[bytes, _Pattern]]
) -> Scalars:
    """(n,) seconds times share of the flow per mm² that strokes leave at places along and across the travel."""
    level, patterns = frame
    total = np.zeros(len(places))
    for stroke in strokes:
        for at in range(len(stroke.tcp)):
            key = stroke.approach[at].tobytes() + stroke.azimuth[at].tobytes() + stroke.tcp[at, 2].tobytes()
            if key not in patterns:
                patterns[key] = _pattern(stroke, at, site, level)
            pattern = patterns[key]
            poses, seconds = _poses(stroke, at, _BINS * pattern.cell / _STEPS)
            corner = pattern.corner / pattern.cell
            _add(total, (places / pattern.cell - corner, poses @ level / pattern.cell), seconds, pattern.flux)
    return total


def _poses(stroke: Stroke, at: int, step_mm: float) -> tuple[Points2, Scalars]:
    """(n, 2) feet of the orifice at a point and on the way to the next, and the (n,) seconds for which each stands."""
    here = stroke.tcp[[at], :2]
    if at + 1 == len(stroke.tcp):
        return here, stroke.delays[[at]]
    way = stroke.tcp[at + 1, :2] - here[0]
    length = float(np.linalg.norm(way))
    count = max(1, int(np.ceil(length / step_mm)))
    shares = (np.arange(count) + 0.5) / count
    seconds = np.full(count, length / stroke.speed_mm_s / count)
    return np.concatenate([here, here + shares[:, None] * way]), np.concatenate([stroke.delays[[at]], seconds])


def _pattern(stroke: Stroke, at: int, site: Site, level: NDArray[np.float64]) -> _Pattern:
    """Pattern of the jet at a point of a stroke, along and across the travel."""
    approach = stroke.approach[at]
    reference = reference_axes(stroke.approach[[at]], stroke.azimuth[[at]])[0]
    rays = spray_rays(site.nozzle, _RAYS)
    ways = np.column_stack([rays.slopes, np.ones(_RAYS)]) @ np.stack(
        [reference, np.cross(approach, reference), approach]
    )
    falling = ways[:, 2] < 0
    spots = (ways[falling, :2] * (-stroke.tcp[at, 2] / ways[falling, 2])[:, None]) @ level
    # Rays that hardly fall land beyond every board.
    low, high = np.quantile(spots, [0.005, 0.995], axis=0)
    middle, cell = (low + high) / 2, float((high - low).max()) / (_BINS - 2)
    edges = (np.arange(_BINS + 1) - _BINS / 2) * cell
    flux, _, _ = np.histogram2d(*(spots - middle).T, bins=(edges, edges), weights=rays.weights[falling])
    return _Pattern(middle + edges[0] + cell / 2, cell, flux / cell**2)


@compiled
def _add(total: Scalars, spots: tuple[Points2, Points2], seconds: Scalars, flux: NDArray[np.float64]) -> None:
    """Add what a jet leaves at places from poses, in cells of its pattern; linear between their middles."""
    places, poses = spots
    last = len(flux) - 1
    for pose in range(len(poses)):
        # Places ascend along the travel: most are beyond the pattern on one side or the other.
        for place in range(np.searchsorted(places[:, 0], poses[pose, 0]), len(places)):
            x = places[place, 0] - poses[pose, 0]
            y = places[place, 1] - poses[pose, 1]
            if x >= last:
                break
            if x >= 0.0 and 0.0 <= y < last:
                i, j = int(x), int(y)
                u, v = x - i, y - j
                below = flux[i, j] * (1.0 - v) + flux[i, j + 1] * v
                above = flux[i + 1, j] * (1.0 - v) + flux[i + 1, j + 1] * v
                total[place] += seconds[pose] * (below * (1.0 - u) + above * u)
