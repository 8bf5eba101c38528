"""Tuning: improve a recipe until it cleans, then shorten it.

A plan takes little time and an analysis much, so that plans give the cost of a change, and analyses are counted. All
of them are fast ones: a sketch casts so few rays on small parts that it misses most of
what they get.
"""

from dataclasses import replace

from recipes.load import parse_recipe
from rulesengine.tuning.changes.candidate_changes import variables_of
from rulesengine.tuning.search.acceptance import acceptance_of
from rulesengine.tuning.search.by_bisection import enforce_limits, shorten_by_bisection
from rulesengine.tuning.search.by_linear_program import shorten_by_linear_program
from rulesengine.tuning.search.improve import Improvement, improve
from rulesengine.tuning.trial.request import AcceptedChange, TuningRequest, TuningResult
from rulesengine.tuning.trial.trial_runner import TrialRunner, TuningContext
from specs.yaml.edit import remove_value

_RESERVES = (0.4, 0.2, 0.0)
"""Shares of the analyses that are kept for shortening; while requirements are not met, another round begins."""


def tune(runner: TrialRunner, text: str, request: TuningRequest) -> TuningResult:
    """Change a recipe until all that it can clean is predicted clean, in little time.

    Raises:
        JobError: the recipe cannot be read, planned or analysed, or the robot of the runner's cell cannot carry it out.
    """
    first = runner.first(text)
    initial = {variable.path: variable.value for variable in reversed(variables_of(first))}
    context = TuningContext(runner, request, initial)
    now, changes = first, list[AcceptedChange]()
    if context.excess(first) > 0:
        now, changes = enforce_limits(context, now)
    improvement = Improvement(context)
    for share in _RESERVES:
        reserve = int(share * request.max_analyses)
        now, made = improve(improvement, now, reserve)
        changes += made
        ended = runner.left > reserve
        for shorten in (shorten_by_linear_program, shorten_by_bisection):
            now, made = shorten(context, acceptance_of(context, now))
            changes += made
        unlimited = request.limits.seconds is None and request.limits.litres is None
        if not now.attainable or runner.left <= 0 or (ended and unlimited):
            break
    # Templates that tuning added and no step uses any more go: the program is the same without them.
    used, text = {name for step in now.recipe.sequence for name in step.paths}, now.text
    for name in [name for name in now.recipe.templates if name not in first.recipe.templates and name not in used]:
        text = remove_value(text, ("templates", name))
    if text != now.text:
        now = replace(now, text=text, recipe=parse_recipe(text, file=runner.file))
    return TuningResult(request, first, now, tuple(changes), runner.used, runner.robot)
