from dataclasses import replace

import pytest
from cleaning_report import small_report

from recipes.load import RECIPE, load_recipe, parse_recipe, recipe_library
from rulesengine.planning.pipeline import run
from rulesengine.tuning.changes.candidate_changes import candidate_changes, variables_of
from rulesengine.tuning.changes.reductions import reductions
from rulesengine.tuning.report import suggest
from rulesengine.tuning.trial.outcome import StepSummary, outcome_of
from rulesengine.tuning.trial.request import AllowedChanges, ProgramLimits, read_limits
from rulesengine.tuning.trial.trial_runner import Candidate
from rulesengine.tuning.variables import CHANGE_KINDS, apply_edits, design_variables, read_kinds
from specs.errors import JobError
from specs.yaml.load import read_text

SMT = recipe_library()["smt-aqueous"]
EVERYTHING = AllowedChanges(frozenset(CHANGE_KINDS))
WINDOW = {"clean": (40.0, 71.0)}


@pytest.fixture(scope="module")
def planned():
    report = small_report()
    return run(load_recipe("smt-aqueous"), report.board), report


@pytest.fixture(scope="module")
def outcome(planned):
    return outcome_of(*planned, "clean", read_text(SMT, RECIPE))


def test_every_design_variable_has_the_value_of_the_recipe():
    recipe = load_recipe("smt-aqueous")
    variables = {
        (variable.path, variable.component_class): variable
        for variable in design_variables(recipe, frozenset({"small", "large"}), WINDOW)
    }
    assert variables[("templates", "sweep", "speed_mm_s"), ""].value == 60
    assert variables[("templates", "around", "passes", "small"), "small"].value == 1
    assert variables[("templates", "around", "passes", "large"), "large"].value == 1
    assert variables[("functions", "clean", "temperature_c"), ""].upper == 70
    assert ("templates", "around", "passes", "fine_pitch") not in {path for path, _ in variables}
    for variable in variables.values():
        assert variable.lower <= variable.value <= variable.upper, variable.path


def test_a_speed_never_exceeds_what_any_of_its_functions_allows():
    shared = """recipe: shared
extends: smt-aqueous
sequence:
  - {function: rinse, nozzle: ring60, paths: [flush]}
  - {function: dry, nozzle: knife, paths: [flush]}
"""
    found = design_variables(parse_recipe(shared), frozenset({"small"}), {})
    variables = {variable.path: variable for variable in found}
    flush = variables["templates", "flush", "speed_mm_s"]  # rinses at up to 150 mm/s, dries at up to 80
    assert flush.rounded(1000.0) == 80


@pytest.mark.slow
def test_every_change_and_every_reduction_gives_a_recipe(outcome):
    changes = candidate_changes(outcome, outcome.unmet, EVERYTHING)
    found = reductions(outcome, {}, EVERYTHING).values()
    assert {change.kind for change in changes} >= {"speeds", "passes", "dwells", "sides", "temperature", "wash_time"}
    assert found
    for edits in (*(change.edits for change in changes), *(each.change_to(each.end)[1] for each in found)):
        parse_recipe(apply_edits(outcome.text, SMT, edits), file=SMT)


def test_what_is_not_allowed_or_kept_is_not_touched(outcome):
    kept = (("templates", "around"), ("sequence", 0))
    allowed = AllowedChanges(frozenset({"speeds", "passes", "wash_time"}), kept)
    changes = candidate_changes(outcome, outcome.unmet, allowed)
    assert changes
    assert {change.kind for change in changes} <= {"speeds", "passes", "wash_time"}
    paths = [path for change in changes for path, _ in change.edits]
    paths += [path for each in reductions(outcome, {}, allowed).values() for path, _ in each.change_to(each.end)[1]]
    assert not [path for path in paths if path[:2] in kept or path == ("sequence",)]


def test_the_highest_gain_comes_first(outcome):
    gains = [round(change.most_gain, 6) for change in candidate_changes(outcome, outcome.unmet, EVERYTHING)]
    assert gains == sorted(gains, reverse=True)
    assert gains[-1] > 0


def test_drying_is_not_made_shorter_than_it_was(outcome):
    drying = replace(outcome, steps=(*outcome.steps, StepSummary("sequence[2]", "dry", "dry", 10.0, None)))
    initial = {variable.path: variable.value for variable in variables_of(outcome)}
    dries = "templates.blow.speed_mm_s "
    assert dries in reductions(outcome, initial, EVERYTHING)
    assert dries not in reductions(drying, initial, EVERYTHING)
    slower = initial | {("templates", "blow", "speed_mm_s"): 60.0}
    assert reductions(drying, slower, EVERYTHING)[dries].end == 60
    assert all(set(each.steps) != {"sequence[2]"} for each in reductions(drying, initial, EVERYTHING).values())


def test_a_reduction_goes_part_of_the_way_by_time(outcome):
    faster = reductions(outcome, {}, EVERYTHING)["templates.sweep.speed_mm_s "]
    assert (faster.begin, faster.end) == (60, 120)
    assert faster.value_at(1.0) == 120
    assert faster.value_at(0.5) == 80  # half of the time saved: 1/80 is half way from 1/60 to 1/120
    assert faster.value_at(0.0) is None
    assert faster.bisect(60, 61) is None


@pytest.mark.slow
def test_each_component_that_is_not_clean_is_given_a_few_edits(planned, outcome):
    suggestions = suggest(*planned)
    open_components = {each.component for each in outcome.unmet}
    assert {each.component for each in suggestions} <= open_components
    assert "U1" in {each.component for each in suggestions}
    for each in suggestions:
        assert dict(each.edits) == each.values
        parse_recipe(apply_edits(read_text(SMT, RECIPE), SMT, each.edits), file=SMT)
        assert sum(other.component == each.component for other in suggestions) <= 3
    assert suggestions == suggest(*planned)


def test_limits_are_read():
    assert read_limits(["time=600", "litres=2.5"]) == ProgramLimits(600, 2.5)
    assert read_limits([]).excess(Candidate("", 1e9, 1e9)) == 0
    assert ProgramLimits(100, 10).excess(Candidate("", 150, 12)) == pytest.approx(0.7)
    assert ProgramLimits(100, 10).excess(Candidate("", 100, 10)) == 0


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
