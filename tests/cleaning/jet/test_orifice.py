"""What leaves an orifice."""

import math

import pytest

from cleaning.jet.orifice import flow_m3_s, gas_speed_m_s, liquid_speed_m_s, total_impact_n

LITRE_PER_MINUTE = 1e-3 / 60
GALLON_PER_MINUTE = 3.785411784e-3 / 60
KILOGRAM_FORCE = 9.80665
POUND_FORCE = 4.4482216152605
PSI = POUND_FORCE / 0.0254**2


@pytest.mark.parametrize(
    ("flow", "pressure", "force", "constant"),
    [
        (LITRE_PER_MINUTE, KILOGRAM_FORCE / 1e-4, KILOGRAM_FORCE, 0.023801),
        (GALLON_PER_MINUTE, PSI, POUND_FORCE, 0.052668),
        (LITRE_PER_MINUTE, 1e5, 1.0, 0.235702),
        (LITRE_PER_MINUTE, 1e6, 1.0, 0.745356),
    ],
)
def test_the_constants_of_the_catalogues(flow, pressure, force, constant):
    assert total_impact_n(flow, pressure, 1000.0) / force == pytest.approx(constant, abs=1e-5)


def test_speed_behind_an_orifice():
    assert liquid_speed_m_s(3.5e5, 1000.0, 0.9) == pytest.approx(23.81, abs=0.005)


def test_flow_follows_a_power_of_the_pressure():
    assert flow_m3_s(2.0, 3e5, 12e5, 0.5) == pytest.approx(4.0)
    assert flow_m3_s(2.0, 3e5, 3e5, 0.46) == 2.0


def test_gas_is_never_faster_than_sound_in_its_throat():
    sound = math.sqrt(2 * 1.4 / 2.4 * 101_325.0 / 1.2)
    assert gas_speed_m_s(4e5, 1.2, 1.0) == pytest.approx(sound)
    assert gas_speed_m_s(8e5, 1.2, 1.0) == gas_speed_m_s(4e5, 1.2, 1.0)


def test_slow_gas_flows_as_a_liquid_would():
    assert gas_speed_m_s(500.0, 1.2, 0.9) == pytest.approx(liquid_speed_m_s(500.0, 1.2, 0.9), rel=2e-3)
