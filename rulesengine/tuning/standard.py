"""What a shorter recipe is held against."""

from dataclasses import dataclass

from cleaning.results import VERDICTS
from rulesengine.tuning.forecast import hopeless_of
from rulesengine.tuning.goals import Want, shortfall_of
from rulesengine.tuning.need import Key, key_of
from rulesengine.tuning.outcome import Outcome
from rulesengine.tuning.pace import paces_of
from rulesengine.tuning.shop import Shop
from rulesengine.tuning.ways import speeds_of


@dataclass(frozen=True, slots=True, eq=False)
class Standard:
    """An outcome that others must be as good as."""

    begin: Outcome
    hopeless: frozenset[Key]
    """What stays wanting however long it is sprayed: it may lose something, but not its verdict."""

    def holds(self, after: Outcome) -> bool:
        """Say whether no more is wanting than at the beginning, in all and in number."""
        ranks = {key_of(want): VERDICTS.index(want.judgement.verdict) for want in self.begin.wants}
        left = [want for want in after.wants if key_of(want) in self.hopeless]
        if any(VERDICTS.index(want.judgement.verdict) < ranks[key_of(want)] for want in left):
            return False
        asked, before = self._asked(after), self._asked(self.begin)
        return len(asked) <= len(before) and shortfall_of(asked) <= shortfall_of(before)

    def _asked(self, outcome: Outcome) -> tuple[Want, ...]:
        return tuple(want for want in outcome.wants if key_of(want) not in self.hopeless)


def standard_of(shop: Shop, begin: Outcome) -> Standard:
    """Make an outcome the standard."""
    paces = paces_of(shop.bench, begin.text, speeds_of(shop, begin))
    return Standard(begin, hopeless_of(begin, {name: pace.bounds[1] for name, pace in paces.items()}))
