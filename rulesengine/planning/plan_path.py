"""The six planners behind one door."""

from typing import assert_never

from recipes.paths import (
    BoardPerimeter,
    ComponentPerimeter,
    FinalFlush,
    PathSpec,
    Raster,
    StepFunction,
    StraightLine,
)
from rulesengine.paths.board_perimeter import plan_board_perimeter
from rulesengine.paths.component_perimeter import plan_component_perimeter
from rulesengine.paths.final_flush import plan_final_flush
from rulesengine.paths.raster import plan_raster
from rulesengine.paths.step_function import plan_step_function
from rulesengine.paths.straight_line import plan_straight_line
from rulesengine.strokes.stroke import Site, StrokeSet


def plan_path(spec: PathSpec, site: Site) -> StrokeSet:
    """Turn one template into the strokes that carry it out on this board."""
    match spec:
        case BoardPerimeter():
            return plan_board_perimeter(spec, site)
        case Raster():
            return plan_raster(spec, site)
        case ComponentPerimeter():
            return plan_component_perimeter(spec, site)
        case FinalFlush():
            return plan_final_flush(spec, site)
        case StepFunction():
            return plan_step_function(spec, site)
        case StraightLine():
            return plan_straight_line(spec, site)
        case _:
            assert_never(spec)
