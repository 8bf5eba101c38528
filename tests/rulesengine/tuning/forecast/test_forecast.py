"""Forecasts of longer and shorter spraying, against analyses of just that."""

from pathlib import Path

import numpy as np
import pytest

from boards.load import load_board
from cleaning.analyse import analyse_on
from cleaning.parameters.load import load_parameters
from cleaning.prepared_board import prepare
from cleaning.verdicts import rules
from recipes.load import parse_recipe, recipe_library
from rulesengine.planning.pipeline import run
from rulesengine.tuning.changes.candidate_changes import variables_of
from rulesengine.tuning.forecast.forecast import Corrections, correct, forecast
from rulesengine.tuning.forecast.minimum_times import SpeedCurve, plan_speeds, speed_curves
from rulesengine.tuning.trial.outcome import deposits_of
from rulesengine.tuning.trial.requirements import Key
from rulesengine.tuning.trial.trial_runner import TrialRunner
from rulesengine.tuning.variables import DesignVariable

FILE = recipe_library()["smt-aqueous"].with_name("own.yaml")
TEXT = """recipe: two
extends: smt-aqueous
templates:
  sweep: {speed_mm_s: 40}
  around: {path: component_perimeter, height_mm: 40, speed_mm_s: 30, tilt_deg: 39}
sequence:
  - {function: clean, nozzle: ring60, paths: [sweep, around], repeat: 2}
  - {function: rinse, nozzle: ring60, paths: [around]}
"""
LONGER = TEXT.replace("speed_mm_s: 40", "speed_mm_s: 16").replace("repeat: 2", "repeat: 3")


@pytest.fixture(scope="module")
def runner():
    return TrialRunner(FILE, prepare(load_board(Path("tiny")), load_parameters(), lambda *_: None), "clean", 9)


@pytest.fixture(scope="module")
def outcome(runner):
    return runner.first(TEXT)


@pytest.mark.slow
def test_deposits_add_up_to_what_each_stage_leaves(runner):
    planned = run(parse_recipe(TEXT, file=FILE), runner.prepared.board)
    report = analyse_on(runner.prepared, planned.program, planned.recipe, "fast")
    deposits = deposits_of(report)
    assert [(each.step, each.template) for each in deposits.each] == [
        ("sequence[0]", "sweep"),
        ("sequence[0]", "around"),
        ("sequence[1]", "around"),
    ]
    for stage, exposure in zip(report.stages, report.exposures, strict=True):
        own = [each for each in deposits.each if each.step == str(stage.made_by)]
        assert sum(each.seconds for each in own) == pytest.approx(stage.spray_s)
        np.testing.assert_allclose(sum(each.volume_mm for each in own), exposure.supply_mm, rtol=1e-4, atol=1e-4)


@pytest.mark.slow
def test_the_present_is_predicted_as_it_is(outcome):
    predicted = forecast(outcome, Corrections())
    now = np.ones(len(predicted.deposits.each))
    assert predicted.seconds(now, {}) == pytest.approx(outcome.seconds)
    assert predicted.bounds
    judged = {(each.component, each.judgement.rule, each.judgement.stage): each for each in outcome.met}
    for bound in predicted.bounds:
        if bound.kind == "low" and bound.key in judged:
            value = judged[bound.key].judgement.numbers[0].value
            assert bound.amount(now, predicted.durations(now, {})) == pytest.approx(value, rel=1e-3)


@pytest.mark.slow
def test_slower_and_more_often_is_predicted_as_it_comes_out(runner, outcome):
    predicted = forecast(outcome, Corrections())
    planned = runner.spray_durations(LONGER)
    now = {(each.step, each.template): each.seconds for each in predicted.deposits.each}
    times = np.array([planned[source] / seconds for source, seconds in now.items()])
    repeats = {"sequence[0]": 1.5}
    came = runner.outcome(LONGER)
    assert predicted.seconds(times, repeats) == pytest.approx(came.seconds, rel=0.02)
    durations = predicted.durations(times, repeats)
    after = forecast(came, Corrections())
    compared = 0
    for bound in predicted.bounds:
        other = next((each for each in after.bounds if each.key == bound.key and each.kind == "low"), None)
        if bound.kind == "low" and other is not None:
            ones = np.ones(len(times))
            assert bound.amount(times, durations) == pytest.approx(other.amount(ones, {}), rel=0.35), bound.key
            compared += 1
    assert compared >= 5


@pytest.mark.slow
def test_slopes_come_to_the_amount(outcome):
    predicted = forecast(outcome, Corrections())
    times = np.linspace(0.7, 1.4, len(predicted.deposits.each))
    for bound in predicted.bounds:
        if bound.kind == "low":
            slopes = bound.slopes(times)
            assert (slopes >= 0).all()
            assert slopes @ times[list(bound.which)] == pytest.approx(bound.amount(times, {}), rel=1e-9)


@pytest.mark.slow
def test_bounds_rise_where_less_was_found_than_predicted(runner, outcome):
    predicted = forecast(outcome, Corrections())
    hurried = runner.outcome(TEXT.replace("speed_mm_s: 30", "speed_mm_s: 100").replace("repeat: 2", "repeat: 1"))
    assert hurried.shortfall > outcome.shortfall
    corrections = Corrections()
    times = np.full(len(predicted.deposits.each), 0.5)
    assert correct(corrections, predicted, hurried, times, {})
    assert corrections.margins or corrections.means
    assert all(margin > 0 for margin in corrections.margins.values())
    for key, (least, steps) in corrections.means.items():
        assert least > 0
        assert steps, key
    assert not correct(Corrections(), predicted, outcome, times, {})


SPEED = DesignVariable(
    "speeds", ("templates", "sweep", "speed_mm_s"), 40.0, 5.0, 150.0, 1.0, -1.0, ("sequence[0]",), "sweep"
)


@pytest.mark.slow
def test_what_is_owed_is_required_in_full_and_what_is_not_met_only_kept(outcome):
    residues = [each for each in outcome.attainable if each.rule == rules.RESIDUE_LEFT and each.deficit < 0.8]
    assert residues
    kept, owed = (
        {bound.key: bound.least for bound in forecast(outcome, Corrections(), owed=keys).bounds if bound.kind == "time"}
        for keys in (frozenset[Key](), frozenset(each.key for each in residues))
    )
    for each in residues:  # the deficit of a residue is the share of its time that is missing
        assert owed[each.key] == pytest.approx(kept[each.key] / (1.0 - each.deficit))
    corrections = Corrections(margins={residues[0].key: 1.2})
    more = forecast(outcome, corrections, owed=frozenset({residues[0].key})).bounds
    least = next(bound.least for bound in more if bound.key == residues[0].key)
    assert least == pytest.approx(1.2 * owed[residues[0].key])


def test_a_speed_between_two_that_are_known_goes_with_the_inverse_of_time():
    known = SpeedCurve(SPEED, {40.0: 1.0, 120.0: 0.5, 10.0: 3.25})  # 0.25 of it turning, 0.75 times 40 / v moving
    assert known.bounds == (0.5, 3.25)
    assert known.speed(0.25 + 0.75 * 40 / 20) == 20.0
    assert known.speed(0.25 + 0.75 * 40 / 60) == 60.0
    assert known.speed(9.0) == 10.0
    assert 110.0 < known.speed(0.1) <= 120.0  # no faster than shortens it


@pytest.mark.slow
def test_required_times_are_met_by_planning(runner, outcome):
    speeds = {
        variable.template: variable
        for variable in variables_of(outcome)
        if variable.kind == "speeds" and variable.template in ("sweep", "around")
    }
    curves = speed_curves(runner, TEXT, speeds)
    assert set(curves) == {"sweep", "around"}
    assert all(low < 1.0 < high for low, high in (each.bounds for each in curves.values()))
    required = {source: 1.7 * seconds for source, seconds in runner.spray_durations(TEXT).items()}
    used = runner.used
    found = plan_speeds(runner, (TEXT, ()), curves, required, {"sweep": 1.7, "around": 1.7})
    assert found is not None
    for name in curves:
        total = sum(seconds for (_, template), seconds in required.items() if template == name)
        came = sum(seconds for (_, template), seconds in found.times.items() if template == name)
        assert came == pytest.approx(total, rel=0.05)
    assert len(found.what) == 2
    assert runner.used == used  # plans are not counted
