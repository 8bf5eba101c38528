"""Straight strokes across a board, shared by raster, final flush, step function and straight line."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from shapely import MultiPolygon, Polygon, get_coordinates

from geometry.arrays import Directions, Directions2, Points2
from geometry.coverage.stripes import Stripe, stripe_count, stripes
from recipes.footprint import core_footprint
from recipes.nozzles import HollowCone
from recipes.paths import FinalFlush, Raster, StepFunction, StraightLine, height_of
from rulesengine.paths.line_spread import MOST_LINES, choose_spread
from rulesengine.strokes.stroke import Site, Stroke, StrokeSet, reference_axes, tilted
from rulesengine.strokes.workload import require_lines
from specs.finding import Finding
from specs.finding_rules import MARGIN_REDUCED, PITCH_TOO_WIDE

Toward: TypeAlias = Literal["travel", "against_travel", "left", "right"]


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
            ("spread", *(each.model_dump_json() for each in (spec, site.nozzle, site.limits))),
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
