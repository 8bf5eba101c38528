"""A run after an edit is the run of the edited recipe, whatever was remembered; and only what changed is planned."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from brief_recipe import BRIEF
from shapely import box
from small_boards import board_of, part

from boards.load import load_board
from geometry.coverage.route import forget_routes
from programs.native import render
from programs.plan import SprayPass
from recipes.recipe import Recipe
from rulesengine.planning import board_job as job
from rulesengine.planning.pipeline import run

BIG = "sensor-hub"
LINE = {"path": "straight_line", "from": [5, 5], "to": [40, 25], "height_mm": 50, "speed_mm_s": 30}


def edited(recipe, *path_and_value):
    *path, key, value = path_and_value
    data = recipe.model_dump(mode="json", by_alias=True, exclude_none=True)
    place = data
    for each in path:
        place = place[each]
    if value is None:
        del place[key]
    else:
        place[key] = value
    return Recipe.model_validate(data)


def around(key, value):
    return lambda recipe: edited(recipe, "templates", "around", key, value)


def with_line(recipe):
    added = edited(recipe, "templates", "line", LINE)
    return edited(added, "sequence", 0, "paths", [*recipe.sequence[0].paths, "line"])


EDITS = {
    "speed": around("speed_mm_s", 33),
    "speed by class": around("speed_mm_s", {"small": 25, "default": 35}),
    "height": around("height_mm", 47),
    "tilt": around("tilt_deg", 37),
    "passes": around("passes", 1),
    "gap": around("merge_gap_mm", 3),
    "class rule": lambda recipe: edited(recipe, "classes", "small", "area_mm2", {"max": 4}),
    "mask": lambda recipe: edited(recipe, "masks", [{"avoid": ["C*"], "margin_mm": 2}]),
    "another mask": lambda recipe: edited(recipe, "masks", [{"ignore": ["C*"]}]),
    "nozzle": lambda recipe: edited(recipe, "nozzles", "ring60", "half_angle_deg", 32),
    "pressure": lambda recipe: edited(recipe, "functions", "clean", "pressure_bar", 3),
    "clearance": lambda recipe: edited(recipe, "limits", "clearance_mm", 8),
    "acceleration": lambda recipe: edited(recipe, "limits", "acceleration_mm_s2", 700),
    "one template more": with_line,
    "one template less": lambda recipe: edited(recipe, "sequence", 0, "paths", ["edge", "around"]),
    "another order": lambda recipe: edited(recipe, "sequence", recipe.model_dump(mode="json")["sequence"][::-1]),
    "a step less": lambda recipe: edited(recipe, "sequence", 1, "enabled", False),
}
LONG = ("tilt", "class rule", "speed by class", "acceleration", "another order", "a step less")
"""Edits after which most is planned again; the others of their sort stay in the quick part."""


def new_board(name=""):
    """A board that nothing is known about."""
    if name:
        return load_board(Path(name))
    rows = (
        part(f"C{row}{at}", 4 + 12 * at + row, 3 + 9 * row, 2 + at % 3, 2 + row) for row in range(3) for at in range(4)
    )
    return board_of(*rows, part("U1", 10, 30, 8, 6, pins=64), outline=box(0, 0, 52, 40, ccw=True))


@cache
def first(name=""):
    return run(BRIEF, new_board(name))


def planned_anew(recipe, name=""):
    forget_routes()
    return run(recipe, new_board(name))


def same(one, other):
    return render(one.program) == render(other.program) and one.findings == other.findings


@pytest.mark.slow
@pytest.mark.parametrize("kind", [pytest.param(kind, marks=pytest.mark.slow if kind in LONG else ()) for kind in EDITS])
def test_a_run_after_an_edit_is_the_run_of_the_edited_recipe(kind):
    before = first()
    after = run(EDITS[kind](before.recipe), before.board, sketched=lambda _: None, before=before)
    assert same(after, planned_anew(after.recipe))
    assert not same(after, before)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["", pytest.param(BIG, marks=pytest.mark.long)])
def test_many_edits_and_their_undoing_lead_to_where_planning_anew_does(name):
    begin = now = first(name)
    for kind in ("height", "one template more", "speed", "mask", "class rule", "tilt"):
        now = run(EDITS[kind](now.recipe), now.board, sketched=lambda _: None, before=now)
    assert same(now, planned_anew(now.recipe, name))
    assert same(run(begin.recipe, now.board, before=now), begin)


@pytest.fixture
def planned(monkeypatch):
    """The templates that are planned, in order; the run that all begin with was planned before."""
    first()
    names, plan_path = [], job.plan_path

    def listen(spec, site):
        names.append(str(site.made_by))
        return plan_path(spec, site)

    monkeypatch.setattr(job, "plan_path", listen)
    return names


@pytest.mark.slow
def test_only_the_template_that_changed_is_planned_again(planned):
    before = first()
    after = run(EDITS["height"](before.recipe), before.board, before=before)
    assert planned == ["sequence[0]/around"]
    run(EDITS["speed"](after.recipe), before.board, before=after)
    assert planned == ["sequence[0]/around"] * 2


def test_a_template_that_two_steps_use_is_planned_once_and_followed_by_both(planned):
    before = first()
    after = run(edited(before.recipe, "templates", "sweep", "height_mm", 55), before.board, before=before)
    assert planned == ["sequence[0]/sweep"]
    ways = {0: [], 1: []}
    for each in after.plan.items:
        if isinstance(each, SprayPass) and each.made_by.template == "sweep":
            ways[each.made_by.step].append(each.tcp)
    assert ways[0]
    assert all(np.array_equal(one, other) for one, other in zip(*ways.values(), strict=True))


def test_a_run_on_another_board_says_nothing_about_this_one():
    recipe = first().recipe
    tiny = run(recipe, load_board(Path("tiny")), before=first())
    forget_routes()
    assert same(tiny, run(recipe, load_board(Path("tiny"))))


def test_a_sketch_has_all_strokes_in_another_order():
    before, sketches = first(), []
    forget_routes()
    after = run(EDITS["height"](before.recipe), before.board, sketched=sketches.append, before=before)
    (sketch,) = sketches
    assert sorted(str(each.made_by) for each in sketch.moving()) == sorted(
        str(each.made_by) for each in after.plan.moving()
    )
    assert [str(each.made_by) for each in sketch.moving()] != [str(each.made_by) for each in after.plan.moving()]


@pytest.mark.slow
def test_what_is_settled_at_once_is_sketched_before_it_is_timed():
    before, sketches = first(), []
    after = run(EDITS["height"](before.recipe), before.board, before=before)
    again = run(EDITS["speed"](after.recipe), before.board, sketched=sketches.append, before=after)
    (sketch,) = sketches
    assert sketch.items == again.plan.items
    assert same(again, planned_anew(again.recipe))


@pytest.mark.slow
def test_a_search_can_be_given_up_and_nothing_of_it_stays():
    def give_up(what, _):
        if what.startswith("refining"):
            raise InterruptedError

    before = first()
    forget_routes()
    recipe = EDITS["height"](before.recipe)
    with pytest.raises(InterruptedError):
        run(recipe, before.board, give_up, lambda _: None, before)
    assert same(run(recipe, before.board, before=before), planned_anew(recipe))


def test_progress_grows_from_nothing_to_all():
    told = []
    forget_routes()
    before = first()
    run(EDITS["tilt"](before.recipe), before.board, lambda what, done: told.append((done, what)), lambda _: None)
    shares = [done for done, _ in told]
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert told[-1] == (1.0, "done")
    assert sum("refining the order" in what for _, what in told) > 10
