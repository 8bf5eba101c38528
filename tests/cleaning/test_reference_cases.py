"""Known answers of the model at other numbers than in the tests of its pieces, and its trends through whole gaps."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from analysed import PARAMETERS, board_of, prepared_of, with_parameters
from hypothesis import given, settings
from hypothesis import strategies as st
from jet_references import intensity
from scipy.linalg import expm
from scipy.optimize import brentq
from small_sprays import RING, downward, one_jet, samples_of, sprayed, stage_of

from cleaning.judge_component import Sprayed, gaps_of
from cleaning.parameters.liquid import vapour_pressure_pa, water_surface_tension_n_m, wet_surface_c
from cleaning.parameters.model import PartOverride
from cleaning.prepared_board import prepare
from cleaning.undersides.residue import step
from recipes.nozzles import HollowCone

LINE = samples_of([[x, 20.0, 45.0] for x in range(-10, 45, 5)], downward(20.0, 30.0), seconds=4.0)
WASH = stage_of(LINE)


def residue(stage=WASH, prepared=None):
    """Share that is left under U1 in its harder case."""
    return under(stage, prepared).residue


def under(stage=WASH, prepared=None):
    return gaps_of(prepared or prepared_of(("U1",)), [Sprayed(stage, sprayed(stage), None)], _say_nothing)[0].gaps[0]


def _say_nothing(*_):
    pass


@cache
def standing(standoff_um, paste_factor=1.0):
    """U1 at a stated height; the flow is the model's own, also where a verdict takes its lower bound."""
    known = PartOverride(match=["U1"], standoff_um=(standoff_um, standoff_um), paste_factor=paste_factor)
    unbounded = PARAMETERS.gap.model_copy(update={"most_reynolds": 1e6})
    return prepare(board_of("U1"), PARAMETERS.model_copy(update={"parts": [known], "gap": unbounded}), _say_nothing)


@pytest.mark.slow
@pytest.mark.parametrize(("tilt", "force"), [(0, 0.6824), (15, 0.6591), (30, 0.5910), (45, 0.4824)])
def test_a_wide_plate_bears_the_known_force(tilt, force):
    polar = (np.arange(2000) + 0.5) * (np.pi / 4000)
    around = np.arange(360) * (np.pi / 180)
    theta, phi = np.meshgrid(polar, around, indexing="ij")
    rays = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1).reshape(-1, 3)
    solid = (np.sin(theta) * (np.pi / 4000) * (np.pi / 180)).ravel()
    jet = one_jet(RING)
    down = np.maximum(-(rays @ downward(tilt).T)[:, 2], 0.0)
    momentum = jet.density_kg_m3 * jet.speed_m_s * intensity(jet, rays) * solid
    assert (momentum * down).sum() == pytest.approx(force, rel=1e-3)


@pytest.mark.slow
@given(half=st.floats(12, 40), sigma=st.floats(1.5, 5), bar=st.floats(0.5, 10))
@settings(max_examples=15)
def test_impact_goes_with_the_pressure_whatever_the_ring(half, sigma, bar):
    nozzle = HollowCone(half_angle_deg=half, ring_sigma_deg=sigma, flow_lpm=2.0, at_bar=3.0)
    jet = one_jet(nozzle, pressure_bar=bar)
    impact = jet.density_kg_m3 * jet.flow_m3_s * jet.speed_m_s
    # rho Q v of a liquid of 1000 kg/m3: Q with the root of the pressure, v = 0.9 sqrt(2 P / rho).
    assert impact == pytest.approx(2e-3 / 60 * np.sqrt(bar / 3) * 0.9 * np.sqrt(2000 * bar * 1e5), rel=1e-9)


RATE = st.floats(0.0, 0.5)


@pytest.mark.slow
@given(k1=RATE, k2=RATE, seconds=st.floats(0.0, 60.0), hard=st.floats(0, 1), soft=st.floats(0, 1))
def test_a_step_solves_its_equations(k1, k2, seconds, hard, soft):
    exact = expm(np.array([[-k1, 0.0], [k1, -k2]]) * seconds) @ [hard, soft]
    found = step(hard, soft, k1, k2, seconds)
    assert [float(each) for each in found] == pytest.approx(exact, rel=1e-9, abs=1e-12)


@given(duty=st.floats(0.02, 0.9), k1=st.floats(0.001, 0.05), k2=st.floats(0.01, 3.0), period=st.floats(0.2, 20.0))
@settings(max_examples=30)
def test_pulses_do_what_the_equations_say(duty, k1, k2, period):
    on, off = (
        expm(np.array([[-k1, 0.0], [k1, -rate]]) * share * period) for rate, share in ((k2, duty), (0.0, 1 - duty))
    )
    exact, (hard, soft) = np.array([1.0, 0.0]), (1.0, 0.0)
    for _ in range(20):
        exact = off @ on @ exact
        hard, soft = step(*step(hard, soft, k1, k2, duty * period), k1, 0.0, (1 - duty) * period)
    assert [float(hard), float(soft)] == pytest.approx(exact, rel=1e-8, abs=1e-12)


def wet_bulb_c(air_c, humidity_pct):
    """Wet bulb of an aspirated psychrometer: 6.62e-4 per kelvin (WMO guide 8, annex 4.B), vapour after Magnus."""

    def saturated(celsius):
        return 611.2 * np.exp(17.62 * celsius / (243.12 + celsius))

    vapour = humidity_pct / 100 * saturated(air_c)
    return brentq(lambda wet: saturated(wet) - 6.62e-4 * 101325 * (air_c - wet) - vapour, -20.0, air_c)


@pytest.mark.parametrize(("air_c", "humidity"), [(10, 50), (20, 30), (20, 90), (30, 40), (35, 60), (45, 20)])
def test_wet_surfaces_in_any_room_are_cooled_about_as_a_wet_bulb_is(air_c, humidity):
    cooled = air_c - wet_surface_c(air_c, vapour_pressure_pa(air_c, humidity))
    assert cooled == pytest.approx(air_c - wet_bulb_c(air_c, humidity), rel=0.1)


@pytest.mark.slow
def test_warmth_counts_for_more_than_standoff_through_the_whole_gap():
    left = {
        warm: [residue(replace(WASH, temperature_c=warm), standing(height)) for height in (25.0, 50.0, 100.0, 200.0)]
        for warm in (40.0, 50.0, 60.0, 70.0)
    }
    for row in left.values():
        assert all(low >= high for low, high in pairwise(row))
    for column in zip(*left.values(), strict=True):
        assert all(cold > warm for cold, warm in pairwise(column))
    assert left[60.0][1] / left[60.0][3] < left[40.0][1] / left[60.0][1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("block", "key", "values"),
    [
        ("soil", "k1_per_s", (0.006, 0.012, 0.024)),
        ("soil", "k_m_per_s", (0.015, 0.05, 0.15)),
        ("soil", "shear_threshold_pa", (3.0, 0.3, 0.03)),
        ("soil", "paste_factor", (1.0, 0.5, 0.0)),
        ("film", "retention", (0.1, 0.5, 0.8)),
        ("film", "puddle_mm", (2.0, 1.0, 0.5)),
        ("film", "decay_mm", (5.0, 15.0, 40.0)),
    ],
)
def test_what_helps_never_leaves_more(block, key, values):
    found = [residue(prepared=with_parameters(prepared_of(("U1",)), **{block: {key: value}})) for value in values]
    assert all(before >= after for before, after in pairwise(found))
    assert found[0] > found[-1]


@pytest.mark.slow
@pytest.mark.parametrize("contact", [105.0, 112.0, 120.0])
def test_water_is_kept_out_by_the_capillary_pressure_of_the_gap(contact):
    liquid = PARAMETERS.liquids["di-water"].model_copy(
        update={"contact_board_deg": contact, "contact_part_deg": contact}
    )
    stage = replace(WASH, liquid=liquid, temperature_c=25.0)
    heights = np.array([20.0, 35.0, 60.0, 110.0, 200.0])
    acts = [under(stage, standing(height, paste_factor=0.0)).stages[0] for height in heights]
    margins = np.array([act.margin_pa for act in acts])
    barrier = 2 * water_surface_tension_n_m(25.0) * np.cos(np.radians(contact)) / (1e-6 * heights)
    np.testing.assert_allclose(margins - barrier, margins[0] - barrier[0], rtol=1e-6)
    assert [act.entered for act in acts] == (margins >= 0).tolist()
    assert margins[0] < 0 < margins[-1]
