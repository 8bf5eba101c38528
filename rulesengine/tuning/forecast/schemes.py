"""Ways to a shorter recipe, as forecasts tell them: less often, a path less, and how fast everything is then."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from rulesengine.tuning.changes.candidate_changes import knobs_for
from rulesengine.tuning.changes.reductions import Cut, cuts_of
from rulesengine.tuning.forecast.forecast import Forecast
from rulesengine.tuning.forecast.minimum_times import Scheme, Shortest, shortest
from rulesengine.tuning.forecast.speed_for_duration import Pace
from rulesengine.tuning.trial.context import Shop
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.variables.design_variables import Knob
from rulesengine.tuning.variables.recipe_edits import Edits, is_kept


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """One way to a shorter recipe."""

    name: str
    """Empty: nothing but speeds change."""
    what: tuple[str, ...]
    """What else changes, from and to."""
    edits: Edits
    scheme: Scheme
    found: Shortest


def ways_of(shop: Shop, foretold: Forecast, paces: Mapping[str, Pace]) -> list[Way]:
    """Tell how short the program becomes for each whole number that may become smaller and each path that may go.

    Returns:
        The shortest first.
    """
    bounds = {name: pace.bounds for name, pace in paces.items()}
    found: list[Way] = []
    for name, what, edits, scheme in _schemes(shop, foretold, bounds):
        times = shortest(foretold, scheme)
        if times is not None:
            found.append(Way(name, what, edits, scheme, times))
    return sorted(found, key=lambda way: round(way.found.seconds, 3))


def speeds_of(shop: Shop, outcome: Outcome) -> dict[str, Knob]:
    """Find the speed of each template that may be changed: one number for all classes, and not of a drying step."""
    allowed = shop.asked.allowed
    drying = {step.made_by for step in outcome.steps if step.use == "dry"}
    knobs = [knob for knob in knobs_for(outcome) if knob.kind == "speeds" and not drying & set(knob.steps)]
    if "speeds" not in allowed.kinds:
        return {}
    return {
        knob.template: knob
        for knob in knobs
        if not knob.of_class and knob.path[-1] == "speed_mm_s" and not is_kept(knob.path, allowed.kept)
    }


def _schemes(
    shop: Shop, foretold: Forecast, bounds: Mapping[str, tuple[float, float]]
) -> Iterator[tuple[str, tuple[str, ...], Edits, Scheme]]:
    """Nothing but speeds; and each whole number made smaller, each path left out."""
    yield "", (), (), Scheme(bounds)
    sources = [(deposit.step, deposit.template) for deposit in foretold.deposits.each]
    cuts = cuts_of(foretold.outcome, shop.began, shop.asked.allowed)
    for cut in cuts.values():
        for value in _values(cut):
            ratio = 0.0 if cut.knob is None else value / cut.knob.value
            whole = not cut.template
            given = {
                (step, template): ratio
                for step, template in sources
                if step in cut.steps and (whole or template == cut.template)
            }
            often = dict.fromkeys(cut.steps, ratio) if whole else {}
            what, edits = cut.at(value)
            yield f"{cut.name} {value:g}", (what,), edits, Scheme(bounds, given, often)


def _values(cut: Cut) -> list[float]:
    if cut.knob is None:
        return [cut.end]
    if cut.knob.kind not in ("passes", "wash_time") or cut.knob.of_class:
        return []
    middle = cut.halfway(cut.begin, cut.end)
    return list(
        dict.fromkeys(value for value in (cut.end, middle, cut.begin - 1.0) if value is not None and value >= cut.end)
    )
