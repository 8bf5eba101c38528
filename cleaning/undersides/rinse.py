"""Dilution of what the wash leaves, by exchanging the liquid over and over."""

import math
from collections.abc import Sequence

from cleaning.errors import require_not_negative, require_positive
from cleaning.parameters.model import Liquid, Rinse
from cleaning.process.stages import Stage
from cleaning.undersides.gap_result import GapStage

_PURE_WATER_US_CM = 0.055
"""Conductivity of pure water at 25 degrees C: its own ions."""
_SALT_US_CM_PER_G_M3 = 2.16
"""Conductivity that a gram of common salt in a cubic metre of water adds."""


def film_exchanges(rinse: Rinse, volume_mm: float) -> float:
    """How often the film on an exposed surface is renewed by a volume of liquid per area, mm."""
    require_not_negative(volume_mm=volume_mm)
    return 1000.0 * volume_mm / rinse.film_um


def bath_g_m3(liquid: Liquid) -> float:
    """What a bath carries and leaves behind when it dries, from its share of non-volatile residue by weight."""
    return 10.0 * liquid.bath_nvr_pct * liquid.density_kg_m3


def salt_g_m3(resistivity_mohm_cm: float | None) -> float:
    """Ions in water as common salt, from its resistivity; none where it is not stated or above that of pure water."""
    if resistivity_mohm_cm is None:
        return 0.0
    require_positive(resistivity_mohm_cm=resistivity_mohm_cm)
    return max(0.0, (1.0 / resistivity_mohm_cm - _PURE_WATER_US_CM) / _SALT_US_CM_PER_G_M3)


def resistivity_mohm_cm(content_g_m3: float) -> float:
    """Resistivity of water that carries so much common salt; the inverse of ``salt_g_m3``."""
    require_not_negative(content_g_m3=content_g_m3)
    return 1.0 / (_PURE_WATER_US_CM + _SALT_US_CM_PER_G_M3 * content_g_m3)


def water_g_m3(stage: Stage) -> float:
    """What the water of a rinse brings, as common salt: as its tank has it, else as its resistivity states."""
    return salt_g_m3(stage.liquid.resistivity_mohm_cm) if stage.water_g_m3 is None else stage.water_g_m3


def water_resistivity(stage: Stage) -> float | None:
    """Resistivity of the water of a rinse, MOhm cm; ``None`` where nothing states it."""
    return stage.liquid.resistivity_mohm_cm if stage.water_g_m3 is None else resistivity_mohm_cm(stage.water_g_m3)


def diluted_g_m3(rinse: Rinse, before_g_m3: float, exchanges: float, water_g_m3: float) -> float:
    """What is in the liquid after a rinse: what was there beyond what the water brings fades away, exp(-eta N).

    So two rinses one after the other are as good as one of as many exchanges, and none leaves more than was there. Of
    liquid that was purer than the water it is not assumed that it stays so.

    Args:
        rinse: Has the efficiency of an exchange, eta.
        before_g_m3: What was in the liquid.
        exchanges: N.
        water_g_m3: What the water brings.
    """
    require_not_negative(before_g_m3=before_g_m3, exchanges=exchanges, water_g_m3=water_g_m3)
    return water_g_m3 + max(before_g_m3 - water_g_m3, 0.0) * math.exp(-rinse.efficiency * exchanges)


def ionic_ug_cm2(content_g_m3: float, film_um: float) -> float:
    """What stays on a surface when a film on it dries: an index, not a measurement."""
    require_not_negative(content_g_m3=content_g_m3, film_um=film_um)
    return 1e-4 * content_g_m3 * film_um


def gap_content_g_m3(rinse: Rinse, stages: Sequence[Stage], gaps: Sequence[GapStage | None]) -> float:
    """Give what the liquid carries that stays in a gap at the end; nothing where no liquid got in.

    Each wash that enters brings its bath; each rinse that enters dilutes what is there, as often as it may
    be repeated.
    """
    content = 0.0
    for stage, gap in zip(stages, gaps, strict=True):
        if gap is None or not gap.entered:
            continue
        if stage.use == "wash":
            content = bath_g_m3(stage.liquid)
        else:
            content = diluted_g_m3(rinse, content, stage.repeats * gap.exchanges, water_g_m3(stage))
    return content
