"""Shorten a recipe by all its numbers at once: forecasts say how far each may go, and an analysis has the last word."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rulesengine.tuning.changes.change import Move
from rulesengine.tuning.changes.new_paths import added_paths
from rulesengine.tuning.forecast.forecast import Forecast, Learnt, forecast, learn
from rulesengine.tuning.forecast.schemes import Way, speeds_of, ways_of
from rulesengine.tuning.forecast.speed_for_duration import Pace, pace, paces_of
from rulesengine.tuning.search.acceptance import Standard
from rulesengine.tuning.trial.context import Shop
from rulesengine.tuning.trial.lower_bound import key_of
from rulesengine.tuning.trial.outcome import Outcome, litres_of, seconds_of
from rulesengine.tuning.trial.requirements import BOARD, Want
from rulesengine.tuning.trial.result import Change, figures_of

_LEAST_SAVED = 0.01
"""Share of the program's time below which a saving is not tried for;"""
_LEAST_BY_PATH = 0.03
"""for a path that is added, this much."""
_FAILED = 3
"""How often a way may fail before it is left."""
_SCARCE = 0.5
"""A surface is taken for lacking so much where a path is added for it."""


@dataclass(slots=True)
class _Balance:
    """Where to try, for what, and what was learnt there."""

    shop: Shop
    standard: Standard
    learnt: Learnt = field(default_factory=Learnt)
    failed: dict[str, int] = field(default_factory=dict[str, int])


def balance(shop: Shop, standard: Standard) -> tuple[Outcome, list[Change]]:
    """Make a recipe shorter as long as it holds.

    All speeds change at once, with one whole number or one path less. Where a path more would save more than it takes,
    because what it sprays is what the others are so long for, it is added first.

    Args:
        shop: Where to try.
        standard: What to begin with, and to be held against.
    """
    balancing = _Balance(shop, standard)
    now, changes = standard.begin, list[Change]()
    while shop.bench.left > 0:
        here = _look(balancing, now)
        way, path = here.way, _path(balancing, here)
        if path is not None:
            now, made = _by_path(balancing, now, path)
        elif way is not None:
            now, made = _by_way(balancing, here, way)
        else:
            break
        changes += made
    return now, changes


@dataclass(frozen=True, slots=True, eq=False)
class _Here:
    """An outcome, and what is foretold from it."""

    foretold: Forecast
    paces: Mapping[str, Pace]
    ways: Sequence[Way]
    """That may be tried, the shortest first."""

    @property
    def now(self) -> Outcome:
        return self.foretold.outcome

    @property
    def way(self) -> Way | None:
        """The way that saves most, if it is enough."""
        found = self.ways[0] if self.ways else None
        return found if found is not None and found.found.seconds < (1.0 - _LEAST_SAVED) * self.now.seconds else None


def _look(balancing: _Balance, now: Outcome) -> _Here:
    foretold = forecast(now, balancing.learnt, balancing.standard.hopeless)
    paces = paces_of(balancing.shop.bench, now.text, speeds_of(balancing.shop, now))
    ways = [way for way in ways_of(balancing.shop, foretold, paces) if balancing.failed.get(way.name, 0) < _FAILED]
    return _Here(foretold, paces, ways)


def _by_way(balancing: _Balance, here: _Here, way: Way) -> tuple[Outcome, list[Change]]:
    now, used = here.now, balancing.shop.bench.used
    after, way = _analysed(balancing, here, way)
    if after is not None and balancing.standard.holds(after):
        balancing.learnt.forget_half()
        balancing.failed = {name: often - 1 for name, often in balancing.failed.items()}
        return after, [Change(way.what, figures_of(now), figures_of(after))]
    lessons = False
    if after is not None and balancing.shop.bench.used > used:  # what was tried before teaches no more
        lessons = learn(balancing.learnt, here.foretold, after, way.found.times, way.scheme.often)
    balancing.failed[way.name] = balancing.failed.get(way.name, 0) + (1 if lessons else _FAILED)
    return now, []


def _analysed(balancing: _Balance, here: _Here, way: Way) -> tuple[Outcome | None, Way]:
    """Analyse a way if it does make the program shorter and asks for no more liquid; tell what it came to."""
    bench, now = balancing.shop.bench, here.now
    each = now.deposits.each
    asked = {
        (one.step, one.template): float(times) * one.seconds for one, times in zip(each, way.found.times, strict=True)
    }
    paced = pace(bench, now.text, way.edits, here.paces, asked, way.found.factors)
    planned = None if paced is None else bench.planned(paced.text)
    if paced is None or planned is None or litres_of(planned) > now.litres:
        return None, way
    if seconds_of(planned) > (1.0 - _LEAST_SAVED / 2) * now.seconds:
        return None, way
    sprayed = [paced.sprayed_s.get((one.step, one.template), 0.0) for one in each]
    times = np.array([seconds / max(one.seconds, 1e-9) for seconds, one in zip(sprayed, each, strict=True)])
    found = replace(way.found, times=times, seconds=seconds_of(planned))
    return bench.outcome(paced.text), replace(way, what=(*way.what, *paced.what), found=found)


def _path(balancing: _Balance, here: _Here) -> Move | None:
    """Find the path whose surfaces make the program most of what it is longer, if it would save enough by itself."""
    bench, now = balancing.shop.bench, here.now
    seconds = now.seconds if here.way is None else here.way.found.seconds
    best: tuple[float, Move] | None = None
    for wants, rest in _scarce(here.foretold):
        moves = [move for move in added_paths(now, wants) if balancing.shop.asked.allowed.may(move.kind, move.edits)]
        moves = [move for move in moves if not balancing.failed.get(move.what)]
        without = ways_of(balancing.shop, rest, here.paces) if moves else []
        for move in moves if without else ():
            text = bench.edited(now.text, move.edits)
            planned = None if text is None else bench.planned(text)
            if planned is None:
                continue
            saved = seconds - without[0].found.seconds - (seconds_of(planned) - now.seconds)
            if saved > _LEAST_BY_PATH * now.seconds and (best is None or saved > best[0]):
                best = saved, move
    return None if best is None else best[1]


def _scarce(foretold: Forecast) -> Iterator[tuple[list[Want], Forecast]]:
    """Give the surfaces of the board, then those of the parts, as if they lacked something; and what else is needed."""
    for of_board in (True, False):
        mine = {need.key for need in foretold.needs if need.kind == "low" and (need.key[0] == BOARD) == of_board}
        wants = [want for want in foretold.outcome.wants if key_of(want) in mine]
        wants += [
            Want(each.component, each.judgement, _SCARCE) for each in foretold.outcome.spares if key_of(each) in mine
        ]
        yield wants, replace(foretold, needs=tuple(need for need in foretold.needs if need.key not in mine))


def _by_path(balancing: _Balance, now: Outcome, move: Move) -> tuple[Outcome, list[Change]]:
    """Add a path, and see whether that saves more than it takes."""
    shop = balancing.shop
    balancing.failed[move.what] = 1
    text = shop.bench.edited(now.text, move.edits)
    longer = None if text is None else shop.bench.outcome(text)
    if longer is None or not balancing.standard.holds(longer):
        return now, []
    fresh = _Balance(shop, balancing.standard)
    after, what = longer, [move.what]
    while shop.bench.left > 0 and after.seconds >= now.seconds:
        here = _look(fresh, after)
        if here.way is None or here.way.found.seconds >= now.seconds:
            return now, []
        after, made = _by_way(fresh, here, here.way)
        what += [each for change in made for each in change.what]
    if after.seconds >= now.seconds:
        return now, []
    balancing.learnt, balancing.failed = fresh.learnt, fresh.failed | {move.what: 1}
    return after, [Change(tuple(what), figures_of(now), figures_of(after))]
