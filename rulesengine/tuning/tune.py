"""Tuning: improve a recipe until it cleans, then shorten it.

A plan takes little time and an analysis much, so that plans give the cost of a change, and analyses are counted. All
of them are fast ones: a sketch casts so few rays on small parts that it misses most of
what they get.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

from recipes.load import parse_recipe
from recipes.recipe import Recipe
from rulesengine.tuning.changes.candidate_changes import variables_of
from rulesengine.tuning.front import pareto_front
from rulesengine.tuning.search.acceptance import acceptance_of
from rulesengine.tuning.search.by_bisection import enforce_limits, shorten_by_bisection
from rulesengine.tuning.search.by_jumps import shorten_by_jumps
from rulesengine.tuning.search.by_linear_program import shorten_by_linear_program
from rulesengine.tuning.search.improve import Improvement, improve
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import Trial, TuningRequest, TuningResult
from rulesengine.tuning.trial.trial_runner import TrialRunner, TuningContext
from specs.yaml.edit import remove_value

_RESERVES = (0.4, 0.2, 0.0)
"""Shares of the analyses that are kept for shortening; while requirements are not met, another round begins."""

Observer: TypeAlias = Callable[[TuningResult], None]
"""Receives the result so far."""


def ignore(_result: TuningResult) -> None:
    """Take no notice of results on the way."""


def tune(runner: TrialRunner, text: str, request: TuningRequest, observe: Observer = ignore) -> TuningResult:
    """Change a recipe until all that it can clean is predicted clean, in little time.

    Args:
        runner: Plans and analyses.
        text: The recipe.
        request: What counts, what may change, and when to stop.
        observe: Receives the result so far, first of the recipe as it is, then of each better one.

    Raises:
        JobError: the recipe cannot be read, planned or analysed, or the robot of the runner's cell cannot carry it out.
    """
    first = runner.first(text)
    initial = {variable.path: variable.value for variable in reversed(variables_of(first))}
    context = TuningContext(runner, request, first, initial, lambda context: observe(_result(context)))
    if context.excess(first) > 0:
        enforce_limits(context, first)
    improvement = Improvement(context)
    for share in _RESERVES:
        reserve = int(share * request.max_analyses)
        improve(improvement, context.best, reserve)
        ended = runner.left > reserve
        for shorten in (shorten_by_linear_program, shorten_by_bisection):
            shorten(context, acceptance_of(context, context.best))
        unlimited = request.limits.seconds is None and request.limits.litres is None
        if not context.best.attainable or runner.left <= 0 or (ended and unlimited):
            break
    before = context.best
    if runner.left > 0:  # last, so that jumps take no analysis from the other stages
        shorten_by_jumps(context, acceptance_of(context, before))
    if context.best is not before and runner.left > 0:
        shorten_by_bisection(context, acceptance_of(context, context.best))
    return _result(context)


def _result(context: TuningContext) -> TuningResult:
    """Sum up a tuning, of which the best recipe is that of now."""
    runner, last = context.runner, context.best
    text, recipe = _without_unused(context, last)
    front = {trial.text for trial in pareto_front([_trial(each, each.text) for each in runner.trials])}
    trials = tuple(
        _trial(each, _without_unused(context, each)[0] if each.text in front else each.text) for each in runner.trials
    )
    return TuningResult(
        context.request,
        context.first,
        replace(last, text=text, recipe=recipe),
        tuple(context.changes),
        runner.used,
        runner.robot,
        tuple(context.ended.values()),
        trials,
    )


def _trial(outcome: Outcome, text: str) -> Trial:
    return Trial(text, outcome.figures, outcome.margin)


def _without_unused(context: TuningContext, outcome: Outcome) -> tuple[str, Recipe]:
    """Leave out templates that tuning added and no step uses any more: the program is the same without them."""
    recipe, first = outcome.recipe, context.first.recipe
    used, text = {name for step in recipe.sequence for name in step.paths}, outcome.text
    for name in [name for name in recipe.templates if name not in first.templates and name not in used]:
        text = remove_value(text, ("templates", name))
    return text, recipe if text == outcome.text else parse_recipe(text, file=context.runner.file)
