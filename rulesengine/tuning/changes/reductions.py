"""Reductions that save time (faster, fewer, shorter, or a path less), and how far the slack lets each go."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from cleaning.verdicts import rules
from rulesengine.tuning.changes.candidate_changes import (
    AMOUNT_RULES,
    is_unreached,
    steps_for,
    template_share,
    variables_of,
)
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import AllowedChanges
from rulesengine.tuning.trial.requirements import UnmetRequirement
from rulesengine.tuning.variables import ChangeKind, DesignVariable, Edits
from specs.yaml.located import YamlPath, spell_path

_SAVING: frozenset[ChangeKind] = frozenset({"speeds", "passes", "dwells", "wash_time"})
_FASTER = 4.0
"""A speed is raised by no more than this at once."""
_AMOUNT_RULES = AMOUNT_RULES | {rules.IONIC_RESIDUE}
_LEAST_SHARE = 0.35
"""The least wetted places of a surface may get all they have from elsewhere."""
_NEGLIGIBLE = 0.02
"""Share of a component's liquid that it does not need."""


@dataclass(frozen=True, slots=True)
class Reduction:
    """One way to save time: a variable that moves towards ``end``, or a path that is left out."""

    name: str
    """The same from one recipe to the next."""
    end: float = 0.0
    variable: DesignVariable | None = None
    edits: Edits = ()
    """Of a path that is left out."""
    steps: tuple[str, ...] = ()
    template: str = ""
    """Of which it takes something away; empty: of the whole steps."""

    @property
    def begin(self) -> float:
        """Present value of the variable."""
        return self.end if self.variable is None else self.variable.value

    @property
    def is_unknown(self) -> bool:
        """Whether no forecast knows what it does: of pauses, and of what concerns a part of the components or steps."""
        each = self.variable
        return each is not None and bool(each.kind == "dwells" or each.component_class or each.by_repeats)

    def value_at(self, share: float) -> float | None:
        """Value that saves a share of the time of the whole reduction; ``None`` where that is the present one."""
        if self.variable is None or share >= 1:
            return self.end
        begin = self.variable.value
        if self.variable.kind == "speeds":  # time goes with the inverse of speed
            value = self.variable.rounded(1.0 / (1.0 / begin + share * (1.0 / self.end - 1.0 / begin)))
        else:
            value = self.variable.rounded(begin + share * (self.end - begin))
        return None if value == begin else value

    def change_to(self, value: float) -> tuple[str, Edits]:
        """Description and edits of the change to a value."""
        if self.variable is None:
            return self.name, self.edits
        return self.variable.describe(value), self.variable.edit(value)

    def bisect(self, good: float, bad: float) -> float | None:
        """Value between one that is accepted and one that is not; ``None`` where there is none."""
        if self.variable is None:
            return None
        middle = (good * bad) ** 0.5 if self.variable.kind == "speeds" else 0.5 * (good + bad)
        value = self.variable.rounded(middle)
        return None if value in (good, bad) else value


def reductions(outcome: Outcome, initial: Mapping[YamlPath, float], allowed: AllowedChanges) -> dict[str, Reduction]:
    """List ways to save time by name.

    What acts in drying is made no shorter than its ``initial`` value: no rule requires a time of drying.
    """
    drying = frozenset(step.made_by for step in outcome.steps if step.use == "dry")
    found: dict[str, Reduction] = {}
    for variable in variables_of(outcome):
        if variable.kind not in _SAVING or not allowed.permits(variable.kind, ((variable.path, None),)):
            continue
        if variable.kind == "speeds":
            end = variable.rounded(min(variable.upper, _FASTER * variable.value))
        else:
            end = max(variable.lower, 0.0 if variable.component_class or variable.kind == "dwells" else 1.0)
        if drying & frozenset(variable.steps):
            first = initial.get(variable.path, initial.get(variable.path[:-1], variable.value))
            end = min(end, first) if variable.kind == "speeds" else max(end, first)
        if variable.direction * (variable.value - end) > 0:
            name = f"{spell_path(variable.path)} {variable.component_class}"
            found[name] = Reduction(name, end, variable, steps=variable.steps, template=variable.template)
    return found | {each.name: each for each in _omitted_paths(outcome, drying, allowed)}


def _omitted_paths(outcome: Outcome, drying: frozenset[str], allowed: AllowedChanges) -> Iterator[Reduction]:
    for at, step in enumerate(outcome.recipe.sequence):
        path: YamlPath = ("sequence", at, "paths")
        made_by = f"sequence[{at}]"
        if not step.enabled or made_by in drying or len(step.paths) < 2:
            continue
        for place, name in enumerate(step.paths):
            edits: Edits = ((path, [*step.paths[:place], *step.paths[place + 1 :]]),)
            if allowed.permits("passes", edits):
                yield Reduction(f"{spell_path(path)}: - {name}", edits=edits, steps=(made_by,), template=name)


def acceptable_share(outcome: Outcome, reduction: Reduction, saved_s: float) -> float:
    """Estimate the share of a reduction, which saves ``saved_s`` in all, that keeps the requirements met, 0 to 1."""
    shares: list[float] = []
    for each in (*outcome.attainable, *outcome.met):
        steps = steps_for(each, outcome)
        if each.rule not in _AMOUNT_RULES or not steps & frozenset(reduction.steps):
            continue
        taken = template_share(each.component, reduction.template, steps, outcome)
        if isinstance(each, UnmetRequirement):  # nothing is taken away from what has too little of it already
            if not is_unreached(each) and (each.rule == rules.RESIDUE_LEFT or taken > _NEGLIGIBLE):
                return 0.0
        elif each.rule == rules.RESIDUE_LEFT:
            shares.append(each.slack * outcome.seconds_in(steps) / saved_s if saved_s > 0 else 1.0)
        else:
            shares.append(max(each.slack / taken if taken > 0 else 1.0, _LEAST_SHARE))
    return min(shares, default=1.0)
