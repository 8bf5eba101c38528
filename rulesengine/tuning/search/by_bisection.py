"""Third stage of tuning: pauses, least times and numbers by class, shortened one at a time; and keeping to limits."""

from rulesengine.tuning.changes.reductions import Reduction, acceptable_share, reductions
from rulesengine.tuning.search.acceptance import Acceptance
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.trial_runner import Candidate, TuningContext

_TRIALS = 3
"""Analyses for one reduction, at most."""
_STAGE = "pauses"
_SCALES = (1.0, 0.3, 0.1)
"""Round after round, smaller steps are tried."""
_MOST_COMPARED = 3
"""Ways to keep a limit that are compared at a time."""


def shorten_by_bisection(context: TuningContext, acceptance: Acceptance) -> Outcome:
    """Shorten a recipe by its pauses, its least times and what it states by class, one at a time; never longer."""
    now = acceptance.reference
    context.ended.pop(_STAGE, None)
    for scale in _SCALES:
        for name in _by_saving(context, now, scale):
            reduction = _reductions(context, now).get(name)
            if reduction is None or context.runner.left <= 0:
                continue
            after, what = _bisect(context, now, (reduction, scale), acceptance)
            if what:
                context.accept([what], now, after)
            now = after
    if context.runner.left > 0:
        least = _SCALES[-1] * context.request.worth.saving
        context.ended[_STAGE] = f"No pause, least time or number by class is expected to save {least:.2%} of the time."
    return now


def _reductions(context: TuningContext, now: Outcome) -> dict[str, Reduction]:
    return reductions(now, context.initial_values, context.request.allowed)


def _candidate(context: TuningContext, now: Outcome, reduction: Reduction, value: float) -> Candidate | None:
    return context.runner.candidate(now.text, reduction.change_to(value)[1])


def _by_saving(context: TuningContext, now: Outcome, scale: float) -> list[str]:
    """Names of the reductions that probably save more than a little, the largest saving first."""
    saved: dict[str, float] = {}
    for name, reduction in _reductions(context, now).items():
        variable = reduction.variable
        if variable is None or not (variable.component_class or variable.kind == "dwells" or variable.by_repeats):
            continue  # belongs to the linear programs
        seconds, share = _expected(context, now, reduction)
        if seconds * share > scale * context.request.worth.saving * now.seconds:
            saved[name] = round(seconds * share, 3)
    return sorted(saved, key=lambda name: -saved[name])


def _expected(context: TuningContext, now: Outcome, reduction: Reduction) -> tuple[float, float]:
    """Time that the whole reduction saves, as planned, and the share of it that is probably accepted."""
    candidate = _candidate(context, now, reduction, reduction.end)
    saved = 0.0 if candidate is None else now.seconds - candidate.seconds
    return saved, acceptable_share(now, reduction, saved)


def _bisect(
    context: TuningContext, now: Outcome, scaled: tuple[Reduction, float], acceptance: Acceptance
) -> tuple[Outcome, str]:
    """Move one variable as far as is accepted: first a part of what is expected, then by halves."""
    reduction, scale = scaled
    good, bad, what = reduction.begin, reduction.end, ""
    value = reduction.value_at(scale * _expected(context, now, reduction)[1])
    for _ in range(_TRIALS):
        if value is None:
            break
        candidate = _candidate(context, now, reduction, value)
        after = None
        if candidate is not None and candidate.seconds < now.seconds and candidate.litres <= now.litres:
            after = context.runner.outcome(candidate.text)
        if after is not None and acceptance.accepts(after):
            now, good, what = after, value, reduction.change_to(value)[0]
            if good == reduction.end:
                break
        else:
            bad = value
        value = reduction.bisect(good, bad)
    return now, what


def enforce_limits(context: TuningContext, begin: Outcome) -> Outcome:
    """Bring a recipe within its limits by what costs least cleaning for the time or liquid that it saves."""
    now = begin
    while (over := context.excess(now)) > 0:
        best: tuple[float, str, Outcome] | None = None
        for reduction in _relieving(context, now)[:_MOST_COMPARED]:
            value = _just_within(context, now, reduction)
            candidate = _candidate(context, now, reduction, value)
            after = None if candidate is None else context.runner.outcome(candidate.text)
            if after is None:
                continue
            relief = over - context.excess(after)
            price = round((after.shortfall - now.shortfall) / max(relief, 1e-6), 6)
            if relief > 0 and (best is None or price < best[0]):
                best = price, reduction.change_to(value)[0], after
        if best is None:
            break
        context.accept([best[1]], now, best[2])
        now = best[2]
    return now


def _relieving(context: TuningContext, now: Outcome) -> list[Reduction]:
    """Reductions that lead nearer to the limits, the nearest first."""
    found: list[tuple[float, Reduction]] = []
    for reduction in _reductions(context, now).values():
        candidate = _candidate(context, now, reduction, reduction.end)
        if candidate is not None and context.excess(candidate) < context.excess(now):
            found.append((context.excess(candidate), reduction))
    return [reduction for _, reduction in sorted(found, key=lambda each: each[0])]


def _just_within(context: TuningContext, now: Outcome, reduction: Reduction) -> float:
    """Value that just keeps the limits, found by planning alone; the end where even that does not keep them."""

    def keeps(value: float) -> bool:
        candidate = _candidate(context, now, reduction, value)
        return candidate is not None and context.excess(candidate) == 0

    if not keeps(reduction.end):
        return reduction.end
    good, bad = reduction.end, reduction.begin
    while (value := reduction.bisect(good, bad)) is not None:
        if keeps(value):
            good = value
        else:
            bad = value
    return good
