"""Step function: across the board in one direction, pausing at each component edge to flush out what is left."""

from recipes.paths import StepFunction
from rulesengine.modifiers.pause_at_edges import edges_of, pause_at_edges
from rulesengine.paths.parallel_lines import lay_lines, one_way_stroke, travel_of
from rulesengine.strokes.stroke import Site, StrokeSet


def plan_step_function(spec: StepFunction, site: Site) -> StrokeSet:
    """Lay lines like a final flush, with a pause at each edge of a component that the jet's axis crosses, in order."""
    travel = travel_of(spec, site)
    rows, findings = lay_lines(spec, site, travel)
    if spec.start == "last":
        rows.reverse()
    edges = edges_of(spec, site)
    lines = [one_way_stroke(line, spec, site, travel) for row in rows for line in row.stretches]
    strokes = tuple(pause_at_edges(stroke, edges) for stroke in lines)
    freedom = "either_end" if spec.start == "auto" else "fixed"
    return StrokeSet(strokes * spec.repeats, freedom, "everything", findings)
