"""The first part of tuning: change what helps most for the time that it takes, until nothing is wanting."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from rulesengine.tuning.changes.candidate_changes import moves_of
from rulesengine.tuning.changes.change import Move
from rulesengine.tuning.trial.lower_bound import Key, key_of
from rulesengine.tuning.trial.outcome import Outcome, litres_of, seconds_of
from rulesengine.tuning.trial.request import Asked
from rulesengine.tuning.trial.result import Change, figures_of
from rulesengine.tuning.trial.trial_runner import Bench
from rulesengine.tuning.variables.recipe_edits import Edits

_PLANNED = 12
"""Moves of the highest belief that are planned, which is quick, to know what they cost."""
_TRIED = 6
"""Moves that are analysed in vain before no more is tried."""
_SHARE = 0.05
"""Of the time that the program takes now: what is added to the cost of a move, so that one does not crawl,"""
_SECONDS = 20.0
"""and neither where the program hardly takes any time yet."""
_LEAST = 0.005
"""Share of the shortfall that a move must take away."""
_DISAPPOINTED = 0.25
_HARDLY, _DESPAIR = 0.98, 0.6


@dataclass(frozen=True, slots=True, eq=False)
class Ranked:
    """A move, and what planning it says."""

    move: Move
    text: str
    worth: float
    """Believed gain for its cost."""


@dataclass(slots=True)
class Growth:
    """One run of the first part, and what it has learnt of which moves disappoint."""

    bench: Bench
    asked: Asked
    trust: dict[tuple[str, str], float] = field(default_factory=dict[tuple[str, str], float])
    """By what is alike of moves."""
    hope: dict[Key, float] = field(default_factory=dict[Key, float])
    """By what is wanting."""


def grow(growth: Growth, begin: Outcome, least_left: int) -> tuple[Outcome, list[Change]]:
    """Change a recipe until nothing is wanting, nothing helps, or few analyses are left.

    Args:
        growth: Where to try, for what.
        begin: An outcome within the limits, or as near to them as can be.
        least_left: Analyses to be left for what comes after.
    """
    now, changes = begin, list[Change]()
    while now.mendable and growth.bench.left > least_left:
        better = _step(growth, now, least_left)
        if better is None:
            break
        moves, after = better
        changes.append(Change(tuple(move.what for move in moves), figures_of(now), figures_of(after)))
        now = after
    return now, changes


def _step(growth: Growth, now: Outcome, least_left: int) -> tuple[Sequence[Move], Outcome] | None:
    ranked = _rank(growth, now)
    bundle = _bundle(ranked, now)
    tries = [bundle] if len(bundle) > 1 else []
    tries += [[each.move] for each in ranked[:_TRIED]]
    for moves in tries:
        if growth.bench.left <= least_left:
            return None
        after = _try(growth, now, moves)
        gained = 0.0 if after is None else now.shortfall - after.shortfall
        _learn(growth, moves, gained / max(sum(move.most for move in moves), 1e-9))
        if after is not None and gained > _LEAST * now.shortfall:
            return moves, after
        _despair(growth, now, moves, after)
    return None


def _despair(growth: Growth, now: Outcome, moves: Sequence[Move], after: Outcome | None) -> None:
    """Hope less for what was to become better and did not, so that moves for something else come first."""
    left = {} if after is None else {key_of(want): want.deficit for want in after.wants}
    aims = frozenset(key for move in moves for key in move.aims)
    for want in now.mendable:
        key = key_of(want)
        if key in aims and (after is None or left.get(key, 0.0) > _HARDLY * want.deficit):
            growth.hope[key] = _DESPAIR * growth.hope.get(key, 1.0)


def _learn(growth: Growth, moves: Sequence[Move], share: float) -> None:
    """Believe a move the less, the less of its promise it kept; of several at once none is blamed for long."""
    for move in moves if len(moves) == 1 or share > 0 else ():
        growth.trust[move.key] = growth.trust.get(move.key, 1.0) * min(1.0, max(_DISAPPOINTED, share))


def _rank(growth: Growth, now: Outcome) -> list[Ranked]:
    """Plan the most promising moves, leave out what breaks a limit, and put the most worth first."""

    def trust(move: Move) -> float:
        return growth.trust.get(move.key, 1.0)

    wants = [replace(want, hope=growth.hope.get(key_of(want), 1.0)) for want in now.mendable]
    promising = sorted(moves_of(now, wants, growth.asked.allowed), key=lambda move: -round(trust(move) * move.most, 6))
    ranked: list[Ranked] = []
    for move in promising[:_PLANNED]:
        text = growth.bench.edited(now.text, move.edits)
        planned = None if text is None else growth.bench.planned(text)
        if text is None or planned is None:
            continue
        seconds, litres = seconds_of(planned), litres_of(planned)
        if growth.asked.limits.excess(seconds, litres) > growth.asked.limits.excess(now.seconds, now.litres):
            continue
        longer = seconds - now.seconds
        worth = trust(move) * move.gain_in(longer) / (max(longer, 0.0) + _SHARE * now.seconds + _SECONDS)
        ranked.append(Ranked(move, text, round(worth, 9)))
    return sorted(ranked, key=lambda each: -each.worth)


def _bundle(ranked: Sequence[Ranked], now: Outcome) -> list[Move]:
    """Take the best move, and the best ones of other uses: washing and rinsing are changed at once."""
    chosen: list[Move] = []
    taken: set[str] = set()
    for each in ranked:
        uses = {str(now.use_of(step)) for step in each.move.steps}
        if uses and not uses & taken:
            chosen.append(each.move)
            taken |= uses
    return chosen


def _try(growth: Growth, now: Outcome, moves: Sequence[Move]) -> Outcome | None:
    text = growth.bench.edited(now.text, joined(move.edits for move in moves))
    planned = None if text is None else growth.bench.planned(text)
    if text is None or planned is None:
        return None
    limits = growth.asked.limits
    if limits.excess(seconds_of(planned), litres_of(planned)) > limits.excess(now.seconds, now.litres):
        return None
    return growth.bench.outcome(text)


def joined(edits: Iterable[Edits]) -> Edits:
    """Write several edits one after the other."""
    return tuple(each for part in edits for each in part)
