"""The compiled walk through a stage does what the plain formulas say, pulse by pulse."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from cleaning.gap.flushing import (
    Flushed,
    FlushSettings,
    bounded,
    flush,
    inertial,
    lubrication_velocity,
    reduced_reynolds,
)
from cleaning.parameters.load import load_parameters
from cleaning.undersides.residue import removal_rate, softening_rate, step

SOIL = load_parameters("default").soil
CELLS = 25
THIN_M_S = 0.05
"""The speeds of `case_of` lie on both sides of it."""
WEIGHTS = np.arange(1.0, CELLS + 1) / np.arange(1.0, CELLS + 1).sum()


def setting_of(fill: float = 0.4, exponent: float = 1.0, k1: float = 0.012) -> FlushSettings:
    return FlushSettings(
        weights=WEIGHTS,
        height_m=60e-6,
        path_m=5e-3,
        fill=fill,
        viscosity_pa_s=6e-4,
        drag_pa_s2_m2=750.0,
        thin_m_s=THIN_M_S,
        k1_per_s=k1,
        k2_per_s=SOIL.k_m_per_s,
        shear_exponent=exponent,
        shear_threshold_pa=SOIL.shear_threshold_pa,
    )


def case_of(seed: int, pulses: int = 20) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.float64]]:
    random = np.random.default_rng(seed)
    basis = random.normal(scale=4e-8, size=(2, 8, CELLS)).astype(np.float32)
    return basis, random.uniform(-250.0, 800.0, (pulses, 8)), random.uniform(0.0, 5.0, (pulses, 2))


def walk(
    basis: NDArray[np.float32], pressures: NDArray[np.float64], seconds: NDArray[np.float64], setting: FlushSettings
) -> Flushed:
    """Do the same slowly, with the plain formulas."""
    soil = SOIL.model_copy(update={"shear_exponent": setting.shear_exponent})
    hard, soft = np.float64(1.0), np.zeros(CELLS)
    highest, travelled, fastest = np.zeros(CELLS), 0.0, 0.0
    for p, (soak, pulse) in zip(pressures, seconds, strict=True):
        _, soft = step(hard, soft, setting.k1_per_s, 0.0, soak)
        hard = hard * np.exp(-setting.k1_per_s * soak)
        open_ = 1.0 - setting.fill * float((hard + soft) @ WEIGHTS)
        flow = np.hypot(*np.einsum("s,dsc->dc", p, basis.astype(np.float64)))
        plain = float(flow @ WEIGHTS) * open_**2 / setting.viscosity_pa_s
        speed = float(inertial(plain, setting.height_m * open_, setting.path_m, 1000.0, setting.viscosity_pa_s, 0.5))
        fastest = max(fastest, speed)
        speed = float(bounded(speed, speed, setting.thin_m_s))
        shear = 6.0 * flow * open_ / setting.height_m * speed / plain
        highest = np.maximum(highest, shear)
        travelled += speed * pulse
        _, soft = step(hard, soft, setting.k1_per_s, removal_rate(soil, shear), pulse)
        hard = hard * np.exp(-setting.k1_per_s * pulse)
    return Flushed(float(hard), soft, highest, travelled, fastest)


@settings(max_examples=30)
@given(
    seed=st.integers(0, 10_000), fill=st.floats(0.0, 0.85), exponent=st.sampled_from([0.5, 1.0, 1.7]),
    k1=st.sampled_from([0.0, 0.012, 0.3]),
)  # fmt: skip
def test_it_does_what_the_formulas_say(seed: int, fill: float, exponent: float, k1: float) -> None:
    basis, pressures, seconds = case_of(seed)
    setting = setting_of(fill, exponent, k1)
    fast = flush(basis, pressures, seconds, setting, 1.0, np.zeros(CELLS))
    plain = walk(basis, pressures, seconds, setting)
    assert fast.hard == pytest.approx(plain.hard, rel=1e-12)
    np.testing.assert_allclose(fast.soft, plain.soft, rtol=2e-5, atol=1e-9)
    np.testing.assert_allclose(fast.shear_pa, plain.shear_pa, rtol=2e-5)
    assert fast.travelled_m == pytest.approx(plain.travelled_m, rel=1e-5)
    assert fast.fastest_m_s == pytest.approx(plain.fastest_m_s, rel=1e-5)


def test_equal_rates_lose_no_digits() -> None:
    # one segment that makes exactly the shear at which k2 is about k1
    setting = setting_of(fill=0.0, k1=0.05)._replace(weights=np.ones(1))
    basis = np.zeros((2, 8, 1), dtype=np.float32)
    basis[0, 0, 0] = 1e-8
    pressure = np.zeros((1, 8))
    for shear in np.linspace(0.998, 1.002, 21):
        pressure[0, 0] = shear * setting.height_m / 6.0 / 1e-8
        done = flush(basis, pressure, np.array([[0.0, 20.0]]), setting, 1.0, np.zeros(1))
        _, soft = step(1.0, 0.0, 0.05, 0.05 * done.shear_pa[0], 20.0)
        assert done.soft[0] == pytest.approx(float(soft), rel=1e-9)


def test_what_it_was_given_stays_as_it_was() -> None:
    basis, pressures, seconds = case_of(3)
    soft = np.full(CELLS, 0.5)
    done = flush(basis, pressures, seconds, setting_of(), 0.5, soft)
    np.testing.assert_array_equal(soft, 0.5)
    assert (done.soft < 1.0).all()


def test_cutting_the_pulses_of_an_unfilled_gap_changes_nothing() -> None:
    basis, pressures, seconds = case_of(5)
    whole = flush(basis, pressures, seconds, setting_of(fill=0.0), 1.0, np.zeros(CELLS))
    again = np.zeros((40, 2))
    again[0::2, 0], again[0::2, 1], again[1::2, 1] = seconds[:, 0], 0.3 * seconds[:, 1], 0.7 * seconds[:, 1]
    halves = flush(basis, np.repeat(pressures, 2, axis=0), again, setting_of(fill=0.0), 1.0, np.zeros(CELLS))
    np.testing.assert_allclose(halves.soft, whole.soft, rtol=1e-10)
    assert halves.travelled_m == pytest.approx(whole.travelled_m, rel=1e-12)


def test_softening_at_the_rate_of_the_parameters_is_what_a_dead_pulse_does() -> None:
    k1 = softening_rate(SOIL, 50.0, 10.0)
    nothing = np.zeros((1, 8))
    basis, _, _ = case_of(1)
    done = flush(basis, nothing, np.array([[30.0, 70.0]]), setting_of(k1=k1), 1.0, np.zeros(CELLS))
    assert done.hard == pytest.approx(np.exp(-100.0 * k1), rel=1e-12)
    np.testing.assert_allclose(done.soft + done.hard, 1.0, rtol=1e-12)
    assert done.travelled_m == 0.0


@settings(max_examples=50)
@given(
    seed=st.integers(0, 10_000), k1=st.floats(0.0, 100.0), slow=st.floats(1e-3, 1e3), push=st.floats(0.0, 1e3),
    fill=st.floats(0.0, 0.85),
)  # fmt: skip
def test_residue_never_grows_and_is_never_negative(seed: int, k1: float, slow: float, push: float, fill: float) -> None:
    basis, pressures, seconds = case_of(seed)
    before = np.ones(CELLS)
    for upto in (0, 1, 5, 20):
        done = flush(
            basis, push * pressures[:upto], slow * seconds[:upto], setting_of(fill, k1=k1), 1.0, np.zeros(CELLS)
        )
        left = done.hard + done.soft
        assert (done.soft >= 0.0).all()
        assert done.hard >= 0.0
        assert (left <= before + 1e-8).all()
        before = left


HEIGHTS = np.array([25e-6, 50e-6, 100e-6, 150e-6, 250e-6])


def test_inertia_slows_high_gaps_most() -> None:
    pure = lubrication_velocity(1000.0, HEIGHTS, 7e-3, 0.6e-3)
    np.testing.assert_allclose(pure, [0.0124, 0.0496, 0.198, 0.446, 1.240], rtol=3e-3)
    slowed = inertial(pure, HEIGHTS, 7e-3, 1000.0, 0.6e-3, 0.5)
    np.testing.assert_allclose(slowed, [0.0124, 0.0495, 0.193, 0.394, 0.736], rtol=3e-3)


@settings(max_examples=50)
@given(
    pressure=st.floats(0.01, 1e4),
    height=st.floats(10e-6, 300e-6),
    path=st.floats(0.3e-3, 30e-3),
    viscosity=st.floats(1e-5, 5e-3),
    loss=st.floats(0.0, 2.0),
)
def test_pressure_pays_for_friction_and_speed(
    pressure: float, height: float, path: float, viscosity: float, loss: float
) -> None:
    pure = lubrication_velocity(pressure, height, path, viscosity)
    u = inertial(pure, height, path, 1000.0, viscosity, loss)
    friction, speed = 12 * viscosity * path / height**2, 1000.0 * (1 + loss) / 2
    assert friction * u + speed * u**2 == pytest.approx(pressure, rel=1e-9)
    assert 0 < u <= pure * (1 + 1e-12)
    assert inertial(-pure, height, path, 1000.0, viscosity, loss) == -u


def test_without_mass_nothing_changes() -> None:
    u = np.array([-0.3, 0.0, 0.2])
    np.testing.assert_array_equal(inertial(u, 100e-6, 5e-3, 0.0, 1e-3), u)


def test_reduced_reynolds_number() -> None:
    assert reduced_reynolds(0.2, 100e-6, 7e-3, 1000.0, 0.6e-3) == pytest.approx(0.47619, rel=1e-4)
    assert reduced_reynolds(-0.2, 100e-6, 7e-3, 1000.0, 0.6e-3) > 0


def test_beyond_a_thin_gap_half_of_the_speed_counts_at_least() -> None:
    # the model holds up to a reduced Reynolds number of 10; speeds and numbers by hand
    given = {0.3: 5.0, 0.6: 10.0, 0.9: 15.0, 1.2: 20.0, 1.8: 30.0}
    counted = [float(bounded(u, reynolds, 10.0)) for u, reynolds in given.items()]
    assert counted == pytest.approx([0.3, 0.6, 0.6, 0.6, 0.9])


@given(slower=st.floats(1e-6, 10.0), faster=st.floats(1.0, 10.0))
def test_more_speed_never_counts_less(slower: float, faster: float) -> None:
    per_speed = 17.0
    one, other = (float(bounded(u, per_speed * u, 10.0)) for u in (slower, slower * faster))
    assert one <= other * (1.0 + 1e-12)
    assert 0.5 * slower <= one <= slower
