"""Step function: across the board in one direction, pausing at each component edge to flush out what is left."""

from dataclasses import replace

from recipes.paths import StepFunction, for_class
from rulesengine.paths.parallel_lines import one_way_lines
from rulesengine.strokes.stroke import Site, StrokeSet


def plan_step_function(spec: StepFunction, site: Site) -> StrokeSet:
    """Lay lines like a final flush, with a pause at each edge of a served component that the jet's axis crosses."""
    pauses = {name: for_class(spec.delay_s, site.classes[name]) for name in site.served}
    return replace(one_way_lines(spec, site), edge_pauses=pauses)
