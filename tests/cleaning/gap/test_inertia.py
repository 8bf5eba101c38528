"""Inertia against viscosity in thin gaps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.gap.inertia import inertial, lubrication_velocity, plug_front_m, reduced_reynolds

HEIGHTS = np.array([25e-6, 50e-6, 100e-6, 150e-6, 250e-6])


def test_inertia_slows_high_gaps_most() -> None:
    pure = lubrication_velocity(1000.0, HEIGHTS, 7e-3, 0.6e-3)
    np.testing.assert_allclose(pure, [0.0124, 0.0496, 0.198, 0.446, 1.240], rtol=3e-3)
    slowed = inertial(pure, HEIGHTS, 7e-3, 1000.0, 0.6e-3, 0.5)
    np.testing.assert_allclose(slowed, [0.0124, 0.0495, 0.193, 0.394, 0.736], rtol=3e-3)


@settings(deadline=None, max_examples=50)
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


def test_a_plug_opens_by_seven_tenths_of_a_millimetre_in_ten_minutes() -> None:
    assert plug_front_m(0.012, 100e-6, 600.0) == pytest.approx(0.72e-3)
