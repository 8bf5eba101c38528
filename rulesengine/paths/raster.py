"""Raster: back and forth across the board."""

import numpy as np

from geometry.arrays import Directions2, Points2
from geometry.coverage.stripes import Stripe
from recipes.paths import Raster, height_of
from rulesengine.paths.parallel_lines import lay_lines, orifice_line, pose_of, run_on, swath, travel_of
from rulesengine.strokes.stroke import Site, Stroke, StrokeSet


def plan_raster(spec: Raster, site: Site) -> StrokeSet:
    """Lay stripes across the board and join them back and forth.

    Where the board's shape breaks no stripe the whole raster is one stroke, the jet on from line to line along the
    edge. Where it does, each stretch is a stroke of its own and their order is free.
    """
    travel = travel_of(spec, site)
    rows, findings = lay_lines(spec, site, travel, lambda rows: _strokes(rows, spec, site, travel))
    strokes = _strokes(rows, spec, site, travel)
    freedom = "free" if _broken(rows) else "fixed"
    return StrokeSet(strokes * spec.repeats, freedom, findings=findings)


def _broken(rows: list[Stripe]) -> bool:
    return any(len(row.stretches) > 1 for row in rows)


def _strokes(rows: list[Stripe], spec: Raster, site: Site, travel: Directions2) -> tuple[Stroke, ...]:
    if _broken(rows):
        return tuple(_joined([Stripe((line,))], spec, site, travel) for row in rows for line in row.stretches)
    return (_joined(rows, spec, site, travel),)


def _joined(rows: list[Stripe], spec: Raster, site: Site, travel: Directions2) -> Stroke:
    points: list[Points2] = []
    travels: list[Directions2] = []
    for index, row in enumerate(rows):
        way = travel if index % 2 == 0 else -travel
        line = row.stretches[0] if index % 2 == 0 else row.stretches[0][::-1]
        band = swath(site, height_of(spec), spec.tilt_deg, spec.toward, way)
        points.append(run_on(orifice_line(line, band, way), way, spec.overshoot_mm))
        travels += [way, way]
    poses = [pose_of(site, way, spec.tilt_deg, spec.toward) for way in travels]
    plan_view = np.concatenate(points)
    # Turned around, the jet would lean the wrong way and the pauses would fall on the wrong ends.
    turnable = spec.start == "auto" and spec.tilt_deg == 0 and spec.edge_delay_s == 0
    return Stroke(
        tcp=np.column_stack([plan_view, np.full(len(plan_view), height_of(spec))]),
        approach=np.array([pose[0] for pose in poses]),
        azimuth=np.array([site.azimuths(travel[None])[0]] * len(poses)),
        delays=np.tile([0.0, spec.edge_delay_s], len(rows)),
        speed_mm_s=spec.speed_mm_s,
        made_by=site.made_by,
        sense="either" if turnable else "fixed",
        lead_in_mm=spec.lead_in_mm,
    )
