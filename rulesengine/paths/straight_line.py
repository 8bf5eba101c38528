"""Straight line: one line between two points of the board."""

import numpy as np

from recipes.paths import StraightLine
from rulesengine.paths.parallel_lines import lean_of
from rulesengine.strokes.stroke import Site, Stroke, StrokeSet, tilted


def plan_straight_line(spec: StraightLine, site: Site) -> StrokeSet:
    """Lead the jet's axis along the line; repeats go back and forth."""
    line = np.array([spec.from_mm, spec.to_mm])
    strokes: list[Stroke] = []
    for index in range(spec.repeats):
        ends = line if index % 2 == 0 else line[::-1]
        travel = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        lean = lean_of(travel, spec.toward)
        orifice = ends - spec.height_mm * np.tan(np.radians(spec.tilt_deg)) * lean
        orifice = orifice + np.outer([-spec.overshoot_mm, spec.overshoot_mm], travel)
        strokes.append(
            Stroke(
                tcp=np.column_stack([orifice, np.full(2, spec.height_mm)]),
                approach=np.tile(tilted(lean[None], spec.tilt_deg), (2, 1)),
                azimuth=np.tile(site.azimuths(travel[None]), (2, 1)),
                delays=np.array([0.0, spec.edge_delay_s]),
                speed_mm_s=spec.speed_mm_s,
                made_by=site.made_by,
                lead_in_mm=spec.lead_in_mm,
            )
        )
    return StrokeSet(tuple(strokes), "fixed")
