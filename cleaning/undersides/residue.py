"""Residue in a gap: how much of it there is before the wash, and the kinetics of its removal.

Half of solder paste is flux by volume, and some of that stays when it is soldered. What the joints squeeze out of a
print spreads over the open part of the gap; since the gap is about half as high as the print, the stencil's thickness
cancels, and the share of the height that is filled follows from the share of the area that joints take.

Hard residue softens by chemistry, soft residue is carried off by shear. The form follows what is seen on rosin flux
(Beaudoin and others, Ind. Eng. Chem. Res. 34 (1995) 3307): the solution soaks the film, then shear strips it. With H
the hard and S the softened share,

    dH/dt = -k1 H        dS/dt = k1 H - k2 S

and H + S is what is left. For rates that are constant during a step the solution is exact, whatever the step's length.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cleaning.errors import CleaningError, require_not_negative, require_temperature
from cleaning.gap.flow_field import GapField
from cleaning.parameters.model import Gap, Soil


@dataclass(frozen=True, slots=True, eq=False)
class GapStage:
    """One gap in one stage. SI."""

    margin_pa: float
    """Highest edge pressure that is held, plus the capillary pressure: what opens the gap; below 0 it stays dry."""
    entered: bool
    edge_pa: tuple[float, ...]
    """(8,) highest pressure on each segment."""
    side_shear_pa: tuple[float, ...]
    """(4,) 10th percentile of the wall shear that each side alone makes at its best: front, right, back, left."""
    shear_pa: NDArray[np.float32]
    """(cells,) highest wall shear."""
    weak_share: float
    """Share of the gap whose highest wall shear is below the limit."""
    exchanges: float
    """How often the liquid in the gap is renewed."""
    reynolds: float
    """Highest reduced Reynolds number."""
    wet_s: float
    """From the first entry to the end of the stage."""
    residue: NDArray[np.float32]
    """(cells,) share of the residue that is left at the end of the stage."""


@dataclass(frozen=True, slots=True, eq=False)
class GapResult:
    """One gap through all stages."""

    gap_height_mm: float
    field: GapField
    fill: float
    """f0: share of the gap's height that residue fills before the wash."""
    stages: tuple[GapStage | None, ...]
    """One per stage of the report; ``None`` where the stage does not act on it (another side, or gas)."""
    exchanges_needed: float
    """N_cap: renewals that can carry the residue away."""
    residue: float
    """Mean share that is left at the end; 1 where nothing entered."""
    residue_worst: float
    """Mean of the worst tenth."""
    worst_at: tuple[float, float]
    """Where that is, in the frame of the underside, mm."""
    ionic_ug_cm2: float
    """Index of what the last rinse leaves, not a measurement."""
    blow_off_um: float | None
    """Least gap that the drying clears; ``None`` without a drying stage."""
    dry_s: float | None
    """How long what is left takes to evaporate; ``None`` without a drying stage."""


GAS_CONSTANT = 8.314462618
"""J / (mol K)"""
ZERO_C = 273.15
REFERENCE_C = 60.0
"""Temperature at which ``Soil.k1_per_s`` holds."""
_LEAST_OPEN = 0.01


def fill_share(soil: Soil, coverage: float, paste_factor: float | None = None) -> float:
    """Give f0, the share of the gap's height that residue fills before the wash: 0 to 1, where the gap is bridged.

    Args:
        soil: What is to be removed.
        coverage: Share of the underside that joints take, 0 to 1.
        paste_factor: Scales f0 for this part; left out: that of the soil.

    Raises:
        CleaningError: the coverage is no share.
    """
    require_not_negative(coverage=coverage)
    if coverage > 1.0:
        raise CleaningError(f"coverage must be a share of at most 1, not {coverage:g}")
    factor = soil.paste_factor if paste_factor is None else paste_factor
    amount = soil.retained * factor * coverage
    free = 1.0 - coverage
    return 1.0 if amount >= free else amount / free


def open_share(gap: Gap, fill: float) -> float:
    """Give the share of the gap's height in which liquid can stand; of a plugged gap that at its rim, never nothing."""
    return max(1.0 - min(fill, gap.plugged), _LEAST_OPEN)


def exchanges_needed(soil: Soil, gap: Gap, fill: float) -> float:
    """Give N_cap: how often the liquid of a gap must be renewed to carry away the residue in it.

    The balance of what is there against what the liquid can carry: f0 rho / ((1 - f0) c). A plugged gap counts as one
    that is just not plugged, so that the number stays finite.
    """
    open_ = open_share(gap, fill)
    return (1.0 - open_) * soil.density_kg_m3 / (open_ * gap.capacity_kg_m3)


def softening_rate(soil: Soil, temperature_c: float, concentration_pct: float) -> float:
    """Give k1, 1/s: Arrhenius in temperature, saturating in concentration; 0 without a cleaning agent."""
    require_temperature(temperature_c=temperature_c)
    require_not_negative(concentration_pct=concentration_pct)
    warmth = 1.0 / (ZERO_C + temperature_c) - 1.0 / (ZERO_C + REFERENCE_C)
    arrhenius = math.exp(-1000.0 * soil.activation_kj_mol / GAS_CONSTANT * warmth)
    saturation = concentration_pct / (concentration_pct + soil.half_pct)
    reference = soil.reference_pct / (soil.reference_pct + soil.half_pct)
    return soil.k1_per_s * arrhenius * saturation / reference


def removal_rate(soil: Soil, shear_pa: NDArray[np.floating]) -> NDArray[np.float64]:
    """Give k2, 1/s, for each wall shear: a power of it above the threshold, else 0."""
    shear = np.asarray(shear_pa, dtype=np.float64)
    require_not_negative(shear_pa=shear)
    rate = soil.k_m_per_s * (shear / soil.shear_reference_pa) ** soil.shear_exponent
    return np.where(shear > soil.shear_threshold_pa, rate, 0.0)


def step(
    hard: NDArray[np.float64] | float,
    soft: NDArray[np.float64] | float,
    k1: NDArray[np.float64] | float,
    k2: NDArray[np.float64] | float,
    seconds: NDArray[np.float64] | float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Let residue soften and leave for a while at constant rates.

    Args:
        hard: Share that is hard, of any shape.
        soft: Share that is soft.
        k1: Softening, 1/s, not negative.
        k2: Removal, 1/s, not negative.
        seconds: How long, not negative. All arguments broadcast.

    Returns:
        What is hard and what is soft afterwards.

    Raises:
        CleaningError: a number is negative or not finite.
    """
    require_not_negative(hard=hard, soft=soft, k1=k1, k2=k2, seconds=seconds)
    hard_, soft_ = np.asarray(hard, dtype=np.float64), np.asarray(soft, dtype=np.float64)
    a = np.asarray(k1, dtype=np.float64) * seconds
    b = np.asarray(k2, dtype=np.float64) * seconds
    # The slower rate is taken out of the exponentials: nothing can overflow, and a = b is no special case.
    apart = np.abs(b - a)
    some = np.where(apart > 0.0, apart, 1.0)
    mean_decay = np.where(apart > 0.0, -np.expm1(-some) / some, 1.0)  # (1 - exp(-x)) / x, which is 1 at 0
    return hard_ * np.exp(-a), soft_ * np.exp(-b) + hard_ * (a * np.exp(-np.minimum(a, b)) * mean_decay)
