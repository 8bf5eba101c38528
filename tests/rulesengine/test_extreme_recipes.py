"""Whatever the bounds of a recipe allow: one clear error, or a program that can be read."""

from copy import deepcopy
from unittest.mock import patch

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from small_boards import board_of, part

from programs import native
from programs.program import TimedProgram
from recipes.consistency import find_problems
from recipes.errors import RecipeError
from recipes.load import RECIPE, load_recipe
from recipes.recipe import Recipe
from rulesengine.planning.pipeline import run
from rulesengine.timing import sampling
from specs.yaml.schema import known_keys

BASE = load_recipe("smt-aqueous").model_dump(mode="json", by_alias=True, exclude_none=True)
BOARD = board_of(part("U1", 20, 20, 10, 10, 4), part("C1", 60, 20, 2, 1))


def bounded(tree, path=()):
    """Path, bounds and type of each number of the recipe."""
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from bounded(value, (*path, key))
        elif isinstance(value, int | float) and not isinstance(value, bool):
            schema = known_keys(path, BASE, RECIPE).get(key, {})
            for each in schema.get("anyOf", [schema]):
                if each.get("type") in ("number", "integer"):
                    least = each.get("minimum", each.get("exclusiveMinimum"))
                    most = each.get("maximum", each.get("exclusiveMaximum"))
                    yield (*path, key), least, most, each["type"] == "integer"


NUMBERS = list(bounded(BASE))


@st.composite
def extreme_recipes(draw):
    """The default recipe with a few of its numbers anywhere within their bounds, often at an end."""
    values = deepcopy(BASE)
    for path, least, most, whole in draw(st.lists(st.sampled_from(NUMBERS), min_size=1, max_size=4)):
        between = st.integers(least, most) if whole else st.floats(least, most)
        near = st.floats(-3, 3).map(lambda power, least=least, most=most: min(max(10**power, least), most))
        value = draw(st.sampled_from([least, most]) | (between if whole else between | near))
        node = values
        for key in path[:-1]:
            node = node[key]
        node[path[-1]] = value
    try:
        recipe = Recipe.model_validate(values)
    except ValueError:  # an end that is open
        assume(False)
        raise
    assume(not find_problems(recipe))
    return recipe


def check(recipe: Recipe) -> TimedProgram | None:
    """Plan it, and hold what is written against what is read; programs of many moves are refused to save time."""
    try:
        with patch.object(sampling, "MOST_MOVES", 8000):
            program = run(recipe, BOARD).program
    except RecipeError:
        return None
    text = native.render(program)
    assert native.render(native.parse(text)) == text
    return program


def test_the_numbers_of_all_sections_are_drawn():
    assert {path[0] for path, *_ in NUMBERS} == {"functions", "nozzles", "classes", "templates", "limits"}
    assert len(NUMBERS) > 50


@pytest.mark.slow
@settings(
    max_examples=12,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)
@given(recipe=extreme_recipes())
def test_a_recipe_at_its_bounds_is_refused_or_planned_and_read_back(recipe):
    check(recipe)
