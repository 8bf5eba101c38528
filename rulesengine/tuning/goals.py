"""What a recipe is tuned for: which judgements are to go, and how far each still is from that."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isfinite, log
from typing import Literal, TypeAlias

from cleaning.results import CleaningReport, Judgement, Number, Part

Goal: TypeAlias = Literal["clean", "clean-and-dry"]
PROCESS = "process"
"""Stands for a component's name where the whole process is judged."""
_BEYOND = frozenset({"R14"})
"""Nothing can be said there, so nothing can be asked."""
_DRYING = frozenset({"R12"})
_EACH = 0.1
"""What one judgement weighs, however little is missing: the last few percent count as well."""
_LEAST_SHARE = 1e-9


@dataclass(frozen=True, slots=True)
class Want:
    """One judgement that is to go."""

    component: str
    judgement: Judgement
    deficit: float
    """From 0, where it just holds, to 1."""

    @property
    def weight(self) -> float:
        """What it adds to the shortfall."""
        return _EACH + self.deficit


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


def deficit(judgement: Judgement) -> float:
    """Say how far a judgement is from holding: 0 just holds, 1 is as far as can be."""
    limited = [number for number in judgement.numbers if number.limit is not None]
    if not limited:
        return min(1.0, judgement.numbers[0].value / 100.0) if judgement.rule == "R1" and judgement.numbers else 1.0
    return max(min(1.0, max(0.0, _short(judgement.rule, number))) for number in limited)


def _short(rule: str, number: Number) -> float:
    limit = 0.0 if number.limit is None else number.limit
    value = number.value if isfinite(number.value) else inf
    match rule:
        case "R1":
            return value / 100.0
        case "R2" | "R6" | "R10":
            return 1.0 - value / limit if limit > 0 else 0.0
        case "R3" | "R11" | "R12":
            return 1.0 - limit / value if value > 0 else 0.0
        case "R4":
            return -value / (100.0 - value) if value < 0 else 0.5
        case "R7":  # residue falls exponentially with time: its logarithm says how much of the time is there
            share = max(value / 100.0, _LEAST_SHARE)
            return 1.0 - log(share) / log(limit / 100.0) if 0 < limit < 100 else 0.0
        case "R8":
            return (value - limit) / max(100.0 - limit, 1.0)
        case _:
            return 1.0


def shortfall_of(wants: tuple[Want, ...]) -> float:
    """Add up what is missing, to compare two recipes by; 0 where nothing is."""
    return round(sum(want.weight for want in wants), 6)
