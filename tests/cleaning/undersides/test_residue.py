"""Residue softens and leaves; what is left never grows, whatever the rates."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.parameters.load import load_parameters
from cleaning.undersides.residue import exchanges_needed, fill_share, open_share, removal_rate, softening_rate, step

PARAMETERS = load_parameters("default")
SOIL, GAP = PARAMETERS.soil, PARAMETERS.gap
SHARES = st.floats(0.0, 1.0)
RATES = st.floats(0.0, 1e4)
TIMES = st.floats(0.0, 1e5)


def test_many_steps_give_the_known_solution() -> None:
    hard, soft = np.ones(1), np.zeros(1)
    for _ in range(37):
        hard, soft = step(hard, soft, 0.006, 0.03, 300.0 / 37)
    assert hard[0] == pytest.approx(0.165298888222, abs=1e-11)
    assert soft[0] == pytest.approx(0.041293869604, abs=1e-11)


def test_equal_rates_are_no_special_case() -> None:
    hard, soft = step(1.0, 0.0, 0.01, 0.01, 300.0)
    assert float(hard) == pytest.approx(math.exp(-3.0), rel=1e-10)
    assert float(soft) == pytest.approx(3.0 * math.exp(-3.0), rel=1e-10)
    _, near = step(1.0, 0.0, 0.01, 0.01 + 1e-13, 300.0)
    assert float(near) == pytest.approx(float(soft), rel=1e-10)


def test_pulses_with_soak_between_them_do_what_their_mean_does() -> None:
    hard, soft = np.ones(1), np.zeros(1)
    for _ in range(300):
        hard, soft = step(hard, soft, 0.006, 0.3, 0.1)
        hard, soft = step(hard, soft, 0.006, 0.0, 0.9)
    assert (hard + soft)[0] == pytest.approx(0.20715, abs=1e-4)
    assert sum(step(1.0, 0.0, 0.006, 0.03, 300.0)) == pytest.approx(0.20659, abs=1e-4)


@settings(max_examples=200)
@given(hard=SHARES, soft=SHARES, k1=RATES, k2=RATES, seconds=TIMES)
def test_what_is_left_is_never_negative_and_never_grows(
    hard: float, soft: float, k1: float, k2: float, seconds: float
) -> None:
    hard_after, soft_after = step(hard, soft, k1, k2, seconds)
    assert 0.0 <= hard_after <= hard
    assert soft_after >= 0.0
    assert hard_after + soft_after <= (hard + soft) * (1.0 + 1e-12)


@pytest.mark.slow
@settings(max_examples=200)
@given(
    hard=SHARES, soft=SHARES, k1=st.floats(0, 10), k2=st.floats(0, 10), seconds=st.floats(0, 10), cut=st.floats(0, 1)
)
def test_a_step_cut_in_two_changes_nothing(
    hard: float, soft: float, k1: float, k2: float, seconds: float, cut: float
) -> None:
    whole = step(hard, soft, k1, k2, seconds)
    halves = step(*step(hard, soft, k1, k2, cut * seconds), k1, k2, seconds - cut * seconds)
    np.testing.assert_allclose(halves, whole, rtol=1e-9, atol=1e-12)


@settings(max_examples=50)
@given(hard=SHARES, soft=SHARES, k1=RATES, k2=RATES)
def test_nothing_happens_in_no_time(hard: float, soft: float, k1: float, k2: float) -> None:
    np.testing.assert_array_equal(step(hard, soft, k1, k2, 0.0), (hard, soft))


def test_cells_are_independent() -> None:
    soft, k2 = np.array([0.1, 0.2, 0.7]), np.array([0.0, 0.3, 2.0])
    _, together = step(0.3, soft, 0.01, k2, 4.0)
    for cell in range(3):
        assert together[cell] == float(step(0.3, soft[cell], 0.01, k2[cell], 4.0)[1])


def test_soaking_softens_and_removes_nothing() -> None:
    hard, soft = step(1.0, 0.0, 0.02, 0.0, 100.0)
    assert float(hard) < 0.2
    assert float(hard + soft) == pytest.approx(1.0, rel=1e-14)


def test_the_rate_at_the_reference_is_the_stated_one() -> None:
    assert softening_rate(SOIL, 60.0, SOIL.reference_pct) == pytest.approx(SOIL.k1_per_s, rel=1e-14)


def test_warmth_and_agent_speed_softening_and_water_alone_softens_nothing() -> None:
    rates = [softening_rate(SOIL, temperature, 15.0) for temperature in (20.0, 40.0, 60.0, 80.0)]
    assert rates == sorted(rates)
    # Arrhenius from 40 to 60 degrees at 30 kJ/mol
    assert rates[2] / rates[1] == pytest.approx(math.exp(30e3 / 8.314462618 * (1 / 313.15 - 1 / 333.15)))
    assert softening_rate(SOIL, 60.0, 0.0) == 0.0
    assert softening_rate(SOIL, 60.0, 1e9) == pytest.approx(SOIL.k1_per_s * 17 / 15, rel=1e-6)


def test_a_good_agent_gains_little_from_5_to_20_percent() -> None:
    assert softening_rate(SOIL, 60.0, 20.0) / softening_rate(SOIL, 60.0, 5.0) < 1.3


def test_shear_below_the_threshold_removes_nothing() -> None:
    rates = removal_rate(SOIL, np.array([0.0, 0.1, 0.1000001, 1.0, 3.0]))
    np.testing.assert_allclose(rates, [0.0, 0.0, 0.005, 0.05, 0.15], rtol=1e-5)


def test_the_beaker_gives_what_coupons_show() -> None:
    # Five minutes in a stirred beaker: 0.1 to 0.3 Pa. Coupons lose 0.0004 to 0.011 per second.
    for k2, apparent in ((0.005, 0.0034), (0.015, 0.0080)):
        left = float(sum(step(1.0, 0.0, 0.012, k2, 300.0)))
        assert -math.log(left) / 300.0 == pytest.approx(apparent, rel=0.02)


@pytest.mark.parametrize(("coverage", "fill"), [(0.0, 0.0), (0.2, 0.1125), (0.4, 0.30), (0.5, 0.45), (0.6, 0.675)])
def test_fill_follows_from_coverage(coverage: float, fill: float) -> None:
    assert fill_share(SOIL, coverage) == pytest.approx(fill, rel=1e-12)


def test_wide_pads_bridge_the_gap() -> None:
    assert fill_share(SOIL, 0.6) < GAP.plugged
    assert fill_share(SOIL, 0.66) >= GAP.plugged
    assert fill_share(SOIL, 0.69) == 1.0
    assert fill_share(SOIL, 1.0) == 1.0


def test_venting_empties_the_gap() -> None:
    assert fill_share(SOIL, 0.5, 0.3) == pytest.approx(0.3 * fill_share(SOIL, 0.5))
    assert fill_share(SOIL, 0.5, 0.0) == 0.0


@settings(max_examples=100)
@given(coverage=st.floats(0, 1), more=st.floats(0, 1), factor=st.floats(0, 3))
def test_more_pad_never_means_less_residue(coverage: float, more: float, factor: float) -> None:
    larger = coverage + more * (1.0 - coverage)
    assert 0.0 <= fill_share(SOIL, coverage, factor) <= fill_share(SOIL, larger, factor) <= 1.0


def test_a_qfn_needs_its_liquid_renewed_about_eighteen_times() -> None:
    assert exchanges_needed(SOIL, GAP, 0.45) == pytest.approx(18.0)
    assert exchanges_needed(SOIL, GAP, 0.0) == 0.0


def test_a_plugged_gap_is_open_at_its_rim() -> None:
    assert open_share(GAP, 1.0) == pytest.approx(0.15)
    assert open_share(GAP.model_copy(update={"plugged": 1.0}), 1.0) > 0.0
    assert exchanges_needed(SOIL, GAP, 1.0) == exchanges_needed(SOIL, GAP, GAP.plugged)
