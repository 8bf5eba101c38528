"""Blowing water out of gaps, and evaporating what stays."""

import math
from collections.abc import Sequence

from cleaning.errors import require_not_negative, require_positive, require_temperature
from cleaning.gap.edge_segments import EdgePressure
from cleaning.parameters.liquid import (
    density_kg_m3,
    latent_heat_j_kg,
    saturation_pa,
    surface_tension_n_m,
    vapour_diffusivity_m2_s,
    vapour_kg_m3,
    vapour_pressure_pa,
    wet_surface_c,
)
from cleaning.parameters.model import Drying
from cleaning.process.stages import Stage


def dry_gap(
    drying: Drying, stages: Sequence[Stage], pressures: Sequence[EdgePressure | None], height_m: float, depth_m: float
) -> tuple[float, float] | None:
    """Blow out and evaporate what the last liquid leaves in a gap.

    Args:
        drying: How.
        stages: Of the process. Its warmest air, or the bake that follows, evaporates.
        pressures: On the edges, one per stage; ``None`` where the stage sprays another side, as good as no pressure.
        height_m: Of the gap.
        depth_m: From its edge to its farthest place.

    Returns:
        The least gap that is blown clear, m (infinite if none is), and how long what stays there takes to evaporate, s.
        ``None`` if the process does not dry, or wets nothing.
    """
    gases = [(stage, pressure) for stage, pressure in zip(stages, pressures, strict=True) if stage.use == "dry"]
    liquids = [stage for stage in stages if stage.use != "dry"]
    if not gases or not liquids:
        return None
    liquid, warmth = liquids[-1].liquid, liquids[-1].temperature_c
    pressed = [each.pressure_pa for _, each in gases if each is not None and len(each.sample)]
    # The highest pressure of one edge over another at one time; suction behind the part is in the coefficient.
    heads = ((values.max(axis=1) - values.min(axis=1).clip(min=0.0)).max() for values in pressed)
    head = float(max(heads, default=0.0))
    least = blow_off_m(drying, surface_tension_n_m(liquid, warmth), head)
    air_c = max(stage.temperature_c for stage, _ in gases) if drying.bake_c is None else drying.bake_c
    density = density_kg_m3(liquid, warmth)
    if height_m >= least:
        return least, film_dry_s(drying, air_c, 1e-6 * drying.residual_film_um, density)
    return least, gap_dry_s(drying, air_c, depth_m, density)


def blow_off_m(drying: Drying, tension_n_m: float, head_pa: float) -> float:
    """Give the least gap height from which a stream of gas drives the liquid; infinite if there is no stream.

    The two ends of a slug hold it back by what their contact angles differ: 2 gamma (cos receding - cos advancing) / h.

    Args:
        drying: Has the angles, and which share of the head is found between two edges of a part.
        tension_n_m: Surface tension of the liquid.
        head_pa: rho U^2 / 2 of the gas at the part; none where it blows from elsewhere.
    """
    require_not_negative(tension_n_m=tension_n_m, head_pa=max(head_pa, 0.0))
    if head_pa <= 0.0:
        return math.inf
    grip = math.cos(math.radians(drying.receding_deg)) - math.cos(math.radians(drying.advancing_deg))
    return max(2.0 * tension_n_m * grip, 0.0) / (drying.pressure_coefficient * head_pa)


def film_dry_s(drying: Drying, air_c: float, film_m: float, liquid_kg_m3: float) -> float:
    """How long a film takes to evaporate from a surface that heated room air is blown on; infinite if it never does.

    Args:
        drying: Has the room's air and the heat transfer.
        air_c: Of the heated air.
        film_m: Thickness.
        liquid_kg_m3: Density of the liquid, which evaporates as water does.
    """
    require_temperature(air_c=air_c)
    require_not_negative(film_m=film_m)
    require_positive(liquid_kg_m3=liquid_kg_m3)
    surface = wet_surface_c(air_c, vapour_pressure_pa(drying.room_c, drying.room_humidity_pct))
    heat = drying.transfer_w_m2_k * (air_c - surface)
    return liquid_kg_m3 * film_m * latent_heat_j_kg(surface) / heat if heat > 0.0 else math.inf


def gap_dry_s(drying: Drying, board_c: float, depth_m: float, liquid_kg_m3: float) -> float:
    """How long a gap full of liquid takes to evaporate through its edge; infinite if it never does.

    The meniscus recedes while vapour diffuses past the emptied part to the edge: t = rho L^2 / (2 D (rho_s - rho_a))
    (Stefan 1873, without the drift of the vapour itself, which only makes it faster).

    Args:
        drying: Has the room's air.
        board_c: Of the board.
        depth_m: From the edge to the farthest place.
        liquid_kg_m3: Density of the liquid, which evaporates as water does.
    """
    require_temperature(board_c=board_c)
    require_not_negative(depth_m=depth_m)
    require_positive(liquid_kg_m3=liquid_kg_m3)
    present = vapour_kg_m3(vapour_pressure_pa(drying.room_c, drying.room_humidity_pct), board_c)
    drive = vapour_kg_m3(saturation_pa(board_c), board_c) - present
    if drive <= 0.0:
        return math.inf
    return liquid_kg_m3 * depth_m**2 / (2.0 * vapour_diffusivity_m2_s(board_c) * drive)
