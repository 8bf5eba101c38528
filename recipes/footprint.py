"""Where a nozzle's spray meets a flat surface.

Only the geometry of the pattern: rays from the orifice that bound it, met with a plane. How much liquid arrives is
the cleaning model's business.
"""

from collections.abc import Hashable
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from geometry.arrays import Points, Points2, Scalars
from recipes.nozzles import AirKnife, FlatFan, FullCone, HollowCone, Nozzle, Radial, Wavefront

_RAYS = 96
_GRAZING = 1e-3  # a ray this flat (z of its direction) is taken to meet the plane there and no farther
RING_EDGE_SIGMAS = 2.0
_PLACES = 257
"""Of a radial pattern, from its axis to its edge."""
_STEEPEST = 1.5
"""rad"""


def mid_angles(nozzle: Nozzle, azimuth: Scalars) -> Scalars:
    """Polar angle of the middle of the wave front, rad, at azimuths from the nozzle's reference, rad.

    Args:
        nozzle: Any nozzle; for a full cone or radial pattern it is the edge of the spray, for a fan or
            knife the edge of the thin side.
        azimuth: (n,) from tool +X towards tool +Y.
    """
    match nozzle:
        case HollowCone():
            if nozzle.wavefront is None:
                return np.full(len(azimuth), np.radians(nozzle.half_angle_deg))
            both = np.stack([measured_angles(nozzle.wavefront, azimuth, column) for column in (1, 2)])
            return np.asarray(both.mean(axis=0), dtype=np.float64)
        case FullCone() | Radial():
            return np.full(len(azimuth), np.radians(nozzle.half_angle_deg))
        case FlatFan() | AirKnife():
            return np.full(len(azimuth), np.radians(nozzle.thickness_half_angle_deg))


def mean_angle(nozzle: Nozzle) -> float:
    """Mean over the azimuth of the middle of the wave front, rad."""
    return float(np.mean(mid_angles(nozzle, _azimuths())))


def footprint(nozzle: Nozzle, height_mm: float, approach: Points, reference: Points) -> Points2:
    """Outline of the spray on a plane below the orifice.

    Args:
        nozzle: Whose pattern; a hollow cone without a measured ring ends two sigmas outside its half angle.
        height_mm: Orifice above the plane.
        approach: (3,) jet direction, side frame (z up out of the surface).
        reference: (3,) tool +X, at right angles to it.

    Returns:
        (k, 2) points around the outline, relative to the foot of the perpendicular from the orifice. Rays that
        never meet the plane are cut off far away.
    """
    if isinstance(nozzle, HollowCone) and nozzle.wavefront is not None:
        angles = measured_angles(nozzle.wavefront, _azimuths(), 2)
    elif isinstance(nozzle, HollowCone):
        edge = nozzle.half_angle_deg + RING_EDGE_SIGMAS * nozzle.ring_sigma_deg
        angles = np.full(_RAYS, np.radians(min(edge, 85.0)))
    else:
        angles = mid_angles(nozzle, _azimuths())
    return _meet(nozzle, height_mm, approach, reference, angles)


def core_footprint(nozzle: Nozzle, height_mm: float, approach: Points, reference: Points) -> Points2:
    """Like ``footprint`` but out to the middle of the wave front only: what surely is inside the spray."""
    return _meet(nozzle, height_mm, approach, reference, mid_angles(nozzle, _azimuths()))


def plate_profile(nozzle: Radial, count: int) -> tuple[Scalars, Scalars]:
    """Flux of a radial pattern on a plate at right angles to the axis, relative to its greatest.

    Args:
        nozzle: Whose profile.
        count: How many places, at least 2.

    Returns:
        (count,) tangents of the angle from the axis, evenly spaced from 0 to the edge, and the (count,) flux there.
    """
    radius = np.linspace(0.0, nozzle.radius_mm, count, dtype=np.float64)
    if nozzle.profile == "parabola":
        flux = 1.0 - (radius / nozzle.radius_mm) ** 2
    else:
        known = np.array(nozzle.profile, dtype=np.float64)
        flux = np.interp(radius, known[:, 0], known[:, 1])
    return radius / nozzle.at_mm, np.asarray(flux / flux.max(), dtype=np.float64)


def _azimuths() -> Scalars:
    return np.linspace(0.0, 2 * np.pi, _RAYS, endpoint=False, dtype=np.float64)


def measured_angles(wavefront: Wavefront, azimuth: Scalars, column: int) -> Scalars:
    """Polar angle of the inner (1) or outer (2) edge of a measured wave front, rad, at azimuths (n,), rad."""
    table = np.array(wavefront.points)
    radius = np.interp(np.degrees(azimuth) % 360, table[:, 0], table[:, column], period=360)
    return np.asarray(np.arctan2(radius, wavefront.height_mm), dtype=np.float64)


def _tool_rays(nozzle: Nozzle, angles: Scalars) -> tuple[Points, Points]:
    """Origins and directions of the bounding rays in the tool frame, mm."""
    around = _azimuths()
    match nozzle:
        case HollowCone() | FullCone() | Radial():
            slope = np.tan(angles)[:, None] * np.column_stack([np.cos(around), np.sin(around)])
            origins = np.zeros((_RAYS, 3))
        case FlatFan() | AirKnife():
            circle = np.column_stack(
                [np.cos(around), np.sin(around)]
            )  # onto the square [-1, 1] x [-1, 1] with its corners
            square = np.round(circle / np.abs(circle).max(axis=1, keepdims=True), 12)
            wide, thin = np.radians([nozzle.half_angle_deg, nozzle.thickness_half_angle_deg])
            slope = square * np.tan([wide, thin])
            origins = np.zeros((_RAYS, 3))
            if isinstance(nozzle, AirKnife):
                origins[:, 0] = square[:, 0] * nozzle.width_mm / 2
    return origins, np.column_stack([slope, np.ones(_RAYS)])


def _meet(nozzle: Nozzle, height_mm: float, approach: Points, reference: Points, angles: Scalars) -> Points2:
    origins, directions = _tool_rays(nozzle, angles)
    axes = np.stack([reference, np.cross(approach, reference), approach])
    origins, directions = origins @ axes, directions @ axes
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    fall = np.maximum(-directions[:, 2], _GRAZING)
    reach = (height_mm + origins[:, 2]) / fall
    return (origins + directions * reach[:, None])[:, :2]


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
