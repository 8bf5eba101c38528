"""Properties of water and moist air against tables; a wet surface lies between dew point and air."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.parameters.water_and_air import (
    latent_heat_j_kg,
    saturation_pa,
    vapour_diffusivity_m2_s,
    vapour_kg_m3,
    vapour_pressure_pa,
    wet_surface_c,
)


@pytest.mark.parametrize(
    ("temperature_c", "pa"), [(0.01, 611.657), (20.0, 2339.2), (60.0, 19946.0), (100.0, 101418.0), (120.0, 198670.0)]
)
def test_vapour_pressure_follows_the_steam_tables(temperature_c: float, pa: float) -> None:
    assert saturation_pa(temperature_c) == pytest.approx(pa, rel=2e-4)


def test_saturated_vapour_at_60_degrees_weighs_130_grams() -> None:
    assert vapour_kg_m3(saturation_pa(60.0), 60.0) == pytest.approx(0.1304, rel=0.01)


@pytest.mark.parametrize(
    ("temperature_c", "j_kg"), [(0.0, 2.501e6), (30.0, 2.430e6), (60.0, 2.358e6), (100.0, 2.257e6)]
)
def test_latent_heat_follows_the_steam_tables(temperature_c: float, j_kg: float) -> None:
    assert latent_heat_j_kg(temperature_c) == pytest.approx(j_kg, rel=4e-3)


def test_vapour_spreads_faster_in_warm_air() -> None:
    assert vapour_diffusivity_m2_s(25.0) == pytest.approx(2.5e-5, rel=0.03)
    assert vapour_diffusivity_m2_s(100.0) > 1.4 * vapour_diffusivity_m2_s(25.0)


def test_a_wet_surface_in_room_air_has_nearly_the_wet_bulb_temperature() -> None:
    # psychrometric tables: 13.8 degrees; a slow stream and no radiation
    assert wet_surface_c(20.0, vapour_pressure_pa(20.0, 50.0)) == pytest.approx(13.8, abs=0.7)


@settings(max_examples=60)
@given(air_c=st.floats(5, 150), room_c=st.floats(5, 35), humidity=st.floats(0, 100))
def test_a_wet_surface_is_colder_than_the_air_and_not_below_its_dew_point(
    air_c: float, room_c: float, humidity: float
) -> None:
    vapour = vapour_pressure_pa(room_c, humidity)
    surface = wet_surface_c(air_c, vapour)
    assert surface <= air_c
    assert vapour_kg_m3(saturation_pa(surface), surface) >= vapour_kg_m3(min(vapour, saturation_pa(air_c)), air_c) * (
        1.0 - 1e-6
    )


def test_very_hot_air_keeps_a_wet_surface_below_boiling() -> None:
    assert 40.0 < wet_surface_c(500.0, vapour_pressure_pa(20.0, 50.0)) < 100.0


def test_saturated_air_cools_nothing() -> None:
    assert wet_surface_c(20.0, saturation_pa(20.0)) == pytest.approx(20.0, abs=1e-6)
    assert wet_surface_c(20.0, saturation_pa(30.0)) == pytest.approx(20.0, abs=1e-6)
