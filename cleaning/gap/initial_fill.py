"""How much of a gap is filled with residue before the wash.

Half of solder paste is flux by volume, and some of that stays when it is soldered. What the joints squeeze out of a
print spreads over the open part of the gap; since the gap is about half as high as the print, the stencil's thickness
cancels, and the share of the height that is filled follows from the share of the area that joints take.
"""

from cleaning.errors import CleaningError
from cleaning.parameters.model import Gap, Soil
from cleaning.require import require_not_negative

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


def is_plugged(gap: Gap, fill: float) -> bool:
    """Tell whether so much residue is in the gap that nothing flows through it."""
    return fill >= gap.plugged


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
