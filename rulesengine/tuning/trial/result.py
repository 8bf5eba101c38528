"""What came of tuning: each change with what it did, and what is still wanting."""

from dataclasses import dataclass

from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import Asked


@dataclass(frozen=True, slots=True)
class Figures:
    """What an outcome comes to."""

    held: int
    """Components that lack nothing."""
    wanting: int
    """Judgements that are to go."""
    worst_residue: float
    seconds: float
    litres: float


@dataclass(frozen=True, slots=True)
class Change:
    """One change, and what the analyses before and after it say."""

    what: tuple[str, ...]
    """Values from and to; several where they were made at once because they concern different steps."""
    before: Figures
    after: Figures


@dataclass(frozen=True, slots=True, eq=False)
class Tuned:
    """What came of tuning."""

    asked: Asked
    first: Outcome
    last: Outcome
    """Of the best recipe."""
    changes: tuple[Change, ...]
    used: int
    """Analyses that were made."""

    @property
    def within(self) -> bool:
        """Whether the limits are kept."""
        return self.asked.limits.excess(self.last.seconds, self.last.litres) == 0

    @property
    def spent(self) -> bool:
        """Whether tuning ended because no analysis was left."""
        return self.used >= self.asked.analyses


def figures_of(outcome: Outcome) -> Figures:
    """Sum an outcome up."""
    return Figures(
        outcome.held,
        len(outcome.wants),
        round(outcome.worst_residue, 6),
        outcome.seconds,
        outcome.litres,
    )
