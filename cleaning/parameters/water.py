"""Properties of pure water and of air at one atmosphere, by temperature."""

import math

_ZERO_C = 273.15
_CRITICAL_K = 647.096
_ATMOSPHERE_PA = 101325.0
_AIR_J_KG_K = 287.05
_VISCOSITY = ((280.68, -1.9), (511.45, -7.7), (61.131, -19.6), (0.45903, -40.0))


def water_surface_tension_n_m(temperature_c: float) -> float:
    """Surface tension of water against its vapour, which that against air is equal to within measurement.

    IAPWS R1-76 (2014), from the triple point to the critical point.
    """
    tau = max(0.0, 1.0 - (temperature_c + _ZERO_C) / _CRITICAL_K)
    return 0.2358 * tau**1.256 * (1.0 - 0.625 * tau)


def water_viscosity_pa_s(temperature_c: float) -> float:
    """Dynamic viscosity of liquid water, within 1 % from -20 to 110 degrees C (IAPWS SR6-08, 2011, equation 6)."""
    reduced = (temperature_c + _ZERO_C) / 300.0
    return 1e-6 * sum(factor * reduced**power for factor, power in _VISCOSITY)


def air_viscosity_pa_s(temperature_c: float) -> float:
    """Dynamic viscosity of air by Sutherland's formula, with the constants of the U.S. Standard Atmosphere (1976)."""
    kelvin = temperature_c + _ZERO_C
    return 1.458e-6 * kelvin * math.sqrt(kelvin) / (kelvin + 110.4)


def air_density_kg_m3(temperature_c: float) -> float:
    """Density of dry air as an ideal gas at one atmosphere: a jet in the open has expanded to it."""
    return _ATMOSPHERE_PA / (_AIR_J_KG_K * (temperature_c + _ZERO_C))
