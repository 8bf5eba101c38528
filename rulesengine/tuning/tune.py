"""Tuning: grow a recipe until it cleans, then take away what is not needed.

A plan costs little and an analysis much, so that plans tell what a move costs, and analyses are counted. All of them
are fast ones: a sketch deals small parts so few rays that it finds far more wanting than there is.
"""

from collections.abc import Mapping
from dataclasses import replace

from recipes.load import parse_recipe
from rulesengine.tuning.changes.candidate_changes import knobs_for
from rulesengine.tuning.search.acceptance import standard_of
from rulesengine.tuning.search.by_bisection import squeeze, tighten
from rulesengine.tuning.search.by_linear_program import balance
from rulesengine.tuning.search.improve import Growth, grow
from rulesengine.tuning.trial.context import Shop
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import Asked
from rulesengine.tuning.trial.result import Change, Tuned
from rulesengine.tuning.trial.trial_runner import Bench
from specs.yaml.edit import remove_value
from specs.yaml.located import YamlPath

_KEPT = (0.4, 0.2, 0.0)
"""Shares of the analyses that are kept for taking away; while something is wanting, another turn begins."""


def tune(bench: Bench, text: str, asked: Asked) -> Tuned:
    """Change a recipe until all that it can clean is predicted clean, in little time.

    Args:
        bench: Where to try; unused.
        text: The recipe.
        asked: For what.

    Raises:
        JobError: the recipe cannot be read, planned or analysed.
    """
    first = bench.first(text)
    shop = Shop(bench, asked, began_at(first))
    now, changes = first, list[Change]()
    if asked.limits.excess(first.seconds, first.litres) > 0:
        now, changes = squeeze(shop, now)
    growth = Growth(bench, asked)
    for share in _KEPT:
        least = int(share * asked.analyses)
        now, made = grow(growth, now, least)
        changes += made
        grown = bench.left > least
        for shorten in (balance, tighten):
            now, made = shorten(shop, standard_of(shop, now))
            changes += made
        if not now.mendable or bench.left <= 0 or (grown and not asked.limits.any):
            break
    return Tuned(asked, first, _tidied(bench, first, now), tuple(changes), bench.used)


def began_at(first: Outcome) -> Mapping[YamlPath, float]:
    """Give the values of all knobs by path."""
    return {knob.path: knob.value for knob in reversed(knobs_for(first))}


def _tidied(bench: Bench, first: Outcome, last: Outcome) -> Outcome:
    """Take out templates that tuning added and no step uses any more: the program is the same without them."""
    used = {name for step in last.recipe.sequence for name in step.paths}
    text = last.text
    for name in last.recipe.templates:
        if name not in first.recipe.templates and name not in used:
            text = remove_value(text, ("templates", name))
    return last if text == last.text else replace(last, text=text, recipe=parse_recipe(text, file=bench.file))
