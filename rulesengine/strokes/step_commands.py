"""Commands at the beginning of a step, what leaves the nozzle in it, and how fast it is moved."""

from collections.abc import Iterator

import numpy as np

from programs.plan import Command, Jet
from programs.program import TILT_BAND
from recipes.nozzles import AirKnife
from recipes.recipe import Recipe, Step
from specs.source import Source


def step_commands(recipe: Recipe, step: Step, made_by: Source) -> Iterator[Command]:
    """Commands at the beginning of a step."""
    function, nozzle = recipe.functions[step.function], recipe.nozzles[step.nozzle]
    yield Command("FUNCTION", (step.function,), made_by)
    yield Command("NOZZLE", (step.nozzle, "TOOL", str(nozzle.tool)), made_by)
    yield Command("SOLUTION", (function.solution,), made_by)
    yield Command("SET", ("pressure_bar", f"{function.pressure_bar:.3f}"), made_by)
    if function.temperature_c is not None:
        yield Command("SET", ("temperature_c", f"{function.temperature_c:.3f}"), made_by)
    if recipe.limits.tilt_band_deg > 0:
        yield Command("SET", (TILT_BAND, f"{recipe.limits.tilt_band_deg:.3f}"), made_by)


def repeat_commands(step: Step, made_by: Source) -> Iterator[Command]:
    """Commands that begin a loop which a sensor ends; none where the step has none."""
    if step.until is not None:
        limits = step.until.model_dump(exclude_none=True, exclude={"max_repeats"})
        for key, value in limits.items():
            yield Command("REPEAT", (str(step.until.max_repeats), "UNTIL", key, ">=", f"{value:.3f}"), made_by)


def jet_of(recipe: Recipe, step: Step) -> Jet:
    """What leaves the nozzle in a step, at the function's pressure."""
    function, nozzle = recipe.functions[step.function], recipe.nozzles[step.nozzle]
    kind = function.solution_kind or ("gas" if isinstance(nozzle, AirKnife) else "liquid")
    flow = nozzle.flow_lpm * float(np.sqrt(function.pressure_bar / nozzle.at_bar))
    return Jet(step.function, step.nozzle, function.solution, flow, kind == "liquid")


def transfer_speed(recipe: Recipe, step: Step) -> float:
    """Speed of transfers in a step, mm/s: the recipe's, but none above the function's."""
    return min(recipe.limits.transfer_speed_mm_s, recipe.functions[step.function].max_speed_mm_s)
