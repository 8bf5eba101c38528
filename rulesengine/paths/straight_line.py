"""Straight line: one line between two points of the board."""

import numpy as np

from recipes.paths import StraightLine
from rulesengine.paths.parallel_lines import lean_of, line_stroke
from rulesengine.strokes.stroke import Site, Stroke, StrokeSet


def plan_straight_line(spec: StraightLine, site: Site) -> StrokeSet:
    """Lead the jet's axis along the line; repeats go back and forth."""
    line = np.array([spec.from_mm, spec.to_mm])
    strokes: list[Stroke] = []
    for index in range(spec.repeats):
        ends = line if index % 2 == 0 else line[::-1]
        travel = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        aim = spec.height_mm * np.tan(np.radians(spec.tilt_deg)) * lean_of(travel, spec.toward)
        strokes.append(line_stroke(ends - aim, spec, site, travel, spec.edge_delay_s))
    return StrokeSet(tuple(strokes), "fixed")
