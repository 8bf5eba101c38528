"""Directions that stand for the flow of a jet: each nozzle's pattern as rays with shares of its flow."""

from collections.abc import Hashable
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from geometry.arrays import Scalars
from recipes.footprint import RING_EDGE_SIGMAS, measured_angles, mid_angles, plate_profile
from recipes.nozzles import AirKnife, FlatFan, FullCone, HollowCone, Nozzle, Radial

_PLACES = 257
"""Of a radial pattern, from its axis to its edge."""
_STEEPEST = 1.5
"""rad"""


@dataclass(frozen=True, slots=True, eq=False)
class SprayRays:
    """Directions of a jet in the tool frame, z along the jet, and the share of the flow in each."""

    slopes: NDArray[np.float64]
    """(n, 2) x/z and y/z"""
    weights: Scalars
    """(n,) they add up to 1."""


def spray_rays(nozzle: Nozzle, count: int) -> SprayRays:
    """Spread the flow of a jet over rays: rings and radial patterns by their profile, cones and fans evenly.

    Rays come from Roberts' R2 sequence, so that any stretch of them is spread evenly too.

    Args:
        nozzle: Whose pattern; the slot of an air knife counts as a point.
        count: How many rays.

    Returns:
        Kept for the next caller: its arrays are read-only.
    """
    return _rays(cast(Hashable, nozzle), count)


@lru_cache(maxsize=16)
def _rays(nozzle: Nozzle, count: int) -> SprayRays:
    rays = _spread(nozzle, count)
    for array in (rays.slopes, rays.weights):
        array.flags.writeable = False
    return rays


def _spread(nozzle: Nozzle, count: int) -> SprayRays:
    numbers = np.arange(0.5, count)
    first, second = (np.mod(numbers * share, 1.0) for share in (0.7548776662466927, 0.5698402909980532))
    around = 2.0 * np.pi * first
    match nozzle:
        case HollowCone():
            middle = mid_angles(nozzle, around)
            sigmas: Scalars | float = float(np.radians(nozzle.ring_sigma_deg))
            if nozzle.wavefront is not None:
                sigmas = (measured_angles(nozzle.wavefront, around, 2) - middle) / RING_EDGE_SIGMAS
            polar = np.maximum(middle + sigmas * ndtri(second), 0.0)
            weights = np.sin(polar)
        case FullCone():
            polar = np.arccos(1.0 - second * (1.0 - np.cos(mid_angles(nozzle, around))))
            weights = np.ones_like(polar)
        case Radial():
            slope, flux = plate_profile(nozzle, _PLACES)
            inner = np.cumsum(0.5 * (slope[1:] * flux[1:] + slope[:-1] * flux[:-1]))
            polar = np.arctan(np.interp(second * inner[-1], np.append(0.0, inner), slope))
            weights = np.ones_like(polar)
        case FlatFan() | AirKnife():
            wide, thin = np.tan(np.radians([nozzle.half_angle_deg, nozzle.thickness_half_angle_deg]))
            slopes = np.column_stack([wide * (2.0 * first - 1.0), thin * (2.0 * second - 1.0)])
            return SprayRays(slopes, np.full(count, 1.0 / count))
    slopes = np.tan(np.minimum(polar, _STEEPEST))[:, None] * np.column_stack([np.cos(around), np.sin(around)])
    return SprayRays(slopes, weights / weights.sum())
