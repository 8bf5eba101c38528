"""Step function: across the board in one direction, pausing at each component edge to flush out what is left."""

from dataclasses import replace

import numpy as np
from shapely import LineString, STRtree, get_parts, intersection

from recipes.paths import StepFunction
from recipes.spec import for_class
from rulesengine.lines import lay_lines, one_way_stroke, travel_of
from rulesengine.stroke import Site, Stroke, StrokeSet

_GRAZE_MM = 0.05  # an outline touched over less than this is not crossed; outlines are no more exact than that


def plan_step_function(spec: StepFunction, site: Site) -> StrokeSet:
    """Lay lines like a final flush, with a pause at each edge of a component that the jet's axis crosses, in order."""
    travel = travel_of(spec, site)
    rows, findings = lay_lines(spec, site, travel)
    if spec.start == "last":
        rows.reverse()
    components = [component for component in site.board.components if component.name in site.served]
    names = [component.name for component in components]
    tree = STRtree([component.outline for component in components])
    lines = [one_way_stroke(line, spec, site, travel) for row in rows for line in row.stretches]
    strokes = tuple(_with_pauses(stroke, _crossings(stroke, tree, names), spec, site) for stroke in lines)
    freedom = "either_end" if spec.start == "auto" else "fixed"
    return StrokeSet(strokes * spec.repeats, freedom, "everything", findings)


def _crossings(stroke: Stroke, tree: STRtree, names: list[str]) -> list[tuple[float, str]]:
    """Distance along the stroke and name of the component for each edge that the axis crosses, in order."""
    axis = stroke.tcp[:, :2] - stroke.tcp[:, 2:] * stroke.approach[:, :2] / stroke.approach[:, 2:]
    segment = LineString(axis)
    length = segment.length
    travel = (axis[1] - axis[0]) / length
    found: list[tuple[float, int]] = []
    for index in sorted(int(i) for i in tree.query(segment, predicate="intersects")):
        for piece in get_parts(intersection(segment, tree.geometries[index])):
            spans = (np.array(piece.coords) - axis[0]) @ travel
            if np.ptp(spans) >= _GRAZE_MM:
                found += [(at, index) for at in (spans.min(), spans.max()) if _GRAZE_MM < at < length - _GRAZE_MM]
    found.sort(key=lambda crossing: (round(crossing[0], 4), crossing[1]))
    return [(float(at), names[index]) for at, index in found]


def _with_pauses(stroke: Stroke, crossings: list[tuple[float, str]], spec: StepFunction, site: Site) -> Stroke:
    if not crossings:
        return stroke
    direction = stroke.tcp[1] - stroke.tcp[0]
    direction /= np.linalg.norm(direction)
    at = np.array([distance for distance, _ in crossings])
    count = len(crossings) + 2
    delays = [for_class(spec.delay_s, site.classes[name]) for _, name in crossings]
    return replace(
        stroke,
        tcp=np.vstack([stroke.tcp[0], stroke.tcp[0] + np.outer(at, direction), stroke.tcp[1]]),
        approach=np.tile(stroke.approach[0], (count, 1)),
        azimuth=np.tile(stroke.azimuth[0], (count, 1)),
        delays=np.array([0.0, *delays, 0.0]),
        pauses=("", *(name for _, name in crossings), ""),
    )
