"""Acceptance of a shorter recipe: it must be as good as a reference."""

from dataclasses import dataclass

from cleaning.verdicts.rules import VERDICTS
from rulesengine.tuning.forecast.forecast import unattainable
from rulesengine.tuning.forecast.speed_curves import speed_curves, tunable_speeds
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import Key, UnmetRequirement, total_shortfall
from rulesengine.tuning.trial.trial_runner import TuningContext


@dataclass(frozen=True, slots=True, eq=False)
class Acceptance:
    """Acceptance test against a reference outcome."""

    reference: Outcome
    unattainable: frozenset[Key]
    """Requirements that no spraying time meets: they may lose something, but not their verdict."""

    def accepts(self, after: Outcome) -> bool:
        """Whether no more requirements are unmet than in the reference, in number and in all."""
        before, now = self._worst_verdicts(self.reference), self._worst_verdicts(after)
        if any(rank < before.get(name, rank) for name, rank in now.items()):
            return False
        unmet, reference = self._attainable(after), self._attainable(self.reference)
        return len(unmet) <= len(reference) and total_shortfall(unmet) <= total_shortfall(reference)

    def _worst_verdicts(self, outcome: Outcome) -> dict[str, int]:
        """Rank of the worst verdict on what is unattainable of each component; 0 is the worst."""
        found: dict[str, int] = {}
        for unmet in outcome.unmet:
            if unmet.key in self.unattainable:
                rank = VERDICTS.index(unmet.judgement.verdict)
                found[unmet.component] = min(rank, found.get(unmet.component, rank))
        return found

    def _attainable(self, outcome: Outcome) -> tuple[UnmetRequirement, ...]:
        return tuple(unmet for unmet in outcome.unmet if unmet.key not in self.unattainable)


def acceptance_of(context: TuningContext, reference: Outcome) -> Acceptance:
    """Acceptance test against an outcome."""
    curves = speed_curves(context.runner, reference.text, tunable_speeds(context, reference))
    longest = {name: curve.bounds[1] for name, curve in curves.items()}
    return Acceptance(reference, unattainable(reference, longest))
