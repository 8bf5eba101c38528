"""Spacings of parallel passes that lay an even film: the valleys of its ripple.

Endless parallel passes at spacing d, each of which leaves q(x) across its line, add up to a film that repeats itself
every d. Its ripple, (max - min) / (max + min), has a valley for each number of passes that overlap, and hills between.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from geometry.arrays import Scalars

_STEPS = 400
"""Spacings that are tried per half width of the profile."""
_PLACES = 1024
"""Across one spacing."""
_WORST = 0.25
"""Ripple above which a valley is none."""
_EXACT = 1e-6


@dataclass(frozen=True, slots=True)
class Spacing:
    """The film of endless parallel passes. Lengths in the unit of the profile's places, films in that of its values."""

    spacing: float
    low: float
    high: float
    mean: float

    @property
    def ripple(self) -> float:
        """Half of what the film varies by, relative to the middle between its extremes."""
        return (self.high - self.low) / (self.high + self.low)

    @property
    def middle(self) -> float:
        """Between the extremes: what a minimax film puts on its target."""
        return 0.5 * (self.high + self.low)


def overlap(across: Scalars, film: Scalars, spacing: float) -> Spacing:
    """Add up endless parallel passes.

    Args:
        across: (n,) places across a pass, ascending.
        film: (n,) what it leaves there; nothing beyond its ends.
        spacing: Between neighbouring passes, above 0.
    """
    places = np.linspace(0.0, spacing, _PLACES + 1)  # both ends included
    first = int(np.floor((across[0] - spacing) / spacing))
    last = int(np.ceil(across[-1] / spacing)) + 1
    shifts = np.arange(first, last + 1)[:, None] * spacing
    sums = np.interp(places + shifts, across, film, left=0.0, right=0.0).sum(axis=0)
    return Spacing(spacing, float(sums.min()), float(sums.max()), float(np.trapezoid(film, across)) / spacing)


def find_spacings(across: Scalars, film: Scalars, least: float) -> tuple[Spacing, ...]:
    """Find every valley of the ripple, widest spacing first.

    Args:
        across: (n,) places across a pass, ascending.
        film: (n,) what it leaves there, nowhere negative.
        least: Spacing below which none is looked for, above 0.

    Returns:
        Local minima with a ripple of at most a quarter; none where passes leave nothing.
    """
    wet = np.flatnonzero(film > 0.0)
    if not wet.size:
        return ()
    width = float(across[min(wet[-1] + 1, len(across) - 1)] - across[max(wet[0] - 1, 0)])
    count = max(8, int(np.ceil(2 * _STEPS * (width - least) / width)))
    tried = np.geomspace(width, least, count) if least < width else np.array([width])

    def ripple(spacing: float) -> float:
        return overlap(across, film, spacing).ripple

    ripples = [ripple(float(each)) for each in tried]
    found: list[Spacing] = []
    for at in range(1, len(tried) - 1):
        if ripples[at] <= min(ripples[at - 1], ripples[at + 1]) and ripples[at] < _WORST:
            bounds = float(tried[at + 1]), float(tried[at - 1])
            best = minimize_scalar(ripple, bounds=bounds, method="bounded", options={"xatol": _EXACT * width})
            found.append(overlap(across, film, float(best.x)))
    return tuple(found)
