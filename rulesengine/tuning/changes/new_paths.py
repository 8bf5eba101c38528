"""Paths that a step does not have yet: around the components, around the rim, across in the other direction."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import ceil
from typing import Any, TypeAlias

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


_Steps: TypeAlias = dict[int, Step]
"""Steps of one function by their places in the sequence."""


def new_paths(outcome: Outcome, unmet: Sequence[UnmetRequirement]) -> Iterator[Change]:
    """Changes that add paths to the steps of a function, and steps for a side that is not sprayed."""
    for steps in _wet_steps(outcome):
        concerned = {at: [each for each in unmet if f"sequence[{at}]" in steps_for(each, outcome)] for at in steps}
        steps = {at: step for at, step in steps.items() if concerned[at]}
        for word, path in _templates(steps, outcome.recipe).items():
            lacking = {at: step for at, step in steps.items() if not _is_present(word, [step], outcome.recipe)}
            helped = {id(each): each for at in lacking for each in concerned[at] if _gain(word, each)}.values()
            if helped:
                gain, targets = sum(_gain(word, each) for each in helped), frozenset(each.key for each in helped)
                yield replace(_path_put(word, path, lacking, outcome.recipe), gain=gain, targets=targets)
    yield from _side_added(outcome, unmet)


def replaced_paths(outcome: Outcome, template: str) -> Iterator[Change]:
    """Changes that put another path in the place of a template, in all steps of a function that follow it.

    Args:
        outcome: Of the recipe as it is.
        template: Name of the template that is replaced.
    """
    for steps in _wet_steps(outcome):
        steps = {at: step for at, step in steps.items() if template in step.paths}
        for word, path in _templates(steps, outcome.recipe).items():
            if not _is_present(word, list(steps.values()), outcome.recipe):
                yield _path_put(word, path, steps, outcome.recipe, template)


def _wet_steps(outcome: Outcome) -> list[_Steps]:
    """Steps that spray a liquid, function by function."""
    found: dict[str, _Steps] = {}
    for at, step in enumerate(outcome.recipe.sequence):
        if step.enabled and outcome.use_of(f"sequence[{at}]") != "dry":
            found.setdefault(step.function, {})[at] = step
    return list(found.values())


def _is_present(word: str, steps: Sequence[Step], recipe: Recipe) -> bool:
    return any(_PRESENT[word](recipe.templates[name]) for step in steps for name in step.paths)


def _templates(steps: _Steps, recipe: Recipe) -> dict[str, dict[str, Any]]:
    """Templates of the paths that may be new to some steps, as the first of them needs them; none without a step."""
    if not steps:
        return {}
    step = next(iter(steps.values()))
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


def _path_put(word: str, path: dict[str, Any], steps: _Steps, recipe: Recipe, template: str = "") -> Change:
    """Put a path into steps, in the place of a template if one is named.

    Its name is one that no template has, or that of one added to another step of this function.
    """
    function = next(iter(steps.values())).function
    base, count = f"{word}_{function}", 2
    users = {step.function for _, step in enabled_steps(recipe) if base in step.paths}
    name = base
    while name in recipe.templates and not (name == base and users == {function}):
        name, count = f"{base}_{count}", count + 1
    edits: list[tuple[YamlPath, Any]] = [] if name in recipe.templates else [(("templates", name), path)]
    for at, step in steps.items():
        paths = [name if old == template else old for old in step.paths] if template else [*step.paths, name]
        edits.append((("sequence", at, "paths"), paths))
    where = ", ".join(f"sequence[{at}].paths" for at in steps)
    return Change(
        "sides",
        f"{where}: {f'{template} ->' if template else '+'} {name} ({path['path']})",
        tuple(edits),
        0.0,
        ("sides", f"{word} {function}"),
        tuple(f"sequence[{at}]" for at in steps),
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
