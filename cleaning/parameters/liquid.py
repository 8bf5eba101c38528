"""What a solution or gas does at its process temperature: surface tension, viscosity, density, capillarity."""

import math

from cleaning.errors import require_positive, require_temperature
from cleaning.parameters.model import Liquid
from cleaning.parameters.water_and_air import (
    air_density_kg_m3,
    air_viscosity_pa_s,
    water_surface_tension_n_m,
    water_viscosity_pa_s,
)

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
