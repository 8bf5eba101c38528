from dataclasses import replace

import pytest
from cleaning_report import small_report

from recipes.load import RECIPE, load_recipe, parse_recipe, recipe_library
from rulesengine.planning.pipeline import run
from rulesengine.tuning.changes.candidate_changes import knobs_for, moves_of
from rulesengine.tuning.changes.reductions import cuts_of
from rulesengine.tuning.suggest import suggest
from rulesengine.tuning.trial.outcome import Did, outcome_of
from rulesengine.tuning.trial.request import Allowed, Limits, read_limits
from rulesengine.tuning.variables.design_variables import KINDS, knobs_of, read_kinds
from rulesengine.tuning.variables.recipe_edits import apply_edits
from specs.errors import JobError
from specs.yaml.load import read_text

SMT = recipe_library()["smt-aqueous"]
EVERYTHING = Allowed(frozenset(KINDS))
WINDOW = {"clean": (40.0, 71.0)}


@pytest.fixture(scope="module")
def planned():
    report = small_report()
    return run(load_recipe("smt-aqueous"), report.board), report


@pytest.fixture(scope="module")
def outcome(planned):
    return outcome_of(*planned, "clean", read_text(SMT, RECIPE))


def test_every_knob_says_what_the_recipe_says():
    recipe = load_recipe("smt-aqueous")
    knobs = {(knob.path, knob.of_class): knob for knob in knobs_of(recipe, frozenset({"small", "large"}), WINDOW)}
    assert knobs[("templates", "sweep", "speed_mm_s"), ""].value == 60
    assert knobs[("templates", "around", "passes", "small"), "small"].value == 2
    assert knobs[("templates", "around", "passes", "large"), "large"].value == 4
    assert knobs[("functions", "clean", "temperature_c"), ""].most == 70
    assert ("templates", "around", "passes", "fine_pitch") not in {path for path, _ in knobs}
    for knob in knobs.values():
        assert knob.least <= knob.value <= knob.most, knob.path


def test_a_speed_never_exceeds_what_any_of_its_functions_allows():
    knobs = {knob.path: knob for knob in knobs_of(load_recipe("smt-aqueous"), frozenset({"small"}), {})}
    flush = knobs["templates", "flush", "speed_mm_s"]  # rinses at up to 150 mm/s, dries at up to 80
    assert flush.moved(1000.0) == 80


@pytest.mark.slow
def test_every_move_and_every_cut_gives_a_recipe(outcome):
    moves = moves_of(outcome, outcome.wants, EVERYTHING)
    cuts = cuts_of(outcome, {}, EVERYTHING).values()
    assert {move.kind for move in moves} >= {"speeds", "passes", "dwells", "sides", "temperature", "wash_time"}
    assert cuts
    for edits in (*(move.edits for move in moves), *(cut.at(cut.end)[1] for cut in cuts)):
        parse_recipe(apply_edits(outcome.text, SMT, edits), file=SMT)


def test_what_is_not_allowed_or_kept_is_not_touched(outcome):
    kept = (("templates", "around"), ("sequence", 0))
    allowed = Allowed(frozenset({"speeds", "passes", "wash_time"}), kept)
    moves = moves_of(outcome, outcome.wants, allowed)
    assert moves
    assert {move.kind for move in moves} <= {"speeds", "passes", "wash_time"}
    paths = [path for move in moves for path, _ in move.edits]
    paths += [path for cut in cuts_of(outcome, {}, allowed).values() for path, _ in cut.at(cut.end)[1]]
    assert not [path for path in paths if path[:2] in kept or path == ("sequence",)]


def test_the_most_gain_comes_first(outcome):
    gains = [round(move.most, 6) for move in moves_of(outcome, outcome.wants, EVERYTHING)]
    assert gains == sorted(gains, reverse=True)
    assert gains[-1] > 0


def test_drying_is_not_made_shorter_than_it_was(outcome):
    drying = replace(outcome, steps=(*outcome.steps, Did("sequence[2]", "dry", "dry", 10.0, None)))
    began = {knob.path: knob.value for knob in knobs_for(outcome)}
    shared = "templates.flush.speed_mm_s "  # rinses and dries
    assert shared in cuts_of(outcome, began, EVERYTHING)
    assert shared not in cuts_of(drying, began, EVERYTHING)
    slower = began | {("templates", "flush", "speed_mm_s"): 60.0}
    assert cuts_of(drying, slower, EVERYTHING)[shared].end == 60
    assert all(set(cut.steps) != {"sequence[2]"} for cut in cuts_of(drying, began, EVERYTHING).values())


def test_a_cut_goes_part_of_the_way_by_time(outcome):
    faster = cuts_of(outcome, {}, EVERYTHING)["templates.sweep.speed_mm_s "]
    assert (faster.begin, faster.end) == (60, 120)
    assert faster.part(1.0) == 120
    assert faster.part(0.5) == 80  # half of the time saved: 1/80 is half way from 1/60 to 1/120
    assert faster.part(0.0) is None
    assert faster.halfway(60, 61) is None


def test_each_component_that_is_not_clean_is_given_a_few_edits(planned, outcome):
    suggestions = suggest(*planned)
    lacking = {want.component for want in outcome.wants}
    assert {each.component for each in suggestions} <= lacking
    assert "U1" in {each.component for each in suggestions}
    for each in suggestions:
        assert dict(each.edits) == each.values
        parse_recipe(apply_edits(read_text(SMT, RECIPE), SMT, each.edits), file=SMT)
        assert sum(other.component == each.component for other in suggestions) <= 3
    assert suggestions == suggest(*planned)


def test_limits_are_read():
    assert read_limits(["time=600", "litres=2.5"]) == Limits(600, 2.5)
    assert read_limits([]).excess(1e9, 1e9) == 0
    assert Limits(100, 10).excess(150, 12) == pytest.approx(0.7)
    assert Limits(100, 10).excess(100, 10) == 0


@pytest.mark.parametrize("word", ["time", "time=", "time=-1", "time=nan", "time=inf", "minutes=3", "litres=0", "=3"])
def test_a_limit_that_means_nothing_is_refused(word):
    with pytest.raises(JobError, match=r"--limit"):
        read_limits([word])


def test_a_limit_that_stands_twice_is_refused():
    with pytest.raises(JobError, match="stands twice"):
        read_limits(["time=1", "time=2"])


def test_kinds_are_read():
    assert read_kinds("speeds, passes") == {"speeds", "passes"}
    with pytest.raises(JobError, match="did you mean 'speeds'"):
        read_kinds("speed")
    with pytest.raises(JobError, match="allows nothing"):
        read_kinds(",")
