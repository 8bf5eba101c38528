"""The coordinates in which a jet is laid out, and what flows where in them.

Cones and radial patterns: azimuth and cosine of the polar angle, whose area is the solid angle. Fans: the angles from
the axis along the wide and the thin side. Knives: ribbon u along the slot and the angle across it. Densities are per
unit of solid angle for all but knives, per unit of these coordinates for knives, as ``JetForm`` has them.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cleaning.jet.compiled_jet import (
    EDGE_SIGMAS,
    FAN,
    KNIFE,
    RADIAL,
    RING,
    ROUND,
    TAIL_SIGMAS,
    JetForm,
    strengths,
)
from geometry.arrays import Directions, Scalars

_STEEPEST = np.pi / 2 - 1e-6
_FINE = 128


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle of the jet's two coordinates."""

    first: tuple[float, float]
    second: tuple[float, float]

    @property
    def area(self) -> float:
        """Of the rectangle, in the jet's coordinates."""
        return (self.first[1] - self.first[0]) * (self.second[1] - self.second[0])

    def holds(self, first: Scalars, second: Scalars) -> NDArray[np.bool_]:
        """(n,) whether coordinates lie in the rectangle."""
        return (
            (self.first[0] <= first)
            & (first <= self.first[1])
            & (self.second[0] <= second)
            & (second <= self.second[1])
        )


def box_of(form: JetForm, sigmas: float) -> Box:
    """The least box that holds a jet and so many sigmas of its flanks."""
    if form.kind == RADIAL:
        return Box((0.0, 2 * np.pi), (float(np.cos(form.wide)), 1.0))
    if form.kind in ROUND:
        spread = sigmas * form.table[:, 1]
        low = np.clip(form.table[:, 0] - spread, 0, None).min() if form.kind == RING else 0.0
        high = min(float((form.table[:, 0] + spread).max()), _STEEPEST)
        if sigmas <= EDGE_SIGMAS:
            low = 0.0  # the outer cone is wet inside of its ring, too
        return Box((0.0, 2 * np.pi), (float(np.cos(high)), float(np.cos(low))))
    thin = min(sigmas * form.thin_sigma, _STEEPEST)
    if form.kind == FAN:
        wide = min(form.wide + sigmas * form.wide_sigma, _STEEPEST)
        return Box((-wide, wide), (-thin, thin))
    return Box((-1.0, 1.0), (-thin, thin))


def directions_of(form: JetForm, first: Scalars, second: Scalars) -> Directions:
    """(n, 3) unit vectors of (n,) coordinates, tool frame."""
    if form.kind in ROUND:
        sine = np.sqrt(np.clip(1 - second**2, 0, None))
        return np.column_stack([sine * np.cos(first), sine * np.sin(first), second])
    wide = first * np.tan(form.wide) if form.kind == KNIFE else np.tan(first)
    rays = np.column_stack([wide, np.tan(second), np.ones_like(wide)])
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


def solid_angle(form: JetForm, directions: Directions) -> Scalars:
    """(n,) area in the form's own density coordinates per area of the box: 1 for all but fans, solid angle there."""
    if form.kind != FAN:
        return np.ones(len(directions))
    # tan is what both angles share: d(omega) = cos³ d(tan wide) d(tan thin), cos the ray's with the axis.
    x, y, z = directions.T
    return z**3 * (1 + (x / z) ** 2) * (1 + (y / z) ** 2)


def flow_density(form: JetForm, directions: Directions) -> tuple[Scalars, NDArray[np.bool_]]:
    """(n,) share of the flow per unit of density coordinates, and whether the outer cone holds a direction."""
    found, within = np.empty(len(directions)), np.empty(len(directions), dtype=np.bool_)
    strengths(form, np.ascontiguousarray(directions), found, within)
    return found * form.scale, within


def steepest(form: JetForm) -> float:
    """Square of the tangent of the largest angle that a ray from the orifice makes with the axis, flanks included."""
    box = box_of(form, TAIL_SIGMAS)
    if form.kind == KNIFE:
        return np.inf
    return float(
        1 / directions_of(form, np.array([box.first[1]]), np.array([box.second[form.kind == FAN]]))[0, 2] ** 2 - 1
    )


def normalised(form: JetForm) -> JetForm:
    """Scale a form so that exactly its flow leaves it, by the midpoint rule on a fine grid."""
    if form.kind == RADIAL:
        return form._replace(scale=_radial_scale(form))
    key = (form.kind, form.table.tobytes(), form.wide, form.wide_sigma, form.thin_sigma)
    return form._replace(scale=_scale_of(*key))


def _radial_scale(form: JetForm) -> float:
    """Scale of a radial pattern: its flow is the integral of 2 pi r q over a plate, exact where q is linear."""
    slope = np.linspace(0.0, np.tan(form.wide), len(form.table))
    flux = form.table[:, 0]
    middle = 0.5 * (slope[1:] + slope[:-1]) * 0.5 * (flux[1:] + flux[:-1])
    simpson = (slope[1:] * flux[1:] + slope[:-1] * flux[:-1] + 4.0 * middle) / 6.0
    return float(1.0 / (2.0 * np.pi * (simpson * np.diff(slope)).sum()))


@lru_cache(maxsize=64)  # the shape does not depend on the pressure: coupons have one nozzle at hundreds of them
def _scale_of(kind: int, table: bytes, wide: float, wide_sigma: float, thin_sigma: float) -> float:
    """Give the scale of the forms of one shape, whatever flows out of them."""
    angles = np.frombuffer(table).reshape(-1, 2).copy()
    form = JetForm(kind, 1.0, 1.0, 1.0, 1.0, 1.0, angles, wide, wide_sigma, thin_sigma, 0.0, 0.0, np.inf, False)
    around = len(form.table) if form.kind in ROUND else _FINE
    box = box_of(form, TAIL_SIGMAS)
    first = middles(box.first, 2 if form.kind == KNIFE else around)
    second = middles(box.second, 4 * _FINE)
    if form.kind in ROUND:
        first = first - np.pi / around  # the table's own azimuths
    total = 0.0
    for some in np.array_split(first, max(1, len(first) // 64)):
        pairs = np.repeat(some, len(second)), np.tile(second, len(some))
        rays = directions_of(form, *pairs)
        total += float((flow_density(form, rays)[0] * solid_angle(form, rays)).sum())
    return len(first) * len(second) / (total * box.area)


def middles(limits: tuple[float, float], count: int) -> Scalars:
    """Middles of so many equal parts of a range."""
    half = (limits[1] - limits[0]) / count / 2
    return np.linspace(limits[0] + half, limits[1] - half, count, dtype=np.float64)
