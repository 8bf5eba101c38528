"""Blowing water out of gaps, and evaporating what stays."""

import math

from cleaning.humid_air import (
    latent_heat_j_kg,
    saturation_pa,
    vapour_diffusivity_m2_s,
    vapour_kg_m3,
    vapour_pressure_pa,
    wet_surface_c,
)
from cleaning.parameters import Drying


def blow_off_m(drying: Drying, tension_n_m: float, difference_pa: float) -> float:
    """Give the least gap height from which a pressure difference drives the liquid; infinite if there is none.

    The two ends of a slug hold it back by what their contact angles differ: 2 gamma (cos receding - cos advancing) / h.

    Args:
        drying: Has the angles.
        tension_n_m: Surface tension of the liquid.
        difference_pa: Pressure of the gas between two edges of the gap.
    """
    if difference_pa <= 0.0:
        return math.inf
    grip = math.cos(math.radians(drying.receding_deg)) - math.cos(math.radians(drying.advancing_deg))
    return max(2.0 * tension_n_m * grip, 0.0) / difference_pa


def gas_difference_pa(drying: Drying, density_kg_m3: float, speed_m_s: float) -> float:
    """Give the pressure difference that a stream of gas makes across a component."""
    return drying.pressure_coefficient * 0.5 * density_kg_m3 * speed_m_s**2


def film_dry_s(drying: Drying, air_c: float, film_m: float, density_kg_m3: float) -> float:
    """How long a film takes to evaporate from a surface that heated room air is blown on; infinite if it never does.

    Args:
        drying: Has the room's air and the heat transfer.
        air_c: Of the heated air.
        film_m: Thickness.
        density_kg_m3: Of the liquid, which evaporates as water does.
    """
    surface = wet_surface_c(air_c, vapour_pressure_pa(drying.room_c, drying.room_humidity_pct))
    heat = drying.transfer_w_m2_k * (air_c - surface)
    return density_kg_m3 * film_m * latent_heat_j_kg(surface) / heat if heat > 0.0 else math.inf


def gap_dry_s(drying: Drying, board_c: float, depth_m: float, density_kg_m3: float) -> float:
    """How long a gap full of liquid takes to evaporate through its edge; infinite if it never does.

    The meniscus recedes while vapour diffuses past the emptied part to the edge: t = rho L^2 / (2 D (rho_s - rho_a))
    (Stefan 1873, without the drift of the vapour itself, which only makes it faster).

    Args:
        drying: Has the room's air.
        board_c: Of the board.
        depth_m: From the edge to the farthest place.
        density_kg_m3: Of the liquid, which evaporates as water does.
    """
    present = vapour_kg_m3(vapour_pressure_pa(drying.room_c, drying.room_humidity_pct), board_c)
    drive = vapour_kg_m3(saturation_pa(board_c), board_c) - present
    if drive <= 0.0:
        return math.inf
    return density_kg_m3 * depth_m**2 / (2.0 * vapour_diffusivity_m2_s(board_c) * drive)
