"""Acceptance of a recipe in the place of another one: nearer to the limits, cleaner, or shorter and as clean."""

from dataclasses import dataclass

from cleaning.verdicts.rules import VERDICTS
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import Cost, TuningRequest
from rulesengine.tuning.trial.requirements import Key, UnmetRequirement, total_shortfall

_LEAST_GAIN = 0.005
"""Share of the shortfall that is a gain."""


@dataclass(frozen=True, slots=True, eq=False)
class Acceptance:
    """Acceptance test against a reference outcome."""

    request: TuningRequest
    reference: Outcome
    unattainable: frozenset[Key]
    """Requirements that no spraying time meets: they may lose something, but not their verdict."""

    def accepts(self, after: Outcome) -> bool:
        """Whether an outcome is nearer to the limits; or as near, and cleaner for its price or shorter and as clean."""
        limits, before = self.request.limits, self.reference
        over, allowed = (limits.excess(each) for each in (after, before))
        if over != allowed:
            return over < allowed
        if before.shortfall - after.shortfall > _LEAST_GAIN * before.shortfall:
            return self.price_s(after) <= self.request.worth.requirement_s
        return after.seconds < before.seconds and after.litres <= before.litres and self.keeps(after)

    def price_s(self, after: Outcome) -> float:
        """Seconds, liquid with them, that an outcome costs for each requirement that it meets besides."""
        gained = self.reference.shortfall - after.shortfall
        return self.request.worth.added_s(self.reference, after) / gained

    def saves(self, after: Cost) -> bool:
        """Whether time and liquid are saved, as much as is worth an analysis."""
        worth = self.request.worth
        return worth.saved(self.reference, after) >= worth.saving and after.litres <= self.reference.litres

    def keeps(self, after: Outcome) -> bool:
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
