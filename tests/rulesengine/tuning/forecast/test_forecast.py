"""What forecasts say of longer and shorter spraying, against analyses of just that."""

from pathlib import Path

import numpy as np
import pytest

from boards.load import load_board
from cleaning.analyse import analyse_on
from cleaning.parameters.load import load_parameters
from cleaning.prepared_board import prepare
from recipes.load import parse_recipe, recipe_library
from rulesengine.planning.pipeline import run
from rulesengine.tuning.changes.candidate_changes import knobs_for
from rulesengine.tuning.forecast.forecast import Learnt, forecast, learn
from rulesengine.tuning.forecast.speed_for_duration import Pace, pace, paces_of
from rulesengine.tuning.trial.deposits import deposits_of
from rulesengine.tuning.trial.trial_runner import Bench
from rulesengine.tuning.variables.design_variables import Knob

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
def bench():
    return Bench(FILE, prepare(load_board(Path("tiny")), load_parameters(), lambda *_: None), "clean", 9)


@pytest.fixture(scope="module")
def outcome(bench):
    return bench.first(TEXT)


def test_deposits_add_up_to_what_each_stage_leaves(bench):
    planned = run(parse_recipe(TEXT, file=FILE), bench.prepared.board)
    report = analyse_on(bench.prepared, planned.program, planned.recipe, "fast")
    deposits = deposits_of(report)
    assert [(each.step, each.template) for each in deposits.each] == [
        ("sequence[0]", "sweep"),
        ("sequence[0]", "around"),
        ("sequence[1]", "around"),
    ]
    for stage, exposure in zip(report.stages, report.exposures, strict=True):
        own = [each for each in deposits.each if each.step == stage.made_by]
        assert sum(each.seconds for each in own) == pytest.approx(stage.spray_s)
        np.testing.assert_allclose(sum(each.volume_mm for each in own), exposure.volume_mm, rtol=1e-4, atol=1e-4)


def test_the_present_is_foretold_as_it_is(outcome):
    foretold = forecast(outcome, Learnt())
    now = np.ones(len(foretold.deposits.each))
    assert foretold.seconds(now, {}) == pytest.approx(outcome.seconds)
    assert foretold.needs
    judged = {(each.component, each.judgement.rule, each.judgement.stage): each for each in outcome.spares}
    for need in foretold.needs:
        if need.kind == "low" and need.key in judged:
            value = judged[need.key].judgement.numbers[0].value
            assert need.amount(now, foretold.durations(now, {})) == pytest.approx(value, rel=1e-3)


def test_slower_and_more_often_is_foretold_as_it_comes_out(bench, outcome):
    foretold = forecast(outcome, Learnt())
    planned = bench.sprayed_s(LONGER)
    now = {(each.step, each.template): each.seconds for each in foretold.deposits.each}
    times = np.array([planned[source] / seconds for source, seconds in now.items()])
    often = {"sequence[0]": 1.5}
    came = bench.outcome(LONGER)
    assert foretold.seconds(times, often) == pytest.approx(came.seconds, rel=0.02)
    durations = foretold.durations(times, often)
    after = forecast(came, Learnt())
    compared = 0
    for need in foretold.needs:
        other = next((each for each in after.needs if each.key == need.key and each.kind == "low"), None)
        if need.kind == "low" and other is not None:
            ones = np.ones(len(times))
            assert need.amount(times, durations) == pytest.approx(other.amount(ones, {}), rel=0.35), need.key
            compared += 1
    assert compared >= 5


def test_slopes_come_to_the_amount(outcome):
    foretold = forecast(outcome, Learnt())
    times = np.linspace(0.7, 1.4, len(foretold.deposits.each))
    for need in foretold.needs:
        if need.kind == "low":
            slopes = need.slopes(times)
            assert (slopes >= 0).all()
            assert slopes @ times[list(need.which)] == pytest.approx(need.amount(times, {}), rel=1e-9)


def test_what_was_promised_in_vain_is_asked_for_more_of(bench, outcome):
    foretold = forecast(outcome, Learnt())
    hurried = bench.outcome(TEXT.replace("speed_mm_s: 30", "speed_mm_s: 100").replace("repeat: 2", "repeat: 1"))
    assert hurried.shortfall > outcome.shortfall
    learnt = Learnt()
    times = np.full(len(foretold.deposits.each), 0.5)
    assert learn(learnt, foretold, hurried, times, {})
    assert learnt.doubts or learnt.means
    assert all(doubt > 0 for doubt in learnt.doubts.values())
    for key, (least, steps) in learnt.means.items():
        assert least > 0
        assert steps, key
    assert not learn(Learnt(), foretold, outcome, times, {})


KNOB = Knob("speeds", ("templates", "sweep", "speed_mm_s"), 40.0, 5.0, 150.0, 1.0, -1.0, ("sequence[0]",), "sweep")


def test_a_speed_between_two_that_are_known_goes_with_the_inverse_of_time():
    known = Pace(KNOB, {40.0: 1.0, 120.0: 0.5, 10.0: 3.25})  # 0.25 of it turning, 0.75 times 40 / v moving
    assert known.bounds == (0.5, 3.25)
    assert known.speed(0.25 + 0.75 * 40 / 20) == 20.0
    assert known.speed(0.25 + 0.75 * 40 / 60) == 60.0
    assert known.speed(9.0) == 10.0
    assert 110.0 < known.speed(0.1) <= 120.0  # no faster than shortens it


def test_asked_times_are_met_by_planning(bench, outcome):
    speeds = {
        knob.template: knob
        for knob in knobs_for(outcome)
        if knob.kind == "speeds" and knob.template in ("sweep", "around")
    }
    paces = paces_of(bench, TEXT, speeds)
    assert set(paces) == {"sweep", "around"}
    assert all(low < 1.0 < high for low, high in (each.bounds for each in paces.values()))
    asked = {source: 1.7 * seconds for source, seconds in bench.sprayed_s(TEXT).items()}
    used = bench.used
    found = pace(bench, TEXT, (), paces, asked, {"sweep": 1.7, "around": 1.7})
    assert found is not None
    for name in paces:
        total = sum(seconds for (_, template), seconds in asked.items() if template == name)
        came = sum(seconds for (_, template), seconds in found.sprayed_s.items() if template == name)
        assert came == pytest.approx(total, rel=0.05)
    assert len(found.what) == 2
    assert bench.used == used  # plans are not counted
