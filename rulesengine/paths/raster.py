"""Raster: back and forth across the board."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Directions, Directions2, Points2
from geometry.coverage.stripes import Stripe
from recipes.paths import Raster, height_of
from rulesengine.paths.parallel_lines import Swath, lay_lines, orifice_line, pose_of, run_on, swath, travel_of
from rulesengine.strokes.stroke import Site, Stroke, StrokeSet


@dataclass(frozen=True, slots=True, eq=False)
class _Way:
    """One of the two ways along the lines: its direction, what a line serves, and how the nozzle is held."""

    travel: Directions2
    """(2,)"""
    band: Swath
    approach: Directions
    """(3,) side frame"""


def plan_raster(spec: Raster, site: Site) -> StrokeSet:
    """Lay stripes across the board and join them back and forth.

    Where the board's shape breaks no stripe the whole raster is one stroke, the jet on from line to line along the
    edge. Where it does, each stretch is a stroke of its own and their order is free.
    """
    travel = travel_of(spec, site)
    how = spec.tilt_deg, spec.toward
    there, back = (
        _Way(each, swath(site, height_of(spec), *how, each), pose_of(site, each, *how)[0]) for each in (travel, -travel)
    )
    rows, findings = lay_lines(spec, site, travel, lambda rows: _strokes(rows, spec, site, (there, back)))
    strokes = _strokes(rows, spec, site, (there, back))
    freedom = "free" if _broken(rows) else "fixed"
    return StrokeSet(strokes * spec.repeats, freedom, findings=findings)


def _broken(rows: list[Stripe]) -> bool:
    return any(len(row.stretches) > 1 for row in rows)


def _strokes(rows: list[Stripe], spec: Raster, site: Site, ways: tuple[_Way, _Way]) -> tuple[Stroke, ...]:
    if _broken(rows):
        return tuple(_joined([Stripe((line,))], spec, site, ways) for row in rows for line in row.stretches)
    return (_joined(rows, spec, site, ways),)


def _joined(rows: list[Stripe], spec: Raster, site: Site, ways: tuple[_Way, _Way]) -> Stroke:
    points: list[Points2] = []
    approach: list[Directions] = []
    for index, row in enumerate(rows):
        way = ways[index % 2]
        line = row.stretches[0] if index % 2 == 0 else row.stretches[0][::-1]
        points.append(run_on(orifice_line(line, way.band, way.travel), way.travel, spec.overshoot_mm))
        approach += [way.approach, way.approach]
    plan_view = np.concatenate(points)
    # Turned around, the jet would lean the wrong way and the pauses would fall on the wrong ends.
    turnable = spec.start == "auto" and spec.tilt_deg == 0 and spec.edge_delay_s == 0
    return Stroke(
        tcp=np.column_stack([plan_view, np.full(len(plan_view), height_of(spec))]),
        approach=np.array(approach),
        azimuth=np.array([site.azimuths(ways[0].travel[None])[0]] * len(approach)),
        delays=np.tile([0.0, spec.edge_delay_s], len(rows)),
        speed_mm_s=spec.speed_mm_s,
        made_by=site.made_by,
        sense="either" if turnable else "fixed",
        lead_in_mm=spec.lead_in_mm,
    )
