"""Paths that a step does not have yet: around the components, around the rim, across in the other direction."""

from collections.abc import Iterator, Sequence
from math import ceil
from typing import Any

from recipes.consistency import half_spread_deg
from recipes.paths import BoardPerimeter, ComponentPerimeter, Raster
from recipes.recipe import Recipe, Step
from rulesengine.tuning.effects import effect, steps_for
from rulesengine.tuning.goals import Want
from rulesengine.tuning.knobs import enabled_steps
from rulesengine.tuning.move import Move
from rulesengine.tuning.outcome import Outcome

_HEIGHT_MM = 40.0
_SPEED_MM_S = 40.0
_ACROSS_TILT_DEG = 25.0
_RIM_TILT_DEG = 20.0
_RIM_OFFSET_MM = 5.0
_BEYOND_HALF_ANGLE_DEG = 5.0
_STEEPEST_DEG = 84.0
_BOARD = "board"


def added_paths(outcome: Outcome, wants: Sequence[Want]) -> Iterator[Move]:
    """Suggest new paths for steps that lack them, and steps for a side that is not sprayed."""
    for at, step in enumerate(outcome.recipe.sequence):
        made_by = f"sequence[{at}]"
        helped = [want for want in wants if step.enabled and made_by in steps_for(want, outcome)]
        if helped and outcome.use_of(made_by) != "dry":
            yield from _for_step(at, step, outcome.recipe, helped)
    yield from _other_side(outcome, wants)


def _for_step(at: int, step: Step, recipe: Recipe, helped: list[Want]) -> Iterator[Move]:
    specs = [recipe.templates[name] for name in step.paths]
    parts = sum(want.weight * effect("sides", want.judgement.rule) for want in helped if want.component != _BOARD)
    bare = sum(want.weight * effect("sides", want.judgement.rule) for want in helped if want.component == _BOARD)
    seen = sum(want.weight for want in helped if want.judgement.rule in ("R1", "R2"))
    tilt = min(ceil(half_spread_deg(recipe.nozzles[step.nozzle])) + _BEYOND_HALF_ANGLE_DEG, _most_tilt(recipe, step))
    speed = min(_SPEED_MM_S, recipe.functions[step.function].max_speed_mm_s)
    usual: dict[str, Any] = {"height_mm": _height(recipe), "speed_mm_s": speed}
    if parts and not any(isinstance(spec, ComponentPerimeter) for spec in specs):
        around = {"path": "component_perimeter", **usual, "tilt_deg": tilt, "passes": 1}
        yield _added("around", around, at, step, recipe, parts)
    if seen and not any(isinstance(spec, Raster) and spec.tilt_deg > 0 for spec in specs):
        lean = min(_ACROSS_TILT_DEG, _most_tilt(recipe, step))
        along = any(isinstance(spec, Raster) and spec.direction_deg in (0, "longest_edge") for spec in specs)
        way = "across_longest_edge" if along else "longest_edge"
        across = {"path": "raster", **usual, "direction_deg": way, "tilt_deg": lean, "toward": "travel"}
        yield _added("across", across, at, step, recipe, 0.6 * seen)
    if bare and not any(isinstance(spec, BoardPerimeter) for spec in specs):
        lean = min(_RIM_TILT_DEG, _most_tilt(recipe, step))
        rim = {"path": "board_perimeter", **usual, "offset_mm": _RIM_OFFSET_MM, "tilt_deg": lean, "toward": "inside"}
        yield _added("rim", rim, at, step, recipe, bare)


def _height(recipe: Recipe) -> float:
    return max(_HEIGHT_MM, recipe.limits.clearance_mm + 1.0)


def _most_tilt(recipe: Recipe, step: Step) -> float:
    return max(0.0, float(int(_STEEPEST_DEG - half_spread_deg(recipe.nozzles[step.nozzle]))))


def _added(word: str, template: dict[str, Any], at: int, step: Step, recipe: Recipe, gain: float) -> Move:
    name = _free(f"{word}_{step.function}", recipe)
    edits = ((("templates", name), template), (("sequence", at, "paths"), [*step.paths, name]))
    what = f"sequence[{at}].paths: + {name} ({template['path']})"
    return Move("sides", what, edits, gain, ("sides", f"{word}[{at}]"), (f"sequence[{at}]",))


def _free(name: str, recipe: Recipe) -> str:
    """Give a name that no template has."""
    if name not in recipe.templates:
        return name
    count = 2
    while f"{name}_{count}" in recipe.templates:
        count += 1
    return f"{name}_{count}"


def _other_side(outcome: Outcome, wants: Sequence[Want]) -> Iterator[Move]:
    """Do all steps again on a side that no liquid reaches; at the end, so that the board turns once."""
    missing = [want for want in wants if want.judgement.name == "not sprayed"]
    for side in dict.fromkeys(outcome.sides[want.component] for want in missing):
        other = "top" if side == "bottom" else "bottom"
        copies = [
            step.model_dump(mode="json", exclude_defaults=True) | {"side": side}
            for _, step in enabled_steps(outcome.recipe)
            if step.side == other
        ]
        if not copies:
            continue
        stated = [step.model_dump(mode="json", exclude_defaults=True) for step in outcome.recipe.sequence]
        edits = ((("sequence",), [*stated, *copies]),)
        gain = sum(want.weight for want in missing if outcome.sides[want.component] == side)
        yield Move("sides", f"sequence: + {len(copies)} steps with side: {side}", edits, gain, ("sides", side), ())
