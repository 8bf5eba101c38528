from dataclasses import replace

import numpy as np
import pytest
from analysed import PARAMETERS, prepared_of
from hypothesis import given
from hypothesis import strategies as st
from small_sprays import CONE, RING, downward, samples_of, sprayed, stage_of

from cleaning.film.edge_pressure import edge_pressures
from cleaning.undersides.sensitivity import elasticity, limiting, variants, vary

FACTORS = {"time", "temperature", "chemistry", "pressure", "standoff"}
EDGES = prepared_of(("U1", "C1")).edges
LINE = samples_of([[x, 19.0, 45.0] for x in range(-10, 40, 5)], downward(20.0, 30.0))


def pressed(stage, edges=EDGES):
    return edge_pressures(stage, sprayed(stage), edges, PARAMETERS.film)


def varied(stage, edges=EDGES):
    varied = vary([stage], [sprayed(stage)], edges, PARAMETERS)
    return variants(varied, [pressed(stage, edges)], edges, PARAMETERS)


def what_differs(one, other):
    names = ("liquid", "pressure_pa", "temperature_c", "begin_s", "end_s", "use", "nozzle")
    found = {name for name in names if getattr(one, name) != getattr(other, name)}
    arrays = ("times", "seconds", "tcp", "axes", "made_by")
    return found | {each for each in arrays if np.any(getattr(one.samples, each) != getattr(other.samples, each))}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "changed"),
    [
        ("time", {"end_s", "times", "seconds"}),
        ("temperature", {"temperature_c"}),
        ("chemistry", {"liquid"}),
        ("pressure", set()),
        ("standoff", set()),
    ],
)
def test_one_factor_at_a_time(factor, changed):
    stage = stage_of(LINE)
    found = varied(stage)
    assert set(found) == FACTORS
    stages, pressures = found[factor]
    assert what_differs(stage, stages[0]) == changed
    moved = [
        np.abs(one.pressure_pa - other.pressure_pa).max()
        for one, other in zip(pressed(stage), pressures[0], strict=True)
    ]
    assert (max(moved) > 1.0) == (factor in {"pressure", "standoff"})


def test_each_factor_grows_by_a_twentieth():
    stage = stage_of(LINE)
    found = {name: stages[0] for name, (stages, _) in varied(stage).items()}
    assert found["time"].spray_s == pytest.approx(1.05 * stage.spray_s)
    assert found["time"].end_s == pytest.approx(1.05 * stage.end_s)
    assert found["temperature"].temperature_c == pytest.approx(63.0)
    assert found["chemistry"].liquid.concentration_pct == pytest.approx(1.05 * stage.liquid.concentration_pct)


@pytest.mark.parametrize("nozzle", [RING, CONE])
def test_more_pressure_presses_as_it_does_when_it_is_worked_out_anew(nozzle):
    stage = stage_of(LINE, nozzle)
    scaled = varied(stage)["pressure"][1][0]
    anew = pressed(replace(stage, pressure_pa=1.05 * stage.pressure_pa))
    for one, other in zip(scaled, anew, strict=True):
        np.testing.assert_array_equal(one.sample, other.sample)
        np.testing.assert_allclose(one.pressure_pa, other.pressure_pa, rtol=1e-6, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("bottom", [(), ("U1", "C1")])
def test_more_standoff_presses_as_from_a_nozzle_drawn_back_along_its_jet(bottom):
    up, surface = (-1.0, -1.6) if bottom else (1.0, 0.0)
    edges = prepared_of(("U1", "C1"), bottom).edges
    samples = samples_of(LINE.tcp * [1, 1, up] + [0, 0, surface], np.diag([1.0, up, up]) @ LINE.axes)
    back = replace(samples, tcp=samples.tcp - 0.05 * 45.0 * samples.axes[:, :, 2])
    moved = varied(stage_of(samples), edges)["standoff"][1][0]
    for one, other, before in zip(
        moved, pressed(stage_of(back), edges), pressed(stage_of(samples), edges), strict=True
    ):
        assert len(one.sample) > 5
        np.testing.assert_allclose(one.pressure_pa, other.pressure_pa, rtol=1e-6, atol=1e-6)
        assert np.abs(one.pressure_pa - before.pressure_pa).max() > 1.0


def test_without_edges_nothing_presses():
    stage, edges = stage_of(LINE), prepared_of(()).edges
    assert all(pressures == [[]] for _, pressures in varied(stage, edges).values())


@given(residue=st.floats(0.01, 0.9), power=st.floats(-4, 4))
def test_a_power_law_gives_its_power(residue, power):
    assert elasticity(residue, residue * 1.05**power) == pytest.approx(power, abs=1e-9)


@given(before=st.floats(0, 1e-4), after=st.floats(0, 1e-4))
def test_what_is_clean_is_limited_by_nothing(before, after):
    assert elasticity(before, after) == 0.0


def test_the_strongest_counts_whichever_way_it_works():
    assert limiting({"time": -0.5, "temperature": -1.5, "standoff": 0.2}) == "temperature"
    assert limiting({"time": -0.5, "standoff": 0.9}) == "standoff"
    assert limiting({"time": 0.0, "temperature": 0.0}) == ""
    assert limiting({}) == ""
