"""Fast air clears low gaps; what it leaves takes seconds from a surface and minutes from a gap."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.parameters.liquid import water_surface_tension_n_m
from cleaning.parameters.load import load_parameters
from cleaning.undersides.rinse import blow_off_m, film_dry_s, gap_dry_s

DRYING = load_parameters("default").drying
AIR_KG_M3 = 1.1
"""At 40 degrees C, about."""


@pytest.mark.parametrize(
    ("speed", "least_um"), [(25.0, 212.0), (50.8, 51.4), (75.0, 23.6), (100.0, 13.3), (150.0, 5.9)]
)
def test_ten_thousand_feet_a_minute_clear_two_mils(speed: float, least_um: float) -> None:
    height = blow_off_m(DRYING, water_surface_tension_n_m(40.0), 0.5 * AIR_KG_M3 * speed**2)
    assert 1e6 * height == pytest.approx(least_um, rel=0.01)


def test_still_air_clears_nothing() -> None:
    assert blow_off_m(DRYING, 0.07, 0.0) == math.inf
    assert blow_off_m(DRYING, 0.07, -5.0) == math.inf


def test_a_liquid_without_grip_leaves_any_gap() -> None:
    slippery = DRYING.model_copy(update={"receding_deg": 70.0})
    assert blow_off_m(slippery, 0.07, 100.0) == pytest.approx(0.0, abs=1e-15)
    reversed_ = DRYING.model_copy(update={"receding_deg": 80.0})
    assert blow_off_m(reversed_, 0.07, 100.0) == 0.0


@pytest.mark.parametrize(
    ("air_c", "transfer", "seconds"),
    [(60, 50, 69), (60, 150, 23), (80, 50, 48), (80, 150, 16), (110, 50, 32), (110, 150, 11)],
)
def test_a_film_of_50_um_evaporates_in_seconds(air_c: float, transfer: float, seconds: float) -> None:
    drying = DRYING.model_copy(update={"transfer_w_m2_k": transfer})
    assert film_dry_s(drying, air_c, 50e-6, 1000.0) == pytest.approx(seconds, rel=0.06)


@pytest.mark.parametrize(("board_c", "seconds"), [(60.0, 1650.0), (80.0, 630.0), (100.0, 285.0)])
def test_a_dead_end_of_a_gap_takes_minutes(board_c: float, seconds: float) -> None:
    assert gap_dry_s(DRYING, board_c, 3.5e-3, 970.0) == pytest.approx(seconds, rel=0.08)


@settings(max_examples=40)
@given(warm=st.floats(25, 120), warmer=st.floats(1, 40), depth=st.floats(1e-4, 1e-2))
def test_warmth_dries_and_depth_does_not(warm: float, warmer: float, depth: float) -> None:
    assert film_dry_s(DRYING, warm + warmer, 15e-6, 985.0) < film_dry_s(DRYING, warm, 15e-6, 985.0)
    assert gap_dry_s(DRYING, warm + warmer, depth, 985.0) < gap_dry_s(DRYING, warm, depth, 985.0)
    assert gap_dry_s(DRYING, warm, 2 * depth, 985.0) == pytest.approx(4 * gap_dry_s(DRYING, warm, depth, 985.0))


def test_saturated_air_dries_nothing() -> None:
    damp = DRYING.model_copy(update={"room_humidity_pct": 100.0})
    assert gap_dry_s(damp, damp.room_c, 1e-3, 985.0) == math.inf
    assert film_dry_s(damp, damp.room_c - 5.0, 15e-6, 985.0) == math.inf
