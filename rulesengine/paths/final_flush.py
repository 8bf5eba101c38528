"""Final flush: across the board in one direction, back with the jet off and above everything."""

from recipes.paths import FinalFlush
from rulesengine.paths.parallel_lines import one_way_lines
from rulesengine.strokes.stroke import Site, StrokeSet


def plan_final_flush(spec: FinalFlush, site: Site) -> StrokeSet:
    """Lay lines across the board, all in the same direction, in order from one side to the other."""
    return one_way_lines(spec, site)
