"""What happens under one component in the stages of a process."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cleaning.gap.flow_field import GapField


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
