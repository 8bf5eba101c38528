"""The shortest times on forecasts that are made up, so that the answer is known."""

from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.verdicts.rules import UNDER_EXPOSED
from rulesengine.tuning.forecast.forecast import Forecast, LowerBound
from rulesengine.tuning.forecast.minimum_times import Scheme, minimum_times
from rulesengine.tuning.trial.outcome import Deposit, Deposits

WASH = "sequence[0]"
FREE = MappingProxyType({"a": (0.01, 10.0), "b": (0.01, 10.0)})


def made_up(volumes, bounds, seconds=(10.0, 10.0), idle=1.0):
    """Two templates of one step; ``volumes`` (2, cells) mm, ``bounds`` of the kind and the least amount."""
    volumes = np.array(volumes, dtype=np.float32)
    areas = np.ones(volumes.shape[1])
    each = tuple(Deposit(WASH, name, s, v) for name, s, v in zip("ab", seconds, volumes, strict=True))
    cells = np.arange(volumes.shape[1])
    required = tuple(
        LowerBound(
            (f"U{at}", UNDER_EXPOSED, WASH),
            kind,
            least,
            frozenset({WASH}),
            (0, 1),
            volumes[:, own].astype(float),
            areas[own],
        )
        for at, (kind, least, own) in enumerate((*bound, cells)[:3] for bound in bounds)
    )
    return Forecast(None, Deposits(each, areas, {}), {WASH: idle}, 3.0, required)


def test_each_template_gives_just_what_only_it_can_give():
    predicted = made_up([[2.0, 0.0], [0.0, 4.0]], [("mean", 1.0, np.array([0])), ("mean", 1.0, np.array([1]))])
    found = minimum_times(predicted, Scheme(FREE))
    assert found.factors["a"] == pytest.approx(0.5, rel=0.01)
    assert found.factors["b"] == pytest.approx(0.25, rel=0.01)
    assert found.seconds == pytest.approx(3.0 + 1.0 + 5.0 + 2.5, rel=0.01)


def test_the_one_that_gives_more_in_its_time_takes_over():
    predicted = made_up([[2.0, 2.0], [4.0, 4.0]], [("low", 6.0)])
    found = minimum_times(predicted, Scheme(FREE))
    assert found.factors["a"] == pytest.approx(0.01, abs=0.02)
    assert found.factors["b"] == pytest.approx(1.5, rel=0.02)


def test_the_least_wetted_places_decide():
    volumes = np.full((2, 100), 5.0)
    volumes[0, :10] = 0.0  # a tenth gets nothing from the first
    found = minimum_times(made_up(volumes, [("low", 5.0)]), Scheme(FREE))
    assert found.factors["b"] == pytest.approx(1.0, rel=0.02)
    assert found.factors["a"] < 0.05


def test_a_time_that_is_needed_is_kept_by_what_is_slowest_anyway():
    found = minimum_times(made_up([[1.0], [1.0]], [("time", 12.0)], idle=2.0), Scheme(FREE))
    assert found.seconds == pytest.approx(3.0 + 12.0, rel=0.01)


def test_done_less_often_takes_less_idle_time_and_more_from_each():
    predicted = made_up([[4.0], [0.0]], [("mean", 4.0)], idle=8.0)
    half = {(WASH, "a"): 0.5, (WASH, "b"): 0.5}
    found = minimum_times(predicted, Scheme(FREE, half, {WASH: 0.5}))
    assert found.factors["a"] == pytest.approx(2.0, rel=0.01)
    assert found.times[0] == pytest.approx(1.0, rel=0.01)
    assert found.seconds == pytest.approx(3.0 + 4.0 + 10.0, rel=0.03)


def test_what_cannot_be_is_none():
    assert minimum_times(made_up([[1.0], [0.0]], [("mean", 50.0)]), Scheme(FREE)) is None
    assert minimum_times(made_up([[0.0], [0.0]], [("mean", 1.0)]), Scheme(FREE)) is None
    gone = Scheme(FREE, {(WASH, "a"): 0.0})
    assert minimum_times(made_up([[1.0], [0.0]], [("mean", 0.5)]), gone) is None


def test_templates_without_bounds_keep_their_time():
    found = minimum_times(made_up([[2.0], [2.0]], [("mean", 1.0)]), Scheme({"a": (0.1, 2.0)}))
    assert found.factors == {"a": pytest.approx(0.1, abs=0.01), "b": 1.0}


@pytest.mark.slow
@settings(max_examples=30)
@given(st.integers(0, 10_000), st.floats(0.2, 0.9))
def test_what_is_found_holds_and_is_no_longer_than_now(seed, share):
    drawn = np.random.default_rng(seed)
    volumes = drawn.gamma(1.5, 4.0, (2, 60))
    predicted = made_up(volumes, [("low", 1e-9), ("mean", 1e-9), ("time", share * 21.0)])
    now = np.ones(2)
    low, mean, time = predicted.bounds
    bounds = (
        LowerBound(low.key, "low", share * low.amount(now, {}), low.steps, low.which, low.volumes, low.areas),
        LowerBound(mean.key, "mean", share * mean.amount(now, {}), mean.steps, mean.which, mean.volumes, mean.areas),
        time,
    )
    predicted = Forecast(None, predicted.deposits, predicted.idle_s, predicted.rest_s, bounds)
    found = minimum_times(predicted, Scheme(FREE))
    assert found.seconds <= predicted.seconds(now, {}) + 1e-9
    durations = predicted.durations(found.times, {})
    for bound in bounds:
        assert bound.amount(found.times, durations) >= bound.least * (1 - 1e-6)
