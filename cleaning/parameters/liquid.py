"""Properties by temperature: of water, air and moist air at one atmosphere, and of solutions and gases in a process."""

import math
from typing import cast

from cleaning.errors import require_not_negative, require_positive, require_temperature
from cleaning.parameters.model import Liquid

_ZERO_C = 273.15
_ATMOSPHERE_PA = 101325.0
_GAS_CONSTANT = 8.314462618
_WATER_KG_MOL = 0.01801528
_AIR_J_KG_K = 287.05
_AIR_HEAT_J_KG_K = 1007.0
_LEWIS = 0.87
"""Thermal diffusivity of air over the diffusivity of vapour in it."""
_CRITICAL_K, _CRITICAL_PA = 647.096, 22.064e6
_COLDEST_C = -100.0
"""No wet surface gets colder: even dry air at room temperature keeps it near 6 degrees C."""
_VISCOSITY = ((280.68, -1.9), (511.45, -7.7), (61.131, -19.6), (0.45903, -40.0))
_SATURATION = (
    (-7.85951783, 1.0),
    (1.84408259, 1.5),
    (-11.7866497, 3.0),
    (22.6807411, 3.5),
    (-15.9618719, 4.0),
    (1.80122502, 7.5),
)


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


def saturation_pa(temperature_c: float) -> float:
    """Vapour pressure of liquid water (Wagner and Pruss, J. Phys. Chem. Ref. Data 31 (2002) 387, equation 2.5).

    Above the critical point, where there is no liquid, it stays what it is there.
    """
    kelvin = min(temperature_c + _ZERO_C, _CRITICAL_K)
    tau = 1.0 - kelvin / _CRITICAL_K
    return _CRITICAL_PA * math.exp(_CRITICAL_K / kelvin * sum(factor * tau**power for factor, power in _SATURATION))


def vapour_kg_m3(pressure_pa: float, temperature_c: float) -> float:
    """Density of vapour at its partial pressure, as an ideal gas."""
    return pressure_pa * _WATER_KG_MOL / (_GAS_CONSTANT * (temperature_c + _ZERO_C))


def latent_heat_j_kg(temperature_c: float) -> float:
    """Heat of evaporation of water, linear between 0 and 100 degrees C, within 0.4 % of tables."""
    return 2.501e6 - 2.44e3 * temperature_c


def vapour_diffusivity_m2_s(temperature_c: float) -> float:
    """Diffusivity of vapour in air at one atmosphere (Massman, Atmos. Environ. 32 (1998) 1111)."""
    return 2.178e-5 * ((temperature_c + _ZERO_C) / _ZERO_C) ** 1.81


def vapour_pressure_pa(room_c: float, humidity_pct: float) -> float:
    """Partial pressure of the vapour in room air; warming the air does not change it."""
    return 0.01 * humidity_pct * saturation_pa(room_c)


def wet_surface_c(air_c: float, vapour_pa: float) -> float:
    """Find how cold a wet surface gets in a stream of air: what heat arrives evaporates water.

    Solves ``h (Ta - Ts) = h_m L (rho_s(Ts) - rho_a)`` with ``h_m = h / (rho c_p Le^(2/3))`` (Chilton and Colburn), from
    which the heat transfer h cancels. Radiation is left out.

    Args:
        air_c: Of the stream.
        vapour_pa: Partial pressure of the vapour in it; what is more than saturates it does not count.
    """
    require_temperature(air_c=air_c)
    require_not_negative(vapour_pa=vapour_pa)
    present = vapour_kg_m3(min(vapour_pa, saturation_pa(air_c)), air_c)

    def surplus(surface_c: float) -> float:
        mean_k = 0.5 * (air_c + surface_c) + _ZERO_C
        volumetric = _ATMOSPHERE_PA / (_AIR_J_KG_K * mean_k) * _AIR_HEAT_J_KG_K * _LEWIS ** (2.0 / 3.0)
        lost = vapour_kg_m3(saturation_pa(surface_c), surface_c) - present
        return volumetric * (air_c - surface_c) - latent_heat_j_kg(surface_c) * lost

    if air_c <= _COLDEST_C or surplus(air_c) >= 0.0:
        return air_c
    from scipy.optimize import brentq  # takes a third of a second, and few programs blow

    return cast(float, brentq(surplus, _COLDEST_C, air_c, xtol=1e-9))


_STATED_AT_C = 60.0


def surface_tension_n_m(liquid: Liquid, temperature_c: float) -> float:
    """Surface tension as stated, else that of pure water (for a gas: of the water that it is to blow off).

    What is stated holds at every temperature: how a surfactant's tension changes with it is not invented.
    """
    require_temperature(temperature_c=temperature_c)
    if liquid.surface_tension_mn_m is not None:
        return 1e-3 * liquid.surface_tension_mn_m
    return water_surface_tension_n_m(temperature_c)


def viscosity_pa_s(liquid: Liquid, temperature_c: float) -> float:
    """Viscosity as stated at 60 degrees C, changing with temperature as water's, or as air's for a gas; else theirs."""
    require_temperature(temperature_c=temperature_c)
    pure = air_viscosity_pa_s if liquid.use == "dry" else water_viscosity_pa_s
    if liquid.viscosity_mpa_s is None:
        return pure(temperature_c)
    return 1e-3 * liquid.viscosity_mpa_s * pure(temperature_c) / pure(_STATED_AT_C)


def density_kg_m3(liquid: Liquid, temperature_c: float) -> float:
    """Density as stated; of a gas that does not state it, that of air at the temperature."""
    require_temperature(temperature_c=temperature_c)
    if liquid.use == "dry" and "density_kg_m3" not in liquid.model_fields_set:
        return air_density_kg_m3(temperature_c)
    return liquid.density_kg_m3


def capillary_pa(liquid: Liquid, temperature_c: float, height_m: float) -> float:
    """Pressure with which a gap draws the liquid in; below 0 it must be forced in (Young and Laplace, two plates).

    Args:
        liquid: Its contact angles are those on the board and on the component.
        temperature_c: Of the process.
        height_m: Height of the gap that residue leaves open.
    """
    require_positive(height_m=height_m)
    board, part = (math.cos(math.radians(angle)) for angle in (liquid.contact_board_deg, liquid.contact_part_deg))
    return 2.0 * surface_tension_n_m(liquid, temperature_c) * (0.5 * (board + part)) / height_m
