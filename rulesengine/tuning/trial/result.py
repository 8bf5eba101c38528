"""Result of tuning: each accepted change with its effect, and the outcomes before and after."""

from dataclasses import dataclass

from rulesengine.tuning.trial.outcome import Figures, Outcome
from rulesengine.tuning.trial.request import TuningRequest


@dataclass(frozen=True, slots=True)
class AcceptedChange:
    """One accepted change, with the figures of the analyses before and after it."""

    what: tuple[str, ...]
    """Values from and to; several where they were made at once because they concern different steps."""
    before: Figures
    after: Figures


@dataclass(frozen=True, slots=True, eq=False)
class TuningResult:
    """A request, the outcomes of the first and the best recipe, and the changes between them."""

    request: TuningRequest
    first: Outcome
    last: Outcome
    """Of the best recipe."""
    changes: tuple[AcceptedChange, ...]
    used: int
    """Analyses that were made."""

    @property
    def within_limits(self) -> bool:
        """Whether the limits are kept."""
        return self.request.limits.excess(self.last.seconds, self.last.litres) == 0

    @property
    def out_of_analyses(self) -> bool:
        """Whether tuning ended because no analysis was left."""
        return self.used >= self.request.max_analyses
