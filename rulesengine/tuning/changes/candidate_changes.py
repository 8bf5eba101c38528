"""Candidate changes for requirements that are not met, each with its expected gain: other values, and new paths.

The expected effect is a heuristic that orders trials; analyses decide. Each kind of change has one on each rule; where
it is 0 the change is not tried.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Any, TypeAlias

from cleaning.verdicts import rules
from recipes.consistency import half_spread_deg
from recipes.paths import BoardPerimeter, ComponentPerimeter, PathSpec, Raster
from recipes.recipe import Recipe, Step
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import AllowedChanges
from rulesengine.tuning.trial.requirements import BOARD, PROCESS, Key, Requirement, UnmetRequirement
from rulesengine.tuning.variables import ChangeKind, DesignVariable, Edits, design_variables, enabled_steps
from specs.source import Source
from specs.yaml.located import YamlPath, spell_path

_USE = {
    **dict.fromkeys((rules.DRY_GAP, rules.NOT_FLUSHED, rules.RESIDUE_LEFT, rules.ONE_SIDED), "wash"),
    **{rules.INCOMPLETE_RINSE: "rinse", rules.IONIC_RESIDUE: "rinse", rules.WET_GAP: "dry"},
}
"""Rules that depend on the steps of one use, whatever step they name."""
AMOUNT_RULES = frozenset({rules.UNDER_EXPOSED, rules.NOT_FLUSHED, rules.RESIDUE_LEFT, rules.INCOMPLETE_RINSE})
_RULES = (
    rules.MISSED, rules.UNDER_EXPOSED, rules.DAMAGE_RISK, rules.DRY_GAP, rules.NOT_FLUSHED, rules.RESIDUE_LEFT,
    rules.ONE_SIDED, rules.INCOMPLETE_RINSE, rules.IONIC_RESIDUE, rules.WET_GAP, rules.PROCESS_WINDOW,
)  # fmt: skip
_EFFECT_BY_RULE: dict[ChangeKind, tuple[float, ...]] = {
    "speeds":      (0.20, 1.0, 0.0, 0.0, 0.8, 0.8, 0.1, 0.9, 0.8, 0.0, 0.0),
    "passes":      (0.30, 0.8, 0.0, 0.0, 1.0, 0.9, 0.2, 1.0, 0.8, 0.0, 0.0),
    "dwells":      (0.10, 0.5, 0.0, 0.1, 1.0, 0.9, 0.1, 0.9, 0.8, 0.0, 0.0),
    "wash_time":   (0.10, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0),
    "tilts":       (0.15, 0.1, 0.0, 0.2, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0),
    "heights":     (0.00, 0.0, 1.0, 0.9, 0.2, 0.1, 0.4, 0.2, 0.0, 1.0, 0.0),
    "sides":       (0.90, 0.7, 0.0, 0.6, 0.7, 0.5, 0.9, 0.8, 0.5, 0.0, 0.0),
    "pressure":    (0.00, 0.0, 1.0, 1.0, 0.7, 0.5, 0.6, 0.5, 0.0, 0.8, 0.0),
    "temperature": (0.00, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0),
}  # fmt: skip
_EFFECT = {kind: dict(zip(_RULES, effects, strict=True)) for kind, effects in _EFFECT_BY_RULE.items()}
_WHOLE_STEP: frozenset[ChangeKind] = frozenset({"wash_time", "pressure", "temperature"})
_LEAST_SHARE = 0.2
"""Weight of a template that hardly sprays the component."""
_MOST_FACTOR = 4.0
"""No number changes by more than this at once."""
_LEAST_FACTOR = 1.25
"""Nor by less, so that the last percents do not take many steps: what is too much is taken away again."""
_USUAL_FACTOR = 1.5
_NEARLY_ALL = 0.99
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
_NEARER = 0.8
_HARDER = 1.25
_WARMER_C = 5.0
_TILT_STEP_DEG = 10.0
_LEAST_DWELL_S = 0.3
_TAKES_TIME: frozenset[ChangeKind] = frozenset({"speeds", "passes", "dwells", "wash_time"})


@dataclass(frozen=True, slots=True)
class Change:
    """One change of a recipe, with its expected gain."""

    kind: ChangeKind
    what: str
    """Such as ``"templates.sweep.speed_mm_s: 60 -> 40"``."""
    edits: Edits
    gain: float
    """Shortfall that it is expected to remove, however long it takes."""
    group: tuple[str, str]
    """Changes of one group share their confidence."""
    steps: tuple[str, ...]
    """Where it acts; empty: on the whole sequence."""
    gain_by_time: float = 0.0
    """Shortfall that only time removes: all of it if the program becomes ``time_s`` longer, in part before."""
    time_s: float = 0.0
    targets: frozenset[Key] = frozenset()
    """Requirements that it is expected to improve."""

    @property
    def most_gain(self) -> float:
        """Expected gain if it takes long enough."""
        return self.gain + self.gain_by_time

    def gain_in(self, seconds: float) -> float:
        """Expected gain if it makes the program so much longer."""
        share = min(1.0, max(0.0, seconds) / self.time_s) if self.time_s > 0 else 0.0
        return self.gain + self.gain_by_time * share


def rule_effect(kind: ChangeKind, unmet: UnmetRequirement) -> float:
    """Expected effect of a kind of change; where no liquid arrives, more of the same does not help."""
    return _EFFECT[kind].get(rules.MISSED if is_unreached(unmet) else unmet.rule, 0.0)


def is_unreached(unmet: UnmetRequirement) -> bool:
    """Whether the least wetted places get nothing, which no longer spraying changes."""
    return unmet.rule == rules.UNDER_EXPOSED and unmet.deficit > _NEARLY_ALL


def time_factor(unmet: UnmetRequirement) -> float:
    """Estimate how many times as long the spraying must be: amounts grow with it, residue falls exponentially."""
    if unmet.rule in AMOUNT_RULES and not is_unreached(unmet):
        return min(_MOST_FACTOR, max(_LEAST_FACTOR, 1.0 / max(1.0 - unmet.deficit, 1e-3)))
    return _USUAL_FACTOR


def steps_for(requirement: Requirement, outcome: Outcome) -> frozenset[str]:
    """Steps on the component's side that a requirement depends on."""
    rule, uses = requirement.rule, ("wash", "rinse")
    if rule in _USE:
        uses = (_USE[rule],)
    elif use := outcome.use_of(str(requirement.judgement.stage)):
        uses = (use,)
    side = outcome.sides.get(requirement.component)
    steps = enabled_steps(outcome.recipe)
    return frozenset(
        made_by for made_by, step in steps if (side is None or step.side == side) and outcome.use_of(made_by) in uses
    )


def expected_share(variable: DesignVariable, unmet: UnmetRequirement, outcome: Outcome) -> float:
    """Estimate the share of a requirement's weight that a variable can remove, by rule, class and spraying template."""
    steps = steps_for(unmet, outcome)
    share = rule_effect(variable.kind, unmet)
    if not steps & frozenset(variable.steps) or (unmet.component == PROCESS and variable.kind != "temperature"):
        return 0.0
    if variable.component_class and outcome.classes.get(unmet.component) != variable.component_class:
        return 0.0
    if not share or variable.kind in _WHOLE_STEP:
        return share
    of_template = template_share(unmet.component, variable.template, steps, outcome)
    return share * (_LEAST_SHARE + (1.0 - _LEAST_SHARE) * of_template)


def template_share(component: str, template: str, steps: frozenset[str], outcome: Outcome) -> float:
    """Share of the liquid of some steps on a component that comes from one template."""
    of_steps, of_template = 0.0, 0.0
    for made_by, share in outcome.makers.get(component, ()):
        if str(Source(made_by.step)) in steps:
            of_steps += share
            of_template += share * (made_by.template == template)
    return of_template / of_steps if of_steps > 0 else 0.0


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


def candidate_changes(
    outcome: Outcome, unmet: Sequence[UnmetRequirement], allowed: AllowedChanges
) -> tuple[Change, ...]:
    """List allowed changes for some requirements, the highest expected gain first; equals in the recipe's order."""
    found = [change for variable in variables_of(outcome) for change in _changes_of(variable, outcome, unmet)]
    found += new_paths(outcome, unmet)
    permitted = [change for change in found if allowed.permits(change.kind, change.edits)]
    return tuple(sorted(permitted, key=lambda change: -round(change.most_gain, 6)))


def variables_of(outcome: Outcome) -> tuple[DesignVariable, ...]:
    """List the design variables of an outcome's recipe."""
    windows = {step.function: step.window_c for step in outcome.steps if step.window_c is not None}
    classes = frozenset(name for part, name in outcome.classes.items() if part not in outcome.excluded)
    return design_variables(outcome.recipe, classes, windows)


def _changes_of(variable: DesignVariable, outcome: Outcome, unmet: Sequence[UnmetRequirement]) -> Iterator[Change]:
    shares = [(each, share) for each in unmet if (share := expected_share(variable, each, outcome)) > 0]
    damaged = [each for each in shares if each[0].rule == rules.DAMAGE_RISK]
    other = [each for each in shares if each[0].rule != rules.DAMAGE_RISK]
    if damaged:  # the impact is too hard: farther away, or with less pressure
        gentler = variable.value / (_NEARER if variable.kind == "heights" else _HARDER)
        yield from _change_to(variable, gentler, damaged, 0.0)
    if other:
        # How much longer washing would have to be for the residue to be removed by time alone.
        time_s = max(
            (time_factor(each) - 1.0) * outcome.seconds_in(steps_for(each, outcome))
            if each.rule == rules.RESIDUE_LEFT
            else 0.0
            for each, _ in other
        )
        for value in _trial_values(variable, other):
            yield from _change_to(variable, value, other, time_s)


def _change_to(
    variable: DesignVariable, value: float, shares: list[tuple[UnmetRequirement, float]], time_s: float
) -> Iterator[Change]:
    new = variable.rounded(value)
    if new == variable.value:
        return
    by_time = variable.kind in _TAKES_TIME and time_s > 0
    gain_by_time = sum(each.weight * share for each, share in shares if by_time and each.rule == rules.RESIDUE_LEFT)
    yield Change(
        variable.kind,
        variable.describe(new),
        variable.edit(new),
        sum(each.weight * share for each, share in shares) - gain_by_time,
        (variable.kind, f"{variable.template or spell_path(variable.path)} {variable.component_class}"),
        variable.steps,
        gain_by_time,
        time_s,
        frozenset(each.key for each, _ in shares),
    )


def _trial_values(variable: DesignVariable, shares: list[tuple[UnmetRequirement, float]]) -> list[float]:
    """Values to try: one, or for a tilt one on either side."""
    value, factor = variable.value, max(time_factor(each) for each, _ in shares)
    match variable.kind:
        case "speeds":
            return [value / factor]
        case "passes" | "wash_time":
            return [float(max(value + 1, ceil(value * factor - 0.25)))]
        case "dwells":
            return [max(value * factor, value + _LEAST_DWELL_S)]
        case "tilts":
            return [value + _TILT_STEP_DEG, value - _TILT_STEP_DEG]
        case "heights":
            return [value * _NEARER]
        case "pressure":
            return [value * _HARDER]
        case "temperature":  # a limit that is broken, or a little more
            limits = [each.judgement.numbers[0].limit for each, _ in shares if each.rule == rules.PROCESS_WINDOW]
            return [next((limit for limit in limits if limit is not None), value + _WARMER_C)]
        case "sides":
            return []
