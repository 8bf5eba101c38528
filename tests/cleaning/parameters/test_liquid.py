import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.parameters.liquid import (
    air_density_kg_m3,
    capillary_pa,
    density_kg_m3,
    latent_heat_j_kg,
    saturation_pa,
    surface_tension_n_m,
    vapour_diffusivity_m2_s,
    vapour_kg_m3,
    vapour_pressure_pa,
    viscosity_pa_s,
    water_surface_tension_n_m,
    water_viscosity_pa_s,
    wet_surface_c,
)
from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import Liquid

WATER = Liquid(use="rinse")
SAPONIFIER = load_parameters().liquids["saponifier-15"]


def wetting(angle_deg, **known):
    return Liquid(use="rinse", contact_board_deg=angle_deg, contact_part_deg=angle_deg, **known)


@pytest.mark.parametrize(("celsius", "mn_m"), [(25, 71.97), (60, 66.24), (100, 58.91)])
def test_surface_tension_of_water_is_that_of_the_tables(celsius, mn_m):
    assert 1e3 * water_surface_tension_n_m(celsius) == pytest.approx(mn_m, abs=0.01)


@pytest.mark.parametrize(("celsius", "upa_s"), [(5, 1518.1), (25, 889.9), (45, 595.9), (75, 377.4), (100, 281.6)])
def test_viscosity_of_water_is_that_of_the_tables(celsius, upa_s):
    assert 1e6 * water_viscosity_pa_s(celsius) == pytest.approx(upa_s, rel=2e-3)


def test_air_is_that_of_the_tables():
    air = Liquid(use="dry")
    assert air_density_kg_m3(15.0) == pytest.approx(1.225, rel=1e-3)
    assert 1e6 * viscosity_pa_s(air, 15.0) == pytest.approx(17.89, rel=1e-3)
    assert viscosity_pa_s(air, 80.0) > viscosity_pa_s(air, 20.0)


def test_what_is_stated_counts():
    assert surface_tension_n_m(SAPONIFIER, 20.0) == surface_tension_n_m(SAPONIFIER, 70.0) == pytest.approx(0.030)
    assert viscosity_pa_s(SAPONIFIER, 60.0) == pytest.approx(6e-4)
    assert density_kg_m3(Liquid(use="dry", density_kg_m3=1.3), 80.0) == 1.3
    assert density_kg_m3(Liquid(use="dry"), 80.0) == air_density_kg_m3(80.0)
    assert density_kg_m3(WATER, 80.0) == 1000.0


def test_a_stated_viscosity_follows_that_of_water():
    ratio = viscosity_pa_s(SAPONIFIER, 40.0) / viscosity_pa_s(SAPONIFIER, 60.0)
    assert ratio == pytest.approx(viscosity_pa_s(WATER, 40.0) / viscosity_pa_s(WATER, 60.0))
    assert ratio > 1.2


HEIGHTS_UM = (15, 25, 50, 75, 100, 150, 250)


@pytest.mark.parametrize(
    ("liquid", "celsius", "expected"),
    [
        (wetting(80), 25, (1667, 1000, 500, 333, 250, 167, 100)),
        (wetting(95), 25, (-837, -502, -251, -167, -126, -84, -50)),
        (wetting(105), 25, (-2485, -1491, -745, -497, -373, -248, -149)),
        (wetting(105), 60, (-2285, -1371, -685, -457, -343, -228, -137)),
        (wetting(20, surface_tension_mn_m=30), 60, (3759, 2255, 1128, 752, 564, 376, 226)),
    ],
)
def test_capillary_pressures(liquid, celsius, expected):
    found = [capillary_pa(liquid, celsius, 1e-6 * height) for height in HEIGHTS_UM]
    assert found == pytest.approx(expected, rel=1e-3, abs=1.0)


def test_both_walls_count():
    mixed = Liquid(use="rinse", contact_board_deg=20.0, contact_part_deg=160.0)
    assert capillary_pa(mixed, 25.0, 5e-5) == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=50)
@given(height=st.floats(1e-5, 1e-3), celsius=st.floats(1.0, 99.0), factor=st.floats(1.1, 9.0))
def test_thin_gaps_draw_harder(height, celsius, factor):
    assert capillary_pa(SAPONIFIER, celsius, height) == pytest.approx(
        factor * capillary_pa(SAPONIFIER, celsius, factor * height)
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
