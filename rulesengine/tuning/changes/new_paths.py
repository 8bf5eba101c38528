"""Paths that a step does not have yet: around the components, around the rim, across in the other direction."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

from cleaning.verdicts.rules import MISSED, UNDER_EXPOSED
from recipes.consistency import half_spread_deg
from recipes.paths import BoardPerimeter, ComponentPerimeter, Raster
from recipes.recipe import Recipe, Step
from rulesengine.tuning.changes.change import Move
from rulesengine.tuning.changes.expected_effect import effect, steps_for
from rulesengine.tuning.trial.lower_bound import key_of
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import BOARD, Want
from rulesengine.tuning.variables.design_variables import enabled_steps
from specs.yaml.located import YamlPath

_HEIGHT_MM = 40.0
_SPEED_MM_S = 40.0
_ACROSS_TILT_DEG = 25.0
_RIM_TILT_DEG = 20.0
_RIM_OFFSET_MM = 5.0
_BEYOND_HALF_ANGLE_DEG = 5.0
_STEEPEST_DEG = 84.0
_ACROSS = 0.5


def added_paths(outcome: Outcome, wants: Sequence[Want]) -> Iterator[Move]:
    """Suggest new paths for functions that lack them, and steps for a side that is not sprayed."""
    functions = dict.fromkeys(step.function for _, step in enabled_steps(outcome.recipe))
    for function in functions:
        steps = _steps_of(function, outcome, wants)
        if steps:
            yield from _for_function(steps, outcome.recipe)
    yield from _other_side(outcome, wants)


@dataclass(frozen=True, slots=True)
class _Lacking:
    """A step, and what is wanting that it may help."""

    at: int
    step: Step
    wants: tuple[Want, ...]


def _steps_of(function: str, outcome: Outcome, wants: Sequence[Want]) -> list[_Lacking]:
    found: list[_Lacking] = []
    for at, step in enumerate(outcome.recipe.sequence):
        made_by = f"sequence[{at}]"
        if step.enabled and step.function == function and outcome.use_of(made_by) != "dry":
            helped = tuple(want for want in wants if made_by in steps_for(want, outcome))
            found += [_Lacking(at, step, helped)] if helped else []
    return found


def _for_function(steps: list[_Lacking], recipe: Recipe) -> Iterator[Move]:
    first = steps[0].step
    most = max(0.0, float(int(_STEEPEST_DEG - half_spread_deg(recipe.nozzles[first.nozzle]))))
    tilt = min(ceil(half_spread_deg(recipe.nozzles[first.nozzle])) + _BEYOND_HALF_ANGLE_DEG, most)
    speed = min(_SPEED_MM_S, recipe.functions[first.function].max_speed_mm_s)
    usual: dict[str, Any] = {"height_mm": max(_HEIGHT_MM, recipe.limits.clearance_mm + 1.0), "speed_mm_s": speed}
    around = {"path": "component_perimeter", **usual, "tilt_deg": tilt, "passes": 1}
    yield from _added("around", around, [each for each in steps if not _has_around(each.step, recipe)], recipe)
    way = {"direction_deg": "across_longest_edge", "tilt_deg": min(_ACROSS_TILT_DEG, most), "toward": "travel"}
    across = {"path": "raster", **usual, **way}
    yield from _added("across", across, [each for each in steps if not _has_across(each.step, recipe)], recipe)
    rim = {"path": "board_perimeter", **usual, "offset_mm": _RIM_OFFSET_MM, "tilt_deg": min(_RIM_TILT_DEG, most)}
    yield from _added("rim", rim, [each for each in steps if not _has_rim(each.step, recipe)], recipe)


def _has_around(step: Step, recipe: Recipe) -> bool:
    return any(isinstance(recipe.templates[name], ComponentPerimeter) for name in step.paths)


def _has_rim(step: Step, recipe: Recipe) -> bool:
    return any(isinstance(recipe.templates[name], BoardPerimeter) for name in step.paths)


def _has_across(step: Step, recipe: Recipe) -> bool:
    specs = [recipe.templates[name] for name in step.paths]
    return any(isinstance(spec, Raster) and spec.tilt_deg > 0 for spec in specs)


def _gain(word: str, want: Want) -> float:
    """A path around components is for them, one around the rim for the board; one across reaches surfaces."""
    rule, of_board = want.judgement.rule, want.component == BOARD
    if word == "across":
        return _ACROSS * want.weight if rule in (MISSED, UNDER_EXPOSED) else 0.0
    return want.weight * effect("sides", want) if of_board == (word == "rim") else 0.0


def _added(word: str, template: dict[str, Any], steps: list[_Lacking], recipe: Recipe) -> Iterator[Move]:
    gain = sum(_gain(word, want) for want in {id(want): want for each in steps for want in each.wants}.values())
    if not gain:
        return
    name = _name(f"{word}_{steps[0].step.function}", recipe, steps)
    edits: list[tuple[YamlPath, Any]] = [] if name in recipe.templates else [(("templates", name), template)]
    edits += [(("sequence", each.at, "paths"), [*each.step.paths, name]) for each in steps]
    where = ", ".join(f"sequence[{each.at}].paths" for each in steps)
    what = f"{where}: + {name} ({template['path']})"
    acts = tuple(f"sequence[{each.at}]" for each in steps)
    aims = frozenset(key_of(want) for each in steps for want in each.wants if _gain(word, want) > 0)
    yield Move("sides", what, tuple(edits), gain, ("sides", f"{word} {steps[0].step.function}"), acts, aims=aims)


def _name(wanted: str, recipe: Recipe, steps: list[_Lacking]) -> str:
    """Give a name that no template has, or that of one that was added to another step of this function before."""
    users = {step.function for _, step in enabled_steps(recipe) if wanted in step.paths}
    name, count = wanted, 2
    while name in recipe.templates and not (name == wanted and users == {steps[0].step.function}):
        name, count = f"{wanted}_{count}", count + 1
    return name


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
