"""What a recipe is tuned for: which judgements are to go, and how far each still is from that."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isfinite, log
from typing import Literal, TypeAlias

from cleaning.verdicts import rules
from cleaning.verdicts.results import CleaningReport, Judgement, Number, Part
from cleaning.verdicts.rules import Rule

Goal: TypeAlias = Literal["clean", "clean-and-dry"]
BOARD = "board"
"""Stands for a component's name where the bare board is meant."""
PROCESS = "process"
"""Stands for a component's name where the whole process is judged."""
_BEYOND = frozenset({rules.MODEL_LIMIT})
"""Nothing can be said there, so nothing can be asked."""
_DRYING = frozenset({rules.WET_GAP})
_UNMENDABLE = frozenset({rules.PLUGGED_GAP, rules.SPENT_BATH})
_OF_FLOW = frozenset({rules.NOT_FLUSHED, rules.RESIDUE_LEFT, rules.ONE_SIDED, rules.INCOMPLETE_RINSE})
_EACH = 0.1
"""What one judgement weighs, however little is missing: the last few percent count as well."""
_LEAST_SHARE = 1e-9
_NOTHING_HIT = 2.0


@dataclass(frozen=True, slots=True)
class Want:
    """One judgement that is to go."""

    component: str
    judgement: Judgement
    deficit: float
    """From 0, where it just holds, to 1; to 2 where places are never hit, of which the rules ask no more."""
    hope: float = 1.0
    """Less where changes that were to help did not."""

    @property
    def weight(self) -> float:
        """What it adds to the shortfall."""
        return self.hope * (_EACH + self.deficit)


def wants_of(report: CleaningReport, goal: Goal, left_out: frozenset[str]) -> tuple[Want, ...]:
    """List the judgements that are to go, in the report's order: components, bare board, process.

    Args:
        report: An analysis.
        goal: ``clean`` leaves water under parts (R12) out; neither asks for a verdict where the model has none (R14).
        left_out: Components that masks take out.
    """
    asked = [part for part in report.parts if part.component not in left_out]
    found = list(_wanting([*asked, report.bare], goal))
    return (*found, *(Want(PROCESS, each, deficit(each)) for each in report.process if _counts(each, goal)))


def _wanting(parts: list[Part], goal: Goal) -> Iterator[Want]:
    for part in parts:
        yield from (Want(part.component, each, deficit(each)) for each in part.judgements if _counts(each, goal))


def _counts(judgement: Judgement, goal: Goal) -> bool:
    if judgement.verdict in ("clean", "no verdict") or judgement.rule in _BEYOND:
        return False
    return goal == "clean-and-dry" or judgement.rule not in _DRYING


@dataclass(frozen=True, slots=True)
class Spare:
    """A judgement that holds, and how much of the spraying it needs to."""

    component: str
    judgement: Judgement
    needed: float
    """Share of the present amount (R2) or time (R7)."""


def spares_of(report: CleaningReport, left_out: frozenset[str]) -> tuple[Spare, ...]:
    """List the judgements that hold and say by how much."""
    parts = [part for part in report.parts if part.component not in left_out]
    return tuple(
        Spare(part.component, each, _needed(each))
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
    """Say how far a judgement is from holding: 0 just holds, 1 is as far as can be, more only where nothing is hit."""
    numbers = judgement.numbers
    if judgement.rule == rules.MISSED:
        return _missed(judgement)
    if judgement.rule == rules.WET_GAP and len(numbers) > 1:
        return 1.0 - numbers[0].value / numbers[1].value  # the gap against the least that is blown clear
    limited = [number for number in numbers if number.limit is not None]
    return max((min(1.0, max(0.0, _short(judgement.rule, number))) for number in limited), default=1.0)


def _missed(judgement: Judgement) -> float:
    """Where much is missed, amounts are not judged, so that it must count more than too small an amount."""
    if not judgement.numbers:
        return _NOTHING_HIT
    share = judgement.numbers[0].value / 100.0
    return 1.0 + share if judgement.verdict == "dirty" else share


def _short(rule: Rule, number: Number) -> float:
    limit = 0.0 if number.limit is None else number.limit
    value = number.value if isfinite(number.value) else inf
    match rule:
        case rules.UNDER_EXPOSED | rules.NOT_FLUSHED | rules.INCOMPLETE_RINSE:
            return 1.0 - value / limit if limit > 0 else 0.0
        case rules.DAMAGE_RISK | rules.IONIC_RESIDUE:
            return 1.0 - limit / value if value > 0 else 0.0
        case rules.DRY_GAP:
            return -value / (100.0 - value) if value < 0 else 0.5
        case (
            rules.RESIDUE_LEFT
        ):  # residue falls exponentially with time: its logarithm says how much of the time is there
            share = max(value / 100.0, _LEAST_SHARE)
            return 1.0 - log(share) / log(limit / 100.0) if 0 < limit < 100 else 0.0
        case rules.ONE_SIDED:
            return (value - limit) / max(100.0 - limit, 1.0)
        case _:
            return 1.0


def mendable(wants: tuple[Want, ...]) -> tuple[Want, ...]:
    """Pick those that a recipe may take away: not a plugged gap with what is wanting in it, and not a spent bath."""
    plugged = {want.component for want in wants if want.judgement.rule == rules.PLUGGED_GAP}
    return tuple(want for want in wants if not _is_beyond(want, plugged))


def _is_beyond(want: Want, plugged: set[str]) -> bool:
    rule = want.judgement.rule
    if rule in _UNMENDABLE or (want.component == PROCESS and rule == rules.INCOMPLETE_RINSE):
        return True
    return want.component in plugged and rule in _OF_FLOW


def shortfall_of(wants: tuple[Want, ...]) -> float:
    """Add up what is missing, to compare two recipes by; 0 where nothing is."""
    return round(sum(want.weight for want in wants), 6)
