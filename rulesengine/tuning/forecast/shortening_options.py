"""Options that shorten a recipe, with their forecasts: less often, a path less, and the speeds that go with it."""

from collections.abc import Mapping
from dataclasses import dataclass

from rulesengine.tuning.changes.reductions import Reduction, reductions
from rulesengine.tuning.forecast.forecast import Forecast
from rulesengine.tuning.forecast.minimum_times import MinimumTimes, Scheme, minimum_times
from rulesengine.tuning.forecast.speed_curves import SpeedCurve
from rulesengine.tuning.trial.trial_runner import TuningContext
from rulesengine.tuning.variables.recipe_edits import Edits


@dataclass(frozen=True, slots=True, eq=False)
class Option:
    """One option for a shorter recipe."""

    name: str
    """Empty: nothing but speeds change."""
    what: tuple[str, ...]
    """What else changes, from and to."""
    edits: Edits
    scheme: Scheme
    found: MinimumTimes


def shortening_options(context: TuningContext, predicted: Forecast, curves: Mapping[str, SpeedCurve]) -> list[Option]:
    """Predict the shortest program with other speeds alone, with each smaller whole number, with each path left out.

    The shortest comes first.
    """
    bounds = {name: curve.bounds for name, curve in curves.items()}
    schemes: list[tuple[str, tuple[str, ...], Edits, Scheme]] = [("", (), (), Scheme(bounds))]
    sources = [(deposit.step, deposit.template) for deposit in predicted.deposits.each]
    for each in reductions(predicted.outcome, context.initial_values, context.request.allowed).values():
        for value in _whole_values(each):
            ratio = 0.0 if each.variable is None else value / each.variable.value
            fixed = {
                (step, template): ratio
                for step, template in sources
                if step in each.steps and each.template in ("", template)
            }
            repeats = {} if each.template else dict.fromkeys(each.steps, ratio)
            what, edits = each.change_to(value)
            schemes.append((f"{each.name} {value:g}", (what,), edits, Scheme(bounds, fixed, repeats)))
    timed = [(scheme, minimum_times(predicted, scheme[3])) for scheme in schemes]
    found = [Option(*scheme, times) for scheme, times in timed if times is not None]
    return sorted(found, key=lambda option: round(option.found.seconds, 3))


def _whole_values(reduction: Reduction) -> list[float]:
    variable, end = reduction.variable, reduction.end
    if variable is None:
        return [end]
    if variable.kind not in ("passes", "wash_time") or variable.component_class:
        return []
    values = (end, reduction.bisect(reduction.begin, end), reduction.begin - 1.0)
    return list(dict.fromkeys(value for value in values if value is not None and value >= end))
