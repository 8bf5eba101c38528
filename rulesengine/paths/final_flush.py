"""Final flush: across the board in one direction, back with the jet off and above everything."""

from recipes.paths import FinalFlush
from rulesengine.paths.parallel_lines import lay_lines, one_way_stroke, travel_of
from rulesengine.strokes.stroke import Site, StrokeSet


def plan_final_flush(spec: FinalFlush, site: Site) -> StrokeSet:
    """Lay lines across the board, all in the same direction, in order from one side to the other."""
    travel = travel_of(spec, site)
    rows, findings = lay_lines(spec, site, travel)
    if spec.start == "last":
        rows.reverse()
    lines = [line for row in rows for line in row.stretches]
    strokes = tuple(one_way_stroke(line, spec, site, travel) for line in lines)
    freedom = "either_end" if spec.start == "auto" else "fixed"
    return StrokeSet(strokes * spec.repeats, freedom, "everything", findings)
