"""Expected effect of changes on requirements: a heuristic that orders trials; analyses decide.

Each kind of change has an expected effect on each rule; 0 means that it is not tried.
"""

from dataclasses import dataclass

from cleaning.verdicts import rules
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import PROCESS, Key, Requirement, UnmetRequirement
from rulesengine.tuning.variables.design_variables import ChangeKind, DesignVariable, enabled_steps
from rulesengine.tuning.variables.recipe_edits import Edits
from specs.source import Source

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
