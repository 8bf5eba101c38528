"""What a recipe leaves to the board: heights by its size, steps by its sides, repeats by a least time."""

import pytest
from shapely import affinity, box
from small_boards import board_of, part

from programs.program import SetNozzle
from recipes.errors import RecipeError
from recipes.load import parse_recipe, recipe_sha256
from rulesengine.planning.fit_recipe import fit_recipe, fitted_heights, left_out, spray_times
from rulesengine.planning.pipeline import run

HEAD = """
recipe: fitted
extends: smt-aqueous
nozzles: {ring60: {wavefront: null}}
templates:
  across: {path: raster, height_mm: auto, speed_mm_s: 50, margin_mm: 5}
  lanes: {path: final_flush, height_mm: auto, speed_mm_s: 80, direction_deg: across_longest_edge}
"""


def recipe_of(*steps, more=""):
    lines = "\n".join(f"  - {{function: clean, nozzle: ring60, {step}}}" for step in steps)
    return parse_recipe(f"{HEAD}{more}sequence:\n{lines}\n")


def height_on(width, length=100.0, turn_deg=0.0, more=""):
    outline = affinity.rotate(box(0, 0, length, width, ccw=True), turn_deg)
    fitted = fit_recipe(recipe_of("paths: [across]", more=more), board_of(outline=outline))
    return fitted.templates["across"].height_mm


@pytest.mark.parametrize(
    ("width", "height"),
    [
        (30.0, 20.0),  # 0.8 * 30 / (2 tan 30) = 20.8
        (50.0, 34.0),  # 34.6
        (70.0, 48.0),  # 48.5
        (10.0, 20.0),  # the least there is
        (100.0, 60.0),  # the greatest
    ],
)
def test_the_spray_is_at_most_so_wide_as_most_of_the_board(width, height):
    assert height_on(width) == height
    assert height_on(width, turn_deg=37.0) == height


def test_an_automatic_height_is_above_the_clearance():
    assert height_on(20.0, more="limits: {clearance_mm: 24.5}\n") == 25.0


def test_a_board_that_is_no_rectangle_counts_by_its_mean_width():
    cross = box(0, 20, 100, 40, ccw=True).union(box(40, 0, 60, 60))  # 2,800 mm2 over 100 mm
    fitted = fit_recipe(recipe_of("paths: [across]"), board_of(outline=cross))
    assert fitted.templates["across"].height_mm == 20.0


def test_what_the_recipe_states_stays():
    recipe = recipe_of("paths: [edge]").model_copy(update={"templates": {}})
    assert fit_recipe(recipe, board_of()) is recipe


def test_only_what_was_automatic_is_told():
    recipe = recipe_of("paths: [across, around]")
    fitted = fit_recipe(recipe, board_of(outline=box(0, 0, 100, 50, ccw=True)))
    assert fitted_heights(recipe, fitted) == {"across": 34.0}
    assert fitted.templates["lanes"].height_mm == "auto"  # no step follows it


def test_steps_for_a_side_without_components_are_left_out():
    recipe = recipe_of("paths: [across]", "paths: [across], side: bottom, only_with_parts: true")
    top, bottom = part("C1", 20, 20, 2, 1), part("C2", 60, 20, 2, 1, side="bottom")
    assert left_out(recipe, fit_recipe(recipe, board_of(top))) == (1,)
    assert left_out(recipe, fit_recipe(recipe, board_of(top, bottom))) == ()
    assert left_out(recipe, fit_recipe(recipe, board_of())) == ()  # a bare board tells nothing
    done = run(recipe, board_of(top))
    assert {each.made_by.step for each in done.program.instructions} == {0}
    assert done.program.origin.recipe_sha256 == recipe_sha256(recipe)


def test_a_recipe_for_the_other_side_alone_is_refused():
    recipe = recipe_of("paths: [across], side: bottom, only_with_parts: true")
    with pytest.raises(RecipeError, match="no step is left for boxes: all have only_with_parts"):
        run(recipe, board_of(part("C1", 20, 20, 2, 1)))


def sprayed_s(done, steps):
    switches = [
        each for each in done.program.instructions if isinstance(each, SetNozzle) and each.made_by.step in steps
    ]
    return sum(off.time_s - on.time_s for on, off in zip(switches[::2], switches[1::2], strict=True))


@pytest.mark.parametrize("least", [20.0, 60.0, 90.0])
def test_the_last_path_is_done_again_until_the_least_time_is_reached(least):
    board = board_of()
    once = run(recipe_of("paths: [across, lanes]"), board)
    done = run(recipe_of(f"paths: [across, lanes], least_time_s: {least}"), board)
    each = sprayed_s(run(recipe_of("paths: [across, lanes, lanes]"), board), {0}) - sprayed_s(once, {0})
    lasts = sprayed_s(done, {0})
    assert lasts >= least
    times = done.again.get(0, 0)
    assert lasts == pytest.approx(sprayed_s(once, {0}) + times * each, rel=0.05)
    if times:  # one less would not do
        assert lasts - 0.95 * each < least
    assert not [finding for finding in done.findings if finding.rule.id == "least-time-missed"]


def test_steps_of_the_same_function_and_side_count_together():
    first, second = run(recipe_of("paths: [across]"), board_of()), run(recipe_of("paths: [lanes]"), board_of())
    least = 0.99 * (sprayed_s(first, {0}) + sprayed_s(second, {0}))  # corners and directions differ a little
    done = run(recipe_of("paths: [across]", f"paths: [lanes], least_time_s: {least}"), board_of())
    assert not done.again
    spans = spray_times(done.fitted, done.program)
    assert spans[0] == pytest.approx(sprayed_s(done, {0}))
    assert spans[1] == pytest.approx(sprayed_s(done, {0, 1}))


def test_a_least_time_that_the_last_path_cannot_reach_is_a_finding():
    more = "masks: [{ignore: ['*']}]\n"
    recipe = recipe_of("paths: [across, around], least_time_s: 300", more=more)
    done = run(recipe, board_of(part("C1", 20, 20, 2, 1)))
    assert not done.again
    (finding,) = [each for each in done.findings if each.rule.id == "least-time-missed"]
    assert "repeating around does not make it the 300 s of least_time_s" in finding.message
    assert str(finding.made_by) == "sequence[0]"


def test_a_least_time_and_a_sensor_are_refused_together():
    until = "until: {temperature_c: 40, max_repeats: 3}"
    with pytest.raises(RecipeError, match="give least_time_s or until, not both"):
        recipe_of(f"paths: [across], least_time_s: 60, {until}")


def test_the_same_recipe_gives_the_same_program_whatever_ran_before():
    recipe, board = recipe_of("paths: [across, lanes], least_time_s: 90"), board_of()
    first = run(recipe, board)
    again = run(recipe, board, before=run(recipe_of("paths: [across, lanes]"), board))
    assert first.program == again.program
    assert first.again == again.again
