"""What no machine can do in a day is refused from its strokes, before they are ordered, timed and written."""

import re

import numpy as np
import pytest
from small_boards import board_of, part

from programs.plan import Jet
from recipes.errors import RecipeError
from recipes.load import load_recipe, locate_error, parse_recipe, read_recipe_text
from rulesengine.planning import board_job
from rulesengine.planning.pipeline import make_plan, run
from rulesengine.strokes.stroke import Stroke, StrokeSet
from rulesengine.strokes.workload import Work, measure, require_bounds, require_totals
from rulesengine.timing import sampling
from specs.source import Source

HEAD = "recipe: own\nextends: smt-aqueous\n"
ONE_STEP = "sequence: [{{function: clean, nozzle: ring60, paths: [{}]}}]\n"
WATER = Jet("clean", "ring60", "water", 2.0, True)


def board():
    return board_of(part("U1", 20, 20, 10, 10), part("C1", 60, 20, 2, 1))


def refusal(text):
    with pytest.raises(RecipeError) as caught:
        run(parse_recipe(HEAD + text, file="own.yaml"), board())
    return caught.value


def stroke(**changes):
    ways = {
        "tcp": np.array([[0.0, 0, 50], [30, 0, 50], [30, 40, 50]]),
        "speed_mm_s": 10.0,
        "delays": np.zeros(3),
    } | changes
    down, along = np.tile([0.0, 0.0, -1.0], (3, 1)), np.tile([1.0, 0.0], (3, 1))
    return Stroke(approach=down, azimuth=along, made_by=Source(0, "path"), **ways)


def test_work_is_length_over_speed_and_delays_times_laps_and_repeats():
    open_line = stroke(delays=np.array([0.0, 1.0, 2.0]))
    work = measure([open_line], WATER, Source(0, "path"), 1)
    assert (work.strokes, work.points, work.seconds) == (1, 3, 70 / 10 + 3)
    assert np.isclose(work.litres, work.seconds / 60 * 2.0)
    ring = measure([stroke(closed=True, laps=4)] * 5, WATER, Source(0, "path"), 2)
    assert (ring.strokes, ring.points, ring.seconds) == (10, 120, 10 * 4 * 120 / 10)
    assert measure([open_line], Jet("dry", "knife", "air", 400.0, False), Source(0, "path"), 1).litres == 0


def test_no_motion_takes_less_than_the_work_says():
    recipe = load_recipe("smt-aqueous")
    done = run(recipe, board())
    sprayed = sum(each.seconds for each in _work_of(recipe, done))
    assert 0 < sprayed <= done.program.totals.spray_s


def _work_of(recipe, done):
    for planned in done.cache.known.values():
        if isinstance(planned, StrokeSet):
            yield measure(planned.strokes, WATER, Source(0), 1)


@pytest.mark.parametrize(
    ("text", "path", "message"),
    [
        (
            "templates: {sweep: {speed_mm_s: 0.01, overlap: 0.95}}",
            "templates.sweep",
            "h of spraying. sequence[0]/sweep",
        ),
        ("templates: {sweep: {speed_mm_s: 0.01, overlap: 0.8}}", "templates.sweep", "l. sequence[0]/sweep alone takes"),
        ("templates: {around: {passes: 4, edge_delay_s: 3600}}", "templates.around", "24.0 h of spraying"),
        (
            "templates: {around: {passes: 1000}}\n"
            "sequence: [{function: clean, nozzle: ring60, paths: [around], repeat: 1000}]",
            "templates.around",
            "points",
        ),
        (
            "functions: {clean: {max_speed_mm_s: 10000}}\n"
            "templates: {flush: {repeats: 1000, pitch_mm: 0.1, speed_mm_s: 10000}}\n" + ONE_STEP.format("flush"),
            "templates.flush",
            "a plan has at most 50,000 strokes",
        ),
        ("nozzles: {ring60: {flow_lpm: 10000}}", "templates.edge", "a plan has at most 1,000 l"),
        (
            "nozzles: {ring60: {half_angle_deg: 1, wavefront: {height_mm: 1000, points: "
            "[[0, 0.01, 0.02], [120, 0.01, 0.02], [240, 0.01, 0.02]]}}}",
            "templates.sweep",
            "lines 0.0013 mm apart across 54 mm are more than 10,000. Raise pitch_mm",
        ),
        (
            "limits: {rotation_deg_s: 0.01}",
            "sequence",
            "a plan has at most 24 h and 1,000 l. Raise speeds, or the accelerations",
        ),
    ],
)
def test_what_takes_too_much_is_refused_with_the_entry_and_what_to_change(text, path, message):
    error = refusal(text)
    assert error.path == path
    assert re.search(re.escape(message), str(error)), str(error)


@pytest.mark.parametrize(
    ("amounts", "words"),
    [
        ((50_001, 1, 1, 1), "50,001 strokes"),
        ((1, 2_000_001, 1, 1), "2,000,001 points"),
        ((1, 1, 86_401, 1), "24.0 h"),
        ((1, 1, 1, 1001), "1,001 l"),
    ],
)
def test_the_template_that_takes_the_most_is_named(amounts, words):
    little, much = Work(Source(0, "little"), 1, 1, 0.1, 0.1), Work(Source(1, "much"), *amounts)
    require_bounds([])
    require_bounds([little])
    with pytest.raises(RecipeError, match=words) as caught:
        require_bounds([little, much, little])
    assert caught.value.path == "templates.much"


def test_a_day_and_a_thousand_litres_are_allowed():
    require_totals(86_400, 1000)
    for totals in ((86_401, 1), (1, 1001)):
        with pytest.raises(RecipeError, match="at most 24 h and 1,000 l"):
            require_totals(*totals)


def test_more_moves_than_a_file_holds_are_refused_before_they_are_made(monkeypatch):
    monkeypatch.setattr(sampling, "MOST_MOVES", 100)
    with pytest.raises(RecipeError, match=r"the motion needs [\d,]+ moves; a program has at most 100"):
        run(load_recipe("smt-aqueous"), board())


def test_repeats_of_a_step_are_ordered_once(monkeypatch):

    calls = []
    monkeypatch.setattr(board_job, "order_strokes", lambda *args: calls.append(args) or order(*args))
    order = __import__("rulesengine.planning.stroke_order", fromlist=["order_strokes"]).order_strokes
    text = "sequence: [{function: clean, nozzle: ring60, paths: [sweep, around], repeat: 9}]"
    make_plan(parse_recipe(HEAD + text), board())
    assert len(calls) <= 4


def test_the_line_of_the_entry_is_named_where_it_stands_in_the_users_file():
    loaded = read_recipe_text(HEAD + "templates:\n  sweep: {speed_mm_s: 0.01}\n", file="own.yaml")
    found = RecipeError("takes long", path="templates.sweep")
    assert str(locate_error(found, loaded)) == "own.yaml:4: templates.sweep: takes long"
    inherited = RecipeError("takes long", path="templates.around")
    assert str(locate_error(inherited, loaded)) == "own.yaml: templates.around: takes long"
    assert str(locate_error(RecipeError("no parts"), loaded)) == "no parts"
