"""What the rules require of a gap, in numbers: whether each limit is kept, and how far from it the gap is."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from cleaning.parameters.model import Parameters
from cleaning.process.stages import Stage
from cleaning.undersides.residue import GapResult
from cleaning.verdicts import rules
from cleaning.verdicts.rules import Rule

_DRY_PA = -1.0
"""What a gap lacks whose edges nothing reaches."""


class GapNumbers(NamedTuple):
    """The numbers of one gap after all stages that rules judge."""

    residue: float
    """Share that is left, on average, ..."""
    worst: float
    """... and in the worst tenth."""
    washed: float
    """Renewals of the liquid in washing."""
    rinsed: float
    """Renewals in rinsing, as often as that may be repeated; no number where nothing rinses."""
    margin_pa: float
    """Of the pressure that opens the gap; below 0 it stays dry."""
    weak_share: float
    """Share that no wash flushes."""

    @classmethod
    def of(cls, gap: GapResult, stages: Sequence[Stage]) -> "GapNumbers":
        """Collect the numbers of a gap in the stages of its report."""
        acts = [(stage, at) for stage, at in zip(stages, gap.stages, strict=True) if at is not None]
        washes = [at for stage, at in acts if stage.use == "wash"]
        rinses = [stage.repeats * at.exchanges for stage, at in acts if stage.use == "rinse"]
        return cls(
            residue=gap.residue,
            worst=gap.residue_worst,
            washed=sum(at.exchanges for at in washes),
            rinsed=sum(rinses) if rinses else math.nan,
            margin_pa=max((at.margin_pa if at.entered else min(at.margin_pa, _DRY_PA) for at in washes), default=0.0),
            weak_share=min((at.weak_share for at in washes), default=0.0),
        )


class Criterion(NamedTuple):
    """What one rule requires of a gap."""

    rule: Rule
    kept: bool
    room: float | None = None
    """How many times the gap is on the good side of the limit; ``None`` where the rule's judgement has the numbers."""


def criteria_of(numbers: GapNumbers, fill: float, needed: float, parameters: Parameters) -> tuple[Criterion, ...]:
    """List what the rules require of a gap that a wash acts on, in the order in which they decide.

    Args:
        numbers: Of the gap.
        fill: Share of its height that residue fills before the wash.
        needed: Renewals that can carry the residue away.
        parameters: Have the limits.
    """
    limits, weak, rinsed = parameters.limits, numbers.weak_share, numbers.rinsed
    return (
        Criterion(rules.DRY_GAP, numbers.margin_pa >= 0.0),
        Criterion(rules.PLUGGED_GAP, fill < parameters.gap.plugged),
        Criterion(rules.NOT_FLUSHED, numbers.washed >= needed, numbers.washed / needed if needed > 0.0 else None),
        Criterion(rules.ONE_SIDED, weak <= limits.weak_share, limits.weak_share / weak if weak > 0.0 else math.inf),
        Criterion(rules.RESIDUE_LEFT, numbers.residue <= limits.gap_marginal and numbers.worst <= limits.pocket),
        Criterion(
            rules.INCOMPLETE_RINSE,
            not rinsed < limits.exchanges,
            None if math.isnan(rinsed) else rinsed / limits.exchanges,
        ),
    )
