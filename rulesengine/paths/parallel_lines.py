"""Straight strokes across a board, shared by raster, final flush, step function and straight line."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon, affinity, get_coordinates

from geometry.arrays import Directions, Directions2, Points2, Scalars
from geometry.compiled import compiled
from geometry.coverage.stripes import Stripe, stripe_count, stripes
from recipes.footprint import core_footprint, spray_rays
from recipes.nozzles import HollowCone
from recipes.paths import FinalFlush, Raster, StepFunction, StraightLine, height_of
from rulesengine.strokes.stroke import Site, Stroke, StrokeSet, reference_axes, tilted
from rulesengine.strokes.workload import require_lines
from specs.finding import Finding
from specs.finding_rules import MARGIN_REDUCED, PITCH_TOO_WIDE

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
Toward: TypeAlias = Literal["travel", "against_travel", "left", "right"]


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
        deposit = np.sort(_deposit(strokes_at(spread), site, places, (level, patterns)))
        return float(deposit[: max(1, len(deposit) // 10)].mean())

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


@dataclass(frozen=True, slots=True, eq=False)
class Swath:
    """What one straight line serves at a height and tilt, seen along the travel, relative to the orifice; mm."""

    right_mm: float
    left_mm: float
    length_mm: float
    """Extent along the travel."""
    aim_mm: float
    """How far ahead of the orifice the axis meets the surface."""

    @property
    def width_mm(self) -> float:
        """Effective width of the footprint across the travel."""
        return self.left_mm - self.right_mm


def lean_of(travel: Directions2, toward: Toward) -> Directions2:
    """(2,) plan direction of a tilted jet."""
    left = np.array([-travel[1], travel[0]])
    return {"travel": travel, "against_travel": -travel, "left": left, "right": -left}[toward]


def pose_of(site: Site, travel: Directions2, tilt_deg: float, toward: Toward) -> tuple[Directions, Directions2]:
    """(3,) approach and (2,) azimuth of the nozzle while it travels."""
    return tilted(lean_of(travel, toward)[None], tilt_deg)[0], site.azimuths(travel[None])[0]


def swath(site: Site, height_mm: float, tilt_deg: float, toward: Toward, travel: Directions2) -> Swath:
    """Measure the real footprint along and across the direction of travel."""
    approach, azimuth = pose_of(site, travel, tilt_deg, toward)
    reference = reference_axes(approach[None], azimuth[None])[0]
    outline = core_footprint(site.nozzle, height_mm, approach, reference)
    across = outline @ np.array([-travel[1], travel[0]])
    along = outline @ travel
    aim = height_mm * np.tan(np.radians(tilt_deg)) * float(lean_of(travel, toward) @ travel)
    return Swath(float(across.min()), float(across.max()), float(np.ptp(along)), float(aim))


def travel_of(spec: Raster | FinalFlush | StepFunction, site: Site) -> Directions2:
    """(2,) direction of the first line."""
    along = np.array(site.board.axis)
    if spec.direction_deg == "longest_edge":
        return along
    if spec.direction_deg == "across_longest_edge":
        return np.array([-along[1], along[0]])
    angle = np.radians(spec.direction_deg)
    return np.array([np.cos(angle), np.sin(angle)])


def lay_lines(
    spec: Raster | FinalFlush | StepFunction,
    site: Site,
    travel: Directions2,
    strokes_of: Callable[[list[Stripe]], Sequence[Stroke]],
) -> tuple[list[Stripe], tuple[Finding, ...]]:
    """Lay the lines of a template across the board: where the jet serves them, not the orifice.

    Lines of a hollow cone at an automatic pitch, but for those of a flush, are drawn together as ``choose_spread``
    finds it best, as long as the wave front still reaches the region's edge.

    Args:
        spec: The template.
        site: Board and nozzle.
        travel: (2,) direction of travel.
        strokes_of: Gives the strokes that serve some lines.

    Returns:
        Stripes from the first line to the last, and findings. The first is the rightmost, seen along the travel.

    Raises:
        RecipeError: they would lie endlessly close together.
    """
    band = swath(site, height_of(spec), spec.tilt_deg, spec.toward, travel)
    pitch = (1 - spec.overlap) * band.width_mm if spec.pitch_mm == "auto" else spec.pitch_mm
    region, findings = _region(spec, site)
    if spec.pitch_mm != "auto" and spec.pitch_mm > band.width_mm:
        message = (
            f"Lines {spec.pitch_mm:g} mm apart leave strips uncovered: the footprint is {band.width_mm:.1f} mm wide "
            "at this height and tilt. Lower pitch_mm or write auto."
        )
        findings = (*findings, Finding(PITCH_TOO_WIDE, message, site.made_by))
    across = get_coordinates(region) @ np.array([-travel[1], travel[0]])
    require_lines(float(np.ptp(across)), pitch, site.made_by)

    def rows_at(spread: float) -> list[Stripe]:
        return stripes(region, travel, pitch, band.length_mm, spread)

    rows = rows_at(1.0)
    # The one-way front of a flush pushes rinse water off the board: measured, parts at the rim need its outer lines.
    by_ring = isinstance(site.nozzle, HollowCone) and spec.pitch_mm == "auto" and not isinstance(spec, FinalFlush)
    if by_ring and 1 < len(rows) <= MOST_LINES:
        width = float(np.ptp(across))
        # Drawn together farther, the outermost rings would no longer reach the region's edge.
        least = min(1.0, (width - band.width_mm) / (width * (1.0 - 1.0 / stripe_count(width, pitch))))
        spread = site.cache.take(
            ("spread", spec, site.nozzle, site.limits),
            lambda: choose_spread(lambda spread: strokes_of(rows_at(spread)), least, site, travel),
        )
        rows = rows_at(spread)
    return rows[::-1] if spec.start == "last" else rows, findings


def orifice_line(line: Points2, band: Swath, travel: Directions2) -> Points2:
    """Line of the orifice that serves a line: back by what the jet reaches ahead, aside by what it is off centre."""
    left = np.array([-travel[1], travel[0]])
    return line - band.aim_mm * travel - (band.left_mm + band.right_mm) / 2 * left


def _region(spec: Raster | FinalFlush | StepFunction, site: Site) -> tuple[Polygon | MultiPolygon, tuple[Finding, ...]]:
    """Board outline less the margin; a margin that leaves nothing is halved until something is left."""
    outline = site.board.outline
    margin = spec.margin_mm
    for _ in range(8):
        region = outline.buffer(-margin, join_style="mitre", mitre_limit=5.0)
        if not region.is_empty:
            break
        margin /= 2
    else:
        region, margin = outline, 0.0
    if margin == spec.margin_mm:
        return region, ()
    message = f"A margin of {spec.margin_mm:g} mm leaves nothing of this board; {margin:.2g} mm is used."
    return region, (Finding(MARGIN_REDUCED, message, site.made_by),)


def one_way_lines(spec: FinalFlush | StepFunction, site: Site) -> StrokeSet:
    """Lines across the board, all in the same direction; a flush may pause at their ends."""
    travel = travel_of(spec, site)
    band = swath(site, height_of(spec), spec.tilt_deg, spec.toward, travel)
    delay = spec.edge_delay_s if isinstance(spec, FinalFlush) else 0.0

    def strokes_of(rows: list[Stripe]) -> tuple[Stroke, ...]:
        return tuple(
            line_stroke(orifice_line(line, band, travel), spec, site, travel, delay)
            for row in rows
            for line in row.stretches
        )

    rows, findings = lay_lines(spec, site, travel, strokes_of)
    strokes = strokes_of(rows)
    freedom = "either_end" if spec.start == "auto" else "fixed"
    return StrokeSet(strokes * spec.repeats, freedom, "everything", findings)


def line_stroke(
    ends: Points2, spec: FinalFlush | StepFunction | StraightLine, site: Site, travel: Directions2, delay_s: float
) -> Stroke:
    """Stroke along one line of the orifice, with a pause at its end."""
    approach, azimuth = pose_of(site, travel, spec.tilt_deg, spec.toward)
    ends = run_on(ends, travel, spec.overshoot_mm)
    return Stroke(
        tcp=np.column_stack([ends, np.full(2, height_of(spec))]),
        approach=np.tile(approach, (2, 1)),
        azimuth=np.tile(azimuth, (2, 1)),
        delays=np.array([0.0, delay_s]),
        speed_mm_s=spec.speed_mm_s,
        made_by=site.made_by,
        lead_in_mm=spec.lead_in_mm,
    )


def run_on(line: Points2, travel: Directions2, overshoot_mm: float) -> Points2:
    """Lengthen a line at both ends."""
    return line + np.outer([-overshoot_mm, overshoot_mm], travel)
