"""Requirements of a tuned recipe: which judgements are not met, and how far each is from being met."""

from dataclasses import dataclass
from math import inf, isfinite, log
from typing import Literal, TypeAlias

from cleaning.verdicts import rules
from cleaning.verdicts.results import CleaningReport, Judgement, Number
from cleaning.verdicts.rules import Rule

Goal: TypeAlias = Literal["clean", "clean-and-dry"]
Key: TypeAlias = tuple[str, Rule, str]
"""Component, rule and step of a judgement; no step: all of its kind together."""
BOARD = "board"
"""Stands for a component's name where the bare board is meant."""
PROCESS = "process"
"""Stands for a component's name where the whole process is judged."""
_NO_VERDICT = frozenset({rules.MODEL_LIMIT})
_DRYING = frozenset({rules.WET_GAP})
_UNATTAINABLE = frozenset({rules.PLUGGED_GAP, rules.SPENT_BATH})
_FLOW = frozenset({rules.NOT_FLUSHED, rules.RESIDUE_LEFT, rules.ONE_SIDED, rules.INCOMPLETE_RINSE})
_BASE_WEIGHT = 0.1
"""Of one judgement, however little is missing: the last few percent count as well."""
_LEAST_SHARE = 1e-9
_NOTHING_HIT = 2.0


@dataclass(frozen=True, slots=True)
class Requirement:
    """One judgement on one component."""

    component: str
    judgement: Judgement

    @property
    def key(self) -> Key:
        """Identifies it from one outcome to the next."""
        return self.component, self.rule, str(self.judgement.stage)

    @property
    def rule(self) -> Rule:
        """Rule of the judgement."""
        return self.judgement.rule


@dataclass(frozen=True, slots=True)
class UnmetRequirement(Requirement):
    """One judgement that is not met yet."""

    deficit: float
    """From 0, where it is just met, to 1; to 2 where places are never hit, of which the rules require no more."""
    priority: float = 1.0
    """Lower where changes failed to improve it."""

    @property
    def weight(self) -> float:
        """Its part of the shortfall."""
        return self.priority * (_BASE_WEIGHT + self.deficit)


@dataclass(frozen=True, slots=True)
class MetRequirement(Requirement):
    """One judgement that is met, with its slack."""

    needed: float
    """Share of the present amount (R2) or time (R7) that it needs."""

    @property
    def slack(self) -> float:
        """Share of the present amount or time that it does not need."""
        return 1.0 - self.needed


def unmet_requirements(report: CleaningReport, goal: Goal, excluded: frozenset[str]) -> tuple[UnmetRequirement, ...]:
    """List the judgements that are not met, in the report's order: components, bare board, process.

    The goal ``clean`` ignores water under parts (R12); neither goal requires a verdict where the model has none (R14).
    """
    parts = [part for part in report.parts if part.component not in excluded]
    judged = [(part.component, each) for part in (*parts, report.bare) for each in part.judgements]
    judged += [(PROCESS, each) for each in report.process]
    ignored = _NO_VERDICT if goal == "clean-and-dry" else _NO_VERDICT | _DRYING
    return tuple(
        UnmetRequirement(component, each, deficit(each))
        for component, each in judged
        if each.verdict not in ("clean", "no verdict") and each.rule not in ignored
    )


def met_requirements(report: CleaningReport, excluded: frozenset[str]) -> tuple[MetRequirement, ...]:
    """List the judgements on amounts and times that are met, with what they need."""
    parts = [part for part in report.parts if part.component not in excluded]
    return tuple(
        MetRequirement(part.component, each, _needed(each))
        for part in (*parts, report.bare)
        for each in part.judgements
        if each.verdict == "clean" and each.rule in (rules.UNDER_EXPOSED, rules.RESIDUE_LEFT)
    )


def _needed(judgement: Judgement) -> float:
    shares = [0.0]
    for number in judgement.numbers:
        limit = number.limit or 0.0
        if judgement.rule == rules.UNDER_EXPOSED and number.value > 0:
            shares.append(limit / number.value)
        elif judgement.rule == rules.RESIDUE_LEFT and 0 < number.value < 100 and 0 < limit < 100:
            shares.append(log(limit / 100.0) / log(max(number.value / 100.0, _LEAST_SHARE)))
    return min(1.0, max(shares))


def deficit(judgement: Judgement) -> float:
    """How far a judgement is from being met: 0 just met, 1 as far as can be, more only where nothing is hit."""
    numbers = judgement.numbers
    if judgement.rule == rules.MISSED:
        # Where much is missed, amounts are not judged, so that it must count more than too small an amount.
        if not numbers:
            return _NOTHING_HIT
        share = numbers[0].value / 100.0
        return 1.0 + share if judgement.verdict == "dirty" else share
    if judgement.rule == rules.WET_GAP and len(numbers) > 1:
        # What blow-off lacks, the gap against the least that is blown clear, and what the warm time lacks.
        warm = (1.0 - (each.limit or 0.0) / each.value for each in numbers[2:])
        return min([1.0 - numbers[0].value / numbers[1].value, *warm])
    limited = [number for number in numbers if number.limit is not None]
    return max((min(1.0, max(0.0, _missing_share(judgement.rule, number))) for number in limited), default=1.0)


def _missing_share(rule: Rule, number: Number) -> float:
    limit = 0.0 if number.limit is None else number.limit
    value = number.value if isfinite(number.value) else inf
    match rule:
        case rules.UNDER_EXPOSED | rules.NOT_FLUSHED | rules.INCOMPLETE_RINSE:
            return 1.0 - value / limit if limit > 0 else 0.0
        case rules.DAMAGE_RISK | rules.IONIC_RESIDUE:
            return 1.0 - limit / value if value > 0 else 0.0
        case rules.DRY_GAP:
            return -value / (100.0 - value) if value < 0 else 0.5
        case rules.RESIDUE_LEFT:
            # It falls exponentially with time: its logarithm gives the share of the time.
            share = max(value / 100.0, _LEAST_SHARE)
            return 1.0 - log(share) / log(limit / 100.0) if 0 < limit < 100 else 0.0
        case rules.ONE_SIDED:
            return (value - limit) / max(100.0 - limit, 1.0)
        case _:
            return 1.0


def attainable(unmet: tuple[UnmetRequirement, ...]) -> tuple[UnmetRequirement, ...]:
    """Pick those that a recipe can meet: nothing of flow in a plugged gap, no spent bath."""
    plugged = {each.component for each in unmet if each.rule == rules.PLUGGED_GAP}
    return tuple(
        each
        for each in unmet
        if each.rule not in _UNATTAINABLE
        and not (each.component == PROCESS and each.rule == rules.INCOMPLETE_RINSE)
        and not (each.component in plugged and each.rule in _FLOW)
    )


def total_shortfall(unmet: tuple[UnmetRequirement, ...]) -> float:
    """Sum of the weights, to compare two recipes by; 0 where every requirement is met."""
    return round(sum(each.weight for each in unmet), 6)
