"""Paths that a step does not have yet: around the components, around the rim, across in the other direction."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

from cleaning.verdicts import rules
from recipes.consistency import half_spread_deg
from recipes.paths import BoardPerimeter, ComponentPerimeter, PathSpec, Raster
from recipes.recipe import Recipe, Step
from rulesengine.tuning.changes.expected_effect import Change, rule_effect, steps_for
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import BOARD, UnmetRequirement
from rulesengine.tuning.variables.design_variables import enabled_steps
from specs.yaml.located import YamlPath

_HEIGHT_MM = 40.0
_SPEED_MM_S = 40.0
_ACROSS_TILT_DEG = 25.0
_RIM_TILT_DEG = 20.0
_RIM_OFFSET_MM = 5.0
_BEYOND_HALF_ANGLE_DEG = 5.0
_STEEPEST_DEG = 84.0
_ACROSS_EFFECT = 0.5
_PRESENT: dict[str, Callable[[PathSpec], bool]] = {
    "around": lambda spec: isinstance(spec, ComponentPerimeter),
    "across": lambda spec: isinstance(spec, Raster) and spec.tilt_deg > 0,
    "rim": lambda spec: isinstance(spec, BoardPerimeter),
}
"""What a step may already have of each new path."""


@dataclass(frozen=True, slots=True)
class _OpenStep:
    """A step, and the requirements that depend on it."""

    at: int
    step: Step
    unmet: tuple[UnmetRequirement, ...]


def new_paths(outcome: Outcome, unmet: Sequence[UnmetRequirement]) -> Iterator[Change]:
    """Changes that add paths to the steps of a function, and steps for a side that is not sprayed."""
    recipe = outcome.recipe
    for function in dict.fromkeys(step.function for _, step in enabled_steps(recipe)):
        steps: list[_OpenStep] = []
        for at, step in enumerate(recipe.sequence):
            made_by = f"sequence[{at}]"
            if step.enabled and step.function == function and outcome.use_of(made_by) != "dry":
                concerned = tuple(each for each in unmet if made_by in steps_for(each, outcome))
                steps += [_OpenStep(at, step, concerned)] if concerned else []
        if steps:
            for word, template in _templates(steps[0].step, recipe).items():
                lacking = [
                    each
                    for each in steps
                    if not any(_PRESENT[word](recipe.templates[name]) for name in each.step.paths)
                ]
                yield from _path_added(word, template, lacking, recipe)
    yield from _side_added(outcome, unmet)


def _templates(step: Step, recipe: Recipe) -> dict[str, dict[str, Any]]:
    spread = half_spread_deg(recipe.nozzles[step.nozzle])
    most = max(0.0, float(int(_STEEPEST_DEG - spread)))
    common = {
        "height_mm": max(_HEIGHT_MM, recipe.limits.clearance_mm + 1.0),
        "speed_mm_s": min(_SPEED_MM_S, recipe.functions[step.function].max_speed_mm_s),
    }
    tilt = min(ceil(spread) + _BEYOND_HALF_ANGLE_DEG, most)
    across = {"direction_deg": "across_longest_edge", "tilt_deg": min(_ACROSS_TILT_DEG, most), "toward": "travel"}
    rim = {"offset_mm": _RIM_OFFSET_MM, "tilt_deg": min(_RIM_TILT_DEG, most)}
    return {
        "around": {"path": "component_perimeter", **common, "tilt_deg": tilt, "passes": 1},
        "across": {"path": "raster", **common, **across},
        "rim": {"path": "board_perimeter", **common, **rim},
    }


def _gain(word: str, unmet: UnmetRequirement) -> float:
    """A path around components is for them, one around the rim for the board; one across reaches surfaces."""
    if word == "across":
        return _ACROSS_EFFECT * unmet.weight if unmet.rule in (rules.MISSED, rules.UNDER_EXPOSED) else 0.0
    return unmet.weight * rule_effect("sides", unmet) if (unmet.component == BOARD) == (word == "rim") else 0.0


def _path_added(word: str, template: dict[str, Any], steps: list[_OpenStep], recipe: Recipe) -> Iterator[Change]:
    gain = sum(_gain(word, each) for each in {id(each): each for open_ in steps for each in open_.unmet}.values())
    if not gain:
        return
    name, edits = _named(word, template, steps, recipe)
    edits += [(("sequence", each.at, "paths"), [*each.step.paths, name]) for each in steps]
    where = ", ".join(f"sequence[{each.at}].paths" for each in steps)
    yield Change(
        "sides",
        f"{where}: + {name} ({template['path']})",
        tuple(edits),
        gain,
        ("sides", f"{word} {steps[0].step.function}"),
        tuple(f"sequence[{each.at}]" for each in steps),
        targets=frozenset(each.key for open_ in steps for each in open_.unmet if _gain(word, each) > 0),
    )


def _named(
    word: str, template: dict[str, Any], steps: list[_OpenStep], recipe: Recipe
) -> tuple[str, list[tuple[YamlPath, Any]]]:
    """Give a name that no template has, or that of one added to another step of this function; and its edit."""
    function = steps[0].step.function
    base, count = f"{word}_{function}", 2
    users = {step.function for _, step in enabled_steps(recipe) if base in step.paths}
    name = base
    while name in recipe.templates and not (name == base and users == {function}):
        name, count = f"{base}_{count}", count + 1
    return name, [] if name in recipe.templates else [(("templates", name), template)]


def replaced_paths(outcome: Outcome, template: str) -> Iterator[Change]:
    """Changes that put another path in the place of a template, in all steps of a function that follow it.

    Args:
        outcome: Of the recipe as it is.
        template: Name of the template that is replaced.
    """
    recipe = outcome.recipe
    for function in dict.fromkeys(step.function for _, step in enabled_steps(recipe)):
        steps = [
            _OpenStep(at, step, ())
            for at, step in enumerate(recipe.sequence)
            if step.enabled and step.function == function and template in step.paths
        ]
        steps = [each for each in steps if outcome.use_of(f"sequence[{each.at}]") != "dry"]
        for word, path in _templates(steps[0].step, recipe).items() if steps else ():
            if any(_PRESENT[word](recipe.templates[name]) for each in steps for name in each.step.paths):
                continue
            name, edits = _named(word, path, steps, recipe)
            paths = {each.at: [name if old == template else old for old in each.step.paths] for each in steps}
            where = ", ".join(f"sequence[{at}].paths" for at in paths)
            yield Change(
                "sides",
                f"{where}: {template} -> {name} ({path['path']})",
                (*edits, *((("sequence", at, "paths"), names) for at, names in paths.items())),
                0.0,
                ("sides", f"{word} {function}"),
                tuple(f"sequence[{at}]" for at in paths),
            )


def _side_added(outcome: Outcome, unmet: Sequence[UnmetRequirement]) -> Iterator[Change]:
    """All steps again on a side that no liquid reaches; at the end, so that the board turns once.

    The bare board has no side of its own: what sprays the components of a side sprays it, too.
    """
    missing = [each for each in unmet if each.judgement.name == "not sprayed" and each.component in outcome.sides]
    for side in dict.fromkeys(outcome.sides[each.component] for each in missing):
        copies = [
            step.model_dump(mode="json", exclude_defaults=True) | {"side": side}
            for _, step in enabled_steps(outcome.recipe)
            if step.side != side
        ]
        if copies:
            stated = [step.model_dump(mode="json", exclude_defaults=True) for step in outcome.recipe.sequence]
            edits = ((("sequence",), [*stated, *copies]),)
            gain = sum(each.weight for each in missing if outcome.sides[each.component] == side)
            yield Change(
                "sides", f"sequence: + {len(copies)} steps with side: {side}", edits, gain, ("sides", side), ()
            )
