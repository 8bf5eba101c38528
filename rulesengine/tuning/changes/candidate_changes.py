"""Candidate changes for requirements that are not met, each with its expected gain."""

from collections.abc import Iterator, Sequence
from math import ceil

from cleaning.verdicts import rules
from rulesengine.tuning.changes.expected_effect import Change, expected_share, steps_for, time_factor
from rulesengine.tuning.changes.new_paths import new_paths
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import AllowedChanges
from rulesengine.tuning.trial.requirements import UnmetRequirement
from rulesengine.tuning.variables.design_variables import ChangeKind, DesignVariable, design_variables
from specs.yaml.located import spell_path

_NEARER = 0.8
_HARDER = 1.25
_WARMER_C = 5.0
_TILT_STEP_DEG = 10.0
_LEAST_DWELL_S = 0.3
_TAKES_TIME: frozenset[ChangeKind] = frozenset({"speeds", "passes", "dwells", "wash_time"})


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
