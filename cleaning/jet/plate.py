"""What a jet leaves on a flat plate: the flux under a nozzle that stands still, the film of one straight pass."""

import numpy as np
from numpy.typing import NDArray

from cleaning.jet.compiled_jet import JetForm, flux_of
from cleaning.jet.jet_coordinates import box_of, directions_of
from geometry.arrays import Scalars
from geometry.compiled import compiled

MICROMETRES = 1e6
"""Of a flux in m/s: film in um/s."""
_ACROSS, _ALONG = 2001, 500
_EDGE_SIGMAS = 5.0
_WIDEST = 20.0
"""Spray farther out than this many times the height is left out."""


def film_of_pass(form: JetForm, height_mm: float) -> tuple[Scalars, Scalars]:
    """Film across one straight pass with the nozzle at right angles to a plate.

    Flat patterns lie across the travel, as paths carry them.

    Args:
        form: Of the jet.
        height_mm: Orifice above the plate.

    Returns:
        (n,) places across the pass, mm, and the (n,) film there times the speed, um mm/s: divided by the speed it is
        the film. For f(r) = (R² - r²) / 8 um/s it is (R² - x²)^1.5 / 6 (Jiangsu 2010, eq. (2)).
    """
    wide, thin = _reach(form, height_mm)
    across = np.linspace(-wide, wide, _ACROSS)
    along = (np.arange(_ALONG) + 0.5) / _ALONG * 2.0 * thin - thin
    film = np.empty(_ACROSS)
    _integrate(form, height_mm, (across, along), film)
    return across, film * MICROMETRES * (2.0 * thin / _ALONG)


def _reach(form: JetForm, height_mm: float) -> tuple[float, float]:
    """How far from the axis spray lands, along tool x and tool y, mm."""
    box = box_of(form, _EDGE_SIGMAS)
    around = np.linspace(0.0, 1.0, 65)
    first = box.first[0] + around * (box.first[1] - box.first[0])
    corners = [directions_of(form, first, np.full(65, second)) for second in box.second]
    rays = np.concatenate(corners)
    slopes = np.abs(rays[:, :2]) / np.maximum(rays[:, 2:], 1e-9)
    wide, thin = np.minimum(slopes.max(axis=0), _WIDEST) * height_mm
    return float(wide) + form.half_slot_mm, float(thin)


@compiled
def _integrate(
    form: JetForm, height: float, places: tuple[NDArray[np.float64], NDArray[np.float64]], film: NDArray[np.float64]
) -> None:
    """Fill (n,) sums of the flux along the travel, m/s."""
    across, along = places
    for i in range(len(across)):
        total = 0.0
        for k in range(len(along)):
            total += flux_of(form, (across[i], along[k], height), (0.0, 0.0, -1.0))
        film[i] = total
