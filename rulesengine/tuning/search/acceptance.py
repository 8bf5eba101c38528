"""What a shorter recipe is held against."""

from dataclasses import dataclass

from cleaning.verdicts.rules import VERDICTS
from rulesengine.tuning.forecast.forecast import hopeless_of
from rulesengine.tuning.forecast.schemes import speeds_of
from rulesengine.tuning.forecast.speed_for_duration import paces_of
from rulesengine.tuning.trial.context import Shop
from rulesengine.tuning.trial.lower_bound import Key, key_of
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import Want, shortfall_of


@dataclass(frozen=True, slots=True, eq=False)
class Standard:
    """An outcome that others must be as good as."""

    begin: Outcome
    hopeless: frozenset[Key]
    """What stays wanting however long it is sprayed: it may lose something, but not its verdict."""

    def holds(self, after: Outcome) -> bool:
        """Say whether no more is wanting than at the beginning, in all and in number."""
        before, now = self._ranks(self.begin), self._ranks(after)
        if any(rank < before.get(name, rank) for name, rank in now.items()):
            return False
        asked, begin = self._asked(after), self._asked(self.begin)
        return len(asked) <= len(begin) and shortfall_of(asked) <= shortfall_of(begin)

    def _ranks(self, outcome: Outcome) -> dict[str, int]:
        """Rank the worst verdict on what is hopeless of each component; 0 is the worst."""
        found: dict[str, int] = {}
        for want in outcome.wants:
            if key_of(want) in self.hopeless:
                rank = VERDICTS.index(want.judgement.verdict)
                found[want.component] = min(rank, found.get(want.component, rank))
        return found

    def _asked(self, outcome: Outcome) -> tuple[Want, ...]:
        return tuple(want for want in outcome.wants if key_of(want) not in self.hopeless)


def standard_of(shop: Shop, begin: Outcome) -> Standard:
    """Make an outcome the standard."""
    paces = paces_of(shop.bench, begin.text, speeds_of(shop, begin))
    return Standard(begin, hopeless_of(begin, {name: pace.bounds[1] for name, pace in paces.items()}))
