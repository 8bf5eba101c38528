"""How much turning one kind of knob is believed to help against each rule: good for an order of trials, no more.

What a change really does, the analysis says. 0 means that it is not tried.
"""

from cleaning.parameters.model import Use
from cleaning.verdicts.rules import (
    DAMAGE_RISK,
    DRY_GAP,
    INCOMPLETE_RINSE,
    IONIC_RESIDUE,
    MISSED,
    NOT_FLUSHED,
    ONE_SIDED,
    PROCESS_WINDOW,
    RESIDUE_LEFT,
    UNDER_EXPOSED,
    WET_GAP,
)
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import PROCESS, Spare, Want
from rulesengine.tuning.variables.design_variables import Kind, Knob, enabled_steps

_RULES = (
    MISSED, UNDER_EXPOSED, DAMAGE_RISK, DRY_GAP, NOT_FLUSHED, RESIDUE_LEFT, ONE_SIDED, INCOMPLETE_RINSE, IONIC_RESIDUE,
    WET_GAP, PROCESS_WINDOW,
)  # fmt: skip
_EFFECT_BY_RULE: dict[Kind, tuple[float, ...]] = {
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
_WASH_RULES = frozenset({DRY_GAP, NOT_FLUSHED, RESIDUE_LEFT, ONE_SIDED})
_RINSE_RULES = frozenset({INCOMPLETE_RINSE, IONIC_RESIDUE})
_OF_AMOUNT = frozenset({UNDER_EXPOSED, NOT_FLUSHED, RESIDUE_LEFT, INCOMPLETE_RINSE})
_WHOLE_STEP: frozenset[Kind] = frozenset({"wash_time", "pressure", "temperature"})
_UNSEEN = 0.2
"""Weight of a template that hardly sprays what is wanting."""
_MOST_NEED = 4.0
"""No number changes by more than this at once."""
_LEAST_NEED = 1.25
"""Nor by less, so that the last percents are not crept up on: what is too much is taken away again."""
_USUAL_NEED = 1.5
_NEARLY_ALL = 0.99


def effect(kind: Kind, want: Want) -> float:
    """Give the belief for a kind of knob and a rule; where nothing arrives, more of the same does not help."""
    return _EFFECT[kind].get(MISSED if arrives_nowhere(want) else want.judgement.rule, 0.0)


def arrives_nowhere(want: Want) -> bool:
    """Whether the places that get least get nothing, which is no matter of how much is sprayed."""
    return want.judgement.rule == UNDER_EXPOSED and want.deficit > _NEARLY_ALL


def need(want: Want) -> float:
    """Estimate how many times as long the spraying must be: amounts grow with it, residue falls exponentially."""
    if want.judgement.rule in (UNDER_EXPOSED, NOT_FLUSHED, RESIDUE_LEFT, INCOMPLETE_RINSE) and not arrives_nowhere(
        want
    ):
        return min(_MOST_NEED, max(_LEAST_NEED, 1.0 / max(1.0 - want.deficit, 1e-3)))
    return _USUAL_NEED


def steps_for(want: Want | Spare, outcome: Outcome) -> frozenset[str]:
    """Name the steps on the component's side that a judgement depends on."""
    uses = _uses(want, outcome)
    side = outcome.sides.get(want.component)
    steps = enabled_steps(outcome.recipe)
    return frozenset(
        made_by for made_by, step in steps if (side is None or step.side == side) and outcome.use_of(made_by) in uses
    )


def _uses(want: Want | Spare, outcome: Outcome) -> frozenset[Use]:
    rule = want.judgement.rule
    if rule in _WASH_RULES:
        return frozenset({"wash"})
    if rule in _RINSE_RULES:
        return frozenset({"rinse"})
    if rule == WET_GAP:
        return frozenset({"dry"})
    use = outcome.use_of(want.judgement.stage)
    return frozenset({"wash", "rinse"}) if use is None else frozenset({use})


def helps(knob: Knob, want: Want, outcome: Outcome) -> float:
    """Estimate which share of a want a knob can take away: by its rule, its class, and who sprays the component."""
    believed = effect(knob.kind, want)
    concerned = steps_for(want, outcome) & frozenset(knob.steps)
    if not believed or not concerned or (want.component == PROCESS and knob.kind != "temperature"):
        return 0.0
    if knob.of_class and outcome.classes.get(want.component) != knob.of_class:
        return 0.0
    if knob.kind in _WHOLE_STEP:
        return believed
    share = template_share(want.component, knob.template, steps_for(want, outcome), outcome)
    return believed * (_UNSEEN + (1.0 - _UNSEEN) * share)


def template_share(component: str, template: str, steps: frozenset[str], outcome: Outcome) -> float:
    """Give the share of what some steps spray on a component that comes from one template."""
    of_steps, of_template = 0.0, 0.0
    for made_by, share in outcome.makers.get(component, ()):
        step, _, rest = made_by.partition("/")
        if step in steps:
            of_steps += share
            of_template += share * (rest.split("/")[0] == template)
    return of_template / of_steps if of_steps > 0 else 0.0
