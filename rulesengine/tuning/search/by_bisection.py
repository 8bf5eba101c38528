"""Take away what is not needed of pauses and of numbers by class, one by one, by bisection; and keep to limits."""

from rulesengine.tuning.changes.reductions import Cut, cuts_of
from rulesengine.tuning.search.acceptance import Standard
from rulesengine.tuning.search.slack import likely
from rulesengine.tuning.trial.context import Shop
from rulesengine.tuning.trial.outcome import Outcome, litres_of, seconds_of
from rulesengine.tuning.trial.result import Change, figures_of

_TRIALS = 3
"""Analyses for one cut, at most."""
_LEAST_SAVED = 0.01
"""Share of the program's time below which a saving is not tried for."""
_SCALES = (1.0, 0.3, 0.1)
"""Round after round, smaller steps are tried."""
_SQUEEZED = 3
"""Ways to keep a limit that are compared at a time."""


def tighten(shop: Shop, standard: Standard) -> tuple[Outcome, list[Change]]:
    """Make a recipe shorter by its pauses and by what it states by class, one at a time; never longer."""
    now, changes = standard.begin, list[Change]()
    for scale in _SCALES:
        for name in _by_saving(shop, now, scale):
            now, made = _cut(shop, now, (name, scale), standard)
            changes += made
    return now, changes


def _named(shop: Shop, now: Outcome, name: str) -> Cut | None:
    return cuts_of(now, shop.began, shop.asked.allowed).get(name)


def _by_saving(shop: Shop, now: Outcome, scale: float) -> list[str]:
    """Name the cuts that probably save more than a little, what saves most first."""
    saved: dict[str, float] = {}
    for name, cut in cuts_of(now, shop.began, shop.asked.allowed).items():
        if cut.knob is None or not (cut.knob.of_class or cut.knob.kind == "dwells"):
            continue  # is balanced with all others
        seconds, share = _promise(shop, now, cut)
        if seconds * share > scale * _LEAST_SAVED * now.seconds:
            saved[name] = round(seconds * share, 3)
    return sorted(saved, key=lambda name: -saved[name])


def _promise(shop: Shop, now: Outcome, cut: Cut) -> tuple[float, float]:
    """Time that the whole cut saves, as planned, and which share of it probably holds."""
    text = shop.bench.edited(now.text, cut.at(cut.end)[1])
    planned = None if text is None else shop.bench.planned(text)
    saved = 0.0 if planned is None else now.seconds - seconds_of(planned)
    return saved, likely(now, frozenset(cut.steps), cut.template, saved)


def _cut(shop: Shop, now: Outcome, named: tuple[str, float], standard: Standard) -> tuple[Outcome, list[Change]]:
    """Turn one knob as far as holds: first a part of what is likely, then by halves."""
    name, scale = named
    cut = _named(shop, now, name)
    if cut is None or shop.bench.left <= 0:
        return now, []
    begin, good, bad, what = now, cut.begin, cut.end, ""
    value: float | None = cut.part(scale * _promise(shop, now, cut)[1])
    for _ in range(_TRIALS):
        if value is None:
            break
        after = _shorter(shop, now, cut, value)
        if after is not None and standard.holds(after):
            now, good, what = after, value, cut.at(value)[0]
            if good == cut.end:
                break
        else:
            bad = value
        value = cut.halfway(good, bad)
    return now, [Change((what,), figures_of(begin), figures_of(now))] if what else []


def _shorter(shop: Shop, now: Outcome, cut: Cut, value: float) -> Outcome | None:
    """Analyse a cut if it does make the program shorter and asks for no more liquid."""
    text = shop.bench.edited(now.text, cut.at(value)[1])
    planned = None if text is None else shop.bench.planned(text)
    if text is None or planned is None:
        return None
    seconds, litres = seconds_of(planned), litres_of(planned)
    if seconds >= now.seconds or litres > now.litres:
        return None
    return shop.bench.outcome(text)


def squeeze(shop: Shop, begin: Outcome) -> tuple[Outcome, list[Change]]:
    """Bring a recipe within its limits by what costs least cleaning for the time or liquid that it saves."""
    now, changes, limits = begin, list[Change](), shop.asked.limits
    while (over := limits.excess(now.seconds, now.litres)) > 0:
        best: tuple[float, str, Outcome] | None = None
        for cut in _relieving(shop, now)[:_SQUEEZED]:
            what, edits = cut.at(_just_within(shop, now, cut))
            text = shop.bench.edited(now.text, edits)
            after = None if text is None else shop.bench.outcome(text)
            if after is None:
                continue
            relief = over - limits.excess(after.seconds, after.litres)
            price = round((after.shortfall - now.shortfall) / max(relief, 1e-6), 6)
            if relief > 0 and (best is None or price < best[0]):
                best = price, what, after
        if best is None:
            break
        changes.append(Change((best[1],), figures_of(now), figures_of(best[2])))
        now = best[2]
    return now, changes


def _relieving(shop: Shop, now: Outcome) -> list[Cut]:
    relief: dict[str, float] = {}
    cuts = cuts_of(now, shop.began, shop.asked.allowed)
    for name, cut in cuts.items():
        after = _excess(shop, now, cut, cut.end)
        if after is not None:
            relief[name] = after
    now_over = shop.asked.limits.excess(now.seconds, now.litres)
    helpful = [name for name in relief if relief[name] < now_over]
    return [cuts[name] for name in sorted(helpful, key=lambda name: relief[name])]


def _excess(shop: Shop, now: Outcome, cut: Cut, value: float) -> float | None:
    text = shop.bench.edited(now.text, cut.at(value)[1])
    planned = None if text is None else shop.bench.planned(text)
    return None if planned is None else shop.asked.limits.excess(seconds_of(planned), litres_of(planned))


def _just_within(shop: Shop, now: Outcome, cut: Cut) -> float:
    """Turn a knob no further than the limits ask for; planning alone says how far that is."""
    if cut.knob is None or _excess(shop, now, cut, cut.end) != 0:
        return cut.end
    good, bad = cut.end, cut.knob.value
    while (value := cut.halfway(good, bad)) is not None:
        if _excess(shop, now, cut, value) == 0:
            good = value
        else:
            bad = value
    return good
