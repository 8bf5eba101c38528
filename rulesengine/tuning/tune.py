"""Tuning: improve a recipe until it cleans, then shorten it, by one search over moves of several kinds.

A plan takes little time and an analysis much, so that plans give the cost of a change, and analyses are counted. All
of them are fast ones: a sketch casts so few rays on small parts that it misses most of
what they get.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

from recipes.load import parse_recipe
from recipes.recipe import Recipe
from rulesengine.tuning.search.improving import Improvement, Reducing
from rulesengine.tuning.search.moves import Move, TuningContext
from rulesengine.tuning.search.shortening import Jumping, Shortening, jumps_of_paths, jumps_of_values
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import Trial, TuningRequest, TuningResult, pareto_front
from rulesengine.tuning.trial.trial_runner import TrialRunner
from specs.yaml.edit import remove_value

_RESERVES = (0.4, 0.2, 0.0)
"""Shares of the analyses that are kept for shortening; while requirements are not met, another round begins."""
_MOST_DETOURS = 2
"""How often speeds are adapted to another recipe before it is left."""

Observer: TypeAlias = Callable[[TuningResult], None]
"""Receives the result so far."""
Proposer: TypeAlias = Callable[[Outcome], Move | None]
"""Gives the next move from an outcome; ``None`` where none is worth an analysis."""


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
    context = TuningContext(runner, request, runner.first(text), lambda context: observe(_result(context)))
    reducing, improvement = Reducing(context), Improvement(context)
    search(context, reducing.relieve)
    for share in _RESERVES:
        reserve = int(share * request.max_analyses)
        search(context, improvement.propose, reserve)
        ended = runner.left > reserve
        search(context, first_of(Shortening(context, begun=runner.used).propose, Reducing(context).propose))
        unlimited = request.limits.seconds is None and request.limits.litres is None
        if not context.best.attainable or runner.left <= 0 or (ended and unlimited):
            break
    jumps = (Jumping(context, each).propose for each in (jumps_of_paths, jumps_of_values))
    shortening, reducing = Shortening(context, begun=runner.used), Reducing(context)
    # Jumps come last, so that they take no analysis from the others.
    search(context, first_of(shortening.propose, reducing.propose, *jumps))
    return _result(context)


def first_of(*proposers: Proposer) -> Proposer:
    """The moves of the first that has one."""
    return lambda now: next((move for move in (each(now) for each in proposers) if move is not None), None)


def search(context: TuningContext, propose: Proposer, reserve: int = 0) -> None:
    """Analyse one move after the other and take each that is better, until none is proposed.

    Args:
        context: The tuning.
        propose: Gives the moves.
        reserve: Analyses that are left to others.
    """
    runner = context.runner
    while runner.left > reserve:
        move = propose(context.best)
        if move is None:
            break
        after, what = runner.outcome(move.candidate.text), move.what
        landed, accepted = after, after is not None and context.acceptance.accepts(after)
        if move.by_speeds and landed is not None and not (accepted and context.acceptance.saves(landed)):
            after, speeds = _adapt_speeds(context, landed)
            what, accepted = (*what, *speeds), after is not None
        move.learn(after if accepted else landed, accepted)
        if after is not None and accepted:
            context.accept(what, after)


def _adapt_speeds(context: TuningContext, landed: Outcome) -> tuple[Outcome | None, tuple[str, ...]]:
    """Change the speeds of another recipe so that it is accepted; ``None`` where that is not predicted, or fails."""
    shortening = Shortening(context)
    for _ in range(_MOST_DETOURS):
        move = shortening.adapt(landed) if context.runner.left > 0 else None
        if move is None:
            break
        after = context.runner.outcome(move.candidate.text)
        accepted = after is not None and context.acceptance.accepts(after)
        move.learn(after, accepted)
        if accepted:
            return after, move.what
    return None, ()


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
        runner.prepared.parameters.calibrated,
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
