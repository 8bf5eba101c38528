"""Intervals are those of the textbook where the textbook has them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.calibration.confidence import (
    Fit,
    chance_of_less,
    correlations,
    half_widths,
    highest_squares,
    profile_end,
    student_t,
)


def mean_of(values: list[float]) -> Fit:
    data = np.array(values)
    left = data - data.mean()
    return Fit(np.array([data.mean()]), float(left @ left), len(data) - 1, np.ones((len(data), 1)))


def test_the_interval_of_a_mean_is_students() -> None:
    fit = mean_of([1.0, 2.0, 3.0, 4.0, 5.0])
    assert student_t(4) == pytest.approx(2.776, abs=1e-3)
    # The jackknife leaves each out once: 2.5 is the variance, and five fourths of it counts.
    left = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])[:, None]
    assert half_widths(fit, left)[0] == pytest.approx(2.776 * math.sqrt(5 / 4 * 2.5 / 5), abs=1e-3)


def test_the_closed_form_is_that_of_leaving_each_group_out() -> None:
    random = np.random.default_rng(3)
    slopes, target = random.normal(size=(12, 2, 3)), random.normal(size=(12, 2))
    best = np.linalg.lstsq(slopes.reshape(-1, 3), target.ravel())[0]
    left = target - slopes @ best
    fit = Fit(best, float(np.sum(left**2)), 21, -slopes.reshape(-1, 3))
    without = [
        np.linalg.lstsq(np.delete(slopes, each, 0).reshape(-1, 3), np.delete(target, each, 0).ravel())[0]
        for each in range(12)
    ]
    spread = np.sqrt(np.sum((np.array(without) - best) ** 2, axis=0))
    np.testing.assert_allclose(half_widths(fit, left), student_t(9) * spread, rtol=1e-9)


@given(st.lists(st.floats(-9, 9), min_size=4, max_size=9).filter(lambda values: np.ptp(values) > 0.5))
@settings(max_examples=30)
def test_profiles_of_linear_fits_are_their_intervals(values: list[float]) -> None:
    fit, data = mean_of(values), np.array(values)
    most = highest_squares(fit.squares, fit.freedom)
    best = float(fit.parameters[0])
    ends = [profile_end(lambda mean: float(((data - mean) ** 2).sum()), best, side * 1e3, most) for side in (-1, 1)]
    wide = student_t(fit.freedom) * math.sqrt(fit.squares / fit.freedom / len(data))
    np.testing.assert_allclose(np.abs(np.array(ends) - best), wide, atol=1e-3)


def test_what_makes_no_difference_has_no_end() -> None:
    assert profile_end(lambda _: 1.0, 0.0, 5.0, 1.5) == math.inf
    assert profile_end(lambda _: 1.0, 0.0, -5.0, 1.5) == -math.inf
    assert profile_end(lambda value: value**2, 0.0, -5.0, 100.0) == -math.inf


def test_parameters_that_do_the_same_are_fully_correlated() -> None:
    random = np.random.default_rng(1).normal(size=(20, 2))
    apart = Fit(np.zeros(2), 1.0, 18, random)
    assert 0 <= correlations(apart)[0, 1] < 0.6
    alike = Fit(np.zeros(2), 1.0, 18, random[:, :1] @ np.array([[1.0, 2.0]]))
    assert correlations(alike)[0, 1] == 1.0
    assert np.isinf(half_widths(alike, np.ones((20, 1)))).all()
    assert correlations(Fit(np.zeros(1), 1.0, 19, np.zeros((20, 1))))[0, 0] == 1.0


@pytest.mark.parametrize("size", [1e-150, 1e-9, 1.0, 1e150])
def test_units_of_a_parameter_do_not_decide_whether_it_is_determined(size: float) -> None:
    slopes = np.column_stack([np.ones(5), np.arange(5.0)])
    plain = Fit(np.zeros(2), 1.0, 3, slopes)
    scaled = Fit(np.zeros(2), 1.0, 3, slopes * [1.0, size])
    left = np.array([[1.0], [-2.0], [0.0], [2.0], [-1.0]])
    wide = half_widths(scaled, left) * [1.0, size]
    if size > 1e-100:
        np.testing.assert_allclose(wide, half_widths(plain, left), rtol=1e-9)
        np.testing.assert_allclose(correlations(scaled), correlations(plain), rtol=1e-9)
    else:
        assert np.isinf(half_widths(scaled, left)).all()


@pytest.mark.parametrize("column", [np.zeros(4), np.full(4, 2.0), np.array([1.0, np.inf, 0, 0])])
def test_a_fit_without_an_inverse_has_infinite_widths(column: np.ndarray) -> None:
    fit = Fit(np.zeros(2), 0.0, 2, np.column_stack([np.ones(4), column]))
    assert np.isinf(half_widths(fit, np.zeros((4, 1)))).all()
    assert (correlations(fit) == 1).all()


def test_chance_tells_an_effect_from_noise() -> None:
    few, more = Fit(np.zeros(1), 10.0, 19, np.ones((20, 1))), Fit(np.zeros(2), 1.0, 18, np.ones((20, 2)))
    assert chance_of_less(few, more) < 1e-6
    assert chance_of_less(few, Fit(np.zeros(2), 9.9, 18, np.ones((20, 2)))) > 0.5
    assert chance_of_less(few, Fit(np.zeros(2), 10.0, 18, np.ones((20, 2)))) == pytest.approx(1.0)
