"""Boards that nobody would make on purpose: planned without a complaint from the independent reader."""

from functools import cache

import numpy as np
import pytest
from acceptance import complaints
from hostile import BOARDS, at, board_with, grid_of_parts, recipe_with
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_recipes import recipes
from rigid import Motion, differences, moved_bodies, moved_recipe

from boards.board import Board
from boards.understand import understand
from programs import native
from programs.native import parse
from recipes.load import load_recipe
from rulesengine.modifiers import lowest_profile
from rulesengine.planning.pipeline import make_plan, run
from rulesengine.strokes.safe_height import floors
from specs.errors import JobError

LIMITS = {
    "as they are": ({}, {}),
    "clearance 15": ({"clearance_mm": 15.0}, {}),
    "corners cut by 5": ({"blend_mm": 5.0}, {}),
    "corners cut by 20, clearance 2": ({"blend_mm": 20.0, "clearance_mm": 2.0}, {}),
    "low, clearance 1": ({"clearance_mm": 1.0}, {"height_mm": 6.0}),
    "just above the clearance": ({"clearance_mm": 5.0}, {"height_mm": 5.1}),
}


CHANGED = list(LIMITS)[1:]
TWO_EACH = [(name, CHANGED[(number + step) % len(CHANGED)]) for number, name in enumerate(BOARDS) for step in (0, 2)]
"""Each board with two of the changed limits, each of these with at least six boards."""


BUILT = cache(lambda name: BOARDS[name]())


@pytest.mark.slow
@pytest.mark.parametrize("name", BOARDS)
def test_no_complaints(name):
    assert complaints(run(load_recipe("smt-aqueous"), BUILT(name))) == []


@pytest.mark.slow
@pytest.mark.parametrize(("name", "limits"), TWO_EACH)
def test_no_complaints_whatever_the_limits(name, limits):
    assert complaints(run(recipe_with(*LIMITS[limits]), BUILT(name))) == []


@pytest.mark.slow
@pytest.mark.parametrize("recipe", ["low-standoff", "rinse-only", "dry-only"])
@pytest.mark.parametrize("name", BOARDS)
def test_no_complaints_with_any_recipe(name, recipe):
    assert complaints(run(load_recipe(recipe), BUILT(name))) == []


@pytest.mark.slow
def test_a_path_over_many_bodies_grows_with_their_number_and_not_its_square():
    recipe = recipe_with({"clearance_mm": 5.0}, {"height_mm": 5.3})
    counts = []
    for rows in (5, 10):
        plan = make_plan(recipe, board_with(*grid_of_parts(24 * rows), outline=at(0, 0, 65, 30)))
        counts.append(sum(len(item.tcp) for item in plan.moving()))
    assert counts[1] < 2.5 * counts[0]


@given(
    spans=st.lists(st.tuples(st.floats(0, 100), st.floats(0, 30), st.floats(0, 50)), min_size=1, max_size=12),
    extra=st.floats(0, 3),
)
@settings(max_examples=100)
def test_the_lowest_profile_is_that_of_each_span_alone(spans, extra):
    spans = [(start, start + length, floor) for start, length, floor in spans]
    needed = lowest_profile(spans, extra)
    where = np.concatenate([np.linspace(-60, 190, 701), needed.bends(5.0)[1:-1]])
    alone = [floor + extra - np.maximum(np.maximum(start - where, where - end), 0) for start, end, floor in spans]
    np.testing.assert_allclose(needed.at(where), np.max(alone, axis=0), atol=2e-4)


def test_zones_leave_room_for_cut_corners():
    board = BOARDS["towers"]()
    plain, roomy = floors(board, "top", 5.0), floors(board, "top", 5.0, 2.0)
    for one, other in zip(plain.zones, roomy.zones, strict=True):
        assert other.buffer(1e-6).covers(one.buffer(2.0))
    np.testing.assert_array_equal(plain.heights, roomy.heights)
    assert roomy.corner_mm >= 2.0


ANY = settings(derandomize=True, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow])
TURNED = Motion(37, (137.31, -88.07, 2.5))


@cache
def turned(name) -> Board:
    return understand(moved_bodies(BUILT(name).bodies, TURNED), "hostile")


def plan_or_refuse(recipe, board):
    """The run, or the words of the one error that a board without anything to do gives."""
    try:
        return run(recipe, board)
    except JobError as error:
        return str(error)


def check_any(recipe, name):
    done = plan_or_refuse(recipe, BUILT(name))
    if isinstance(done, str):
        assert "there is nothing to spray" in done
        return
    text = native.render(done.program)
    assert native.render(parse(text)) == text
    assert complaints(done) == []


def check_moved(recipe, name):
    here, there = plan_or_refuse(recipe, BUILT(name)), plan_or_refuse(moved_recipe(recipe, TURNED), turned(name))
    if isinstance(here, str):
        assert here == there
        return
    assert differences(here.program, there.program, TURNED) == []
    told = [[(each.rule.id, each.message, str(each.made_by)) for each in done.findings] for done in (here, there)]
    assert told[0] == told[1]


def moves_with_the_board(recipe):
    """Whether no path begins at a corner that is named by how the board lies."""
    return all(getattr(spec, "start", "auto") in ("auto", "first", "last") for spec in recipe.templates.values())


@pytest.mark.slow
@pytest.mark.long
@given(recipe=recipes(), name=st.sampled_from(list(BOARDS)))
@settings(ANY, max_examples=60)
def test_no_complaints_about_any_recipe_on_any_board(recipe, name):
    check_any(recipe, name)


@pytest.mark.slow
@pytest.mark.long
@given(recipe=recipes().filter(moves_with_the_board), name=st.sampled_from(list(BOARDS)))
@settings(ANY, max_examples=50)
def test_any_recipe_moves_with_any_board(recipe, name):
    check_moved(recipe, name)
