"""What leaves an orifice: flow, speed, and the force with which it would hit a wall. SI units.

Flow and impact follow the usual spray handbooks: flow goes with a power of the pressure, and the total impact is the
momentum that passes the orifice each second without losses.
"""

import math

from cleaning.require import require_not_negative, require_positive

AMBIENT_PA = 101_325.0
_HEAT_RATIO = 1.4
"""Ratio of the specific heats of air."""


def flow_m3_s(reference_m3_s: float, reference_pa: float, pressure_pa: float, exponent: float) -> float:
    """Flow at a pressure, from that at a reference pressure: Q = Q_ref (P / P_ref)^n."""
    require_positive(reference_pa=reference_pa, exponent=exponent)
    require_not_negative(reference_m3_s=reference_m3_s, pressure_pa=pressure_pa)
    return reference_m3_s * (pressure_pa / reference_pa) ** exponent


def liquid_speed_m_s(pressure_pa: float, density_kg_m3: float, discharge: float) -> float:
    """Speed of a liquid behind an orifice: v = C_v sqrt(2 P / rho), Bernoulli with a velocity coefficient."""
    require_positive(density_kg_m3=density_kg_m3)
    require_not_negative(pressure_pa=pressure_pa, discharge=discharge)
    return discharge * math.sqrt(2 * pressure_pa / density_kg_m3)


def gas_speed_m_s(pressure_pa: float, density_kg_m3: float, discharge: float) -> float:
    """Speed of a gas behind an orifice, no faster than sound in its throat.

    Isentropic expansion from the pressure above ambient; where that would be faster than sound, a plain orifice chokes
    and the speed is sound's at the throat, sqrt(2 gamma / (gamma + 1) p / rho).

    Args:
        pressure_pa: Before the orifice, above ambient.
        density_kg_m3: At ambient pressure and the temperature before the orifice.
        discharge: Velocity coefficient.
    """
    require_positive(density_kg_m3=density_kg_m3)
    require_not_negative(pressure_pa=pressure_pa, discharge=discharge)
    heat = _HEAT_RATIO
    expanded = 1 - (AMBIENT_PA / (AMBIENT_PA + pressure_pa)) ** ((heat - 1) / heat)
    squared = min(expanded / (heat - 1), 1 / (heat + 1))
    return discharge * math.sqrt(2 * heat * AMBIENT_PA / density_kg_m3 * squared)


def total_impact_n(flow_m3_s: float, pressure_pa: float, density_kg_m3: float) -> float:
    """Force of a whole spray against a wall at right angles to it: rho Q sqrt(2 P / rho), without losses."""
    require_positive(density_kg_m3=density_kg_m3)
    require_not_negative(flow_m3_s=flow_m3_s, pressure_pa=pressure_pa)
    return density_kg_m3 * flow_m3_s * math.sqrt(2 * pressure_pa / density_kg_m3)
