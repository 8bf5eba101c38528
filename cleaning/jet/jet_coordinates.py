"""The coordinates in which a jet is laid out, what flows where in them, and ray samples of it.

Cones and radial patterns: azimuth and cosine of the polar angle, whose area is the solid angle. Fans: the angles from
the axis along the wide and the thin side. Knives: ribbon u along the slot and the angle across it. Densities are per
unit of solid angle for all but knives, per unit of these coordinates for knives, as ``JetForm`` has them.

Rays are the same at every run, and spread evenly however many are drawn. Two of three follow the flow, one is spread
evenly over the outer cone; each knows the density with which both together visit its direction (balance heuristic,
Veach and Guibas 1995), so that one set measures volumes, impulses and times without bias. Directions come from Roberts'
R2 sequence, a Kronecker sequence: any run of neighbours is spread evenly, and so are neighbours of neighbours.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cleaning.jet.compiled_jet import EDGE_SIGMAS, FAN, KNIFE, RADIAL, RING, ROUND, TAIL_SIGMAS, JetForm, strengths
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
        inside = (self.first[0] <= first) & (first <= self.first[1])
        return inside & (self.second[0] <= second) & (second <= self.second[1])


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
    widest = directions_of(form, np.array([box.first[1]]), np.array([box.second[form.kind == FAN]]))
    return float(1 / widest[0, 2] ** 2 - 1)


def normalised(form: JetForm) -> JetForm:
    """Scale a form so that exactly its flow leaves it, by the midpoint rule on a fine grid.

    The flow of a radial pattern is the integral of 2 pi r q over a plate, exact where q is linear.
    """
    if form.kind != RADIAL:
        return form._replace(
            scale=_scale_of(form.kind, form.table.tobytes(), form.wide, form.wide_sigma, form.thin_sigma)
        )
    slope, flux = np.linspace(0.0, np.tan(form.wide), len(form.table)), form.table[:, 0]
    middle = 0.5 * (slope[1:] + slope[:-1]) * 0.5 * (flux[1:] + flux[:-1])
    simpson = (slope[1:] * flux[1:] + slope[:-1] * flux[:-1] + 4.0 * middle) / 6.0
    return form._replace(scale=float(1.0 / (2.0 * np.pi * (simpson * np.diff(slope)).sum())))


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


RAYS = 3 << 14
_EVEN = 3
"""Every so many rays, one spreads evenly."""
_ROWS, _COLUMNS = 90, 256
_R2 = (0.7548776662466927, 0.5698402909980532)
"""1/g and 1/g², g the real root of g³ = g + 1."""
FRONT = 0.1
"""A place is in the wave front where it gets more than this share of the strongest direction's flow."""


@dataclass(frozen=True, slots=True, eq=False)
class RaySamples:
    """Rays in the tool frame, placed in order, again and again. n is ``RAYS``."""

    starts: Scalars
    """(n,) x at which a ray leaves the orifice or slot, mm."""
    directions: Directions
    """(n, 3)"""
    strength: Scalars
    """(n,) flow in this direction compared with the strongest."""
    inside: NDArray[np.bool_]
    """(n,) whether it is in the outer cone."""
    spread: Scalars
    """(n,) part of the jet's coordinates that the ray stands for if it is one of one: divide by how many are drawn."""

    @property
    def front(self) -> NDArray[np.bool_]:
        """(n,) whether it is in the wave front."""
        return self.strength > FRONT


def ray_samples_of(form: JetForm) -> RaySamples:
    """Draw the rays of a jet."""
    flow = _Flow(form)
    wide = box_of(form, EDGE_SIGMAS)
    even = np.arange(RAYS) % _EVEN == _EVEN - 1
    first, second = np.empty(RAYS), np.empty(RAYS)
    first[~even], second[~even] = flow.draw(*_sequence(RAYS - RAYS // _EVEN))
    u, v = _sequence(RAYS // _EVEN)
    first[even] = wide.first[0] + u * (wide.first[1] - wide.first[0])
    second[even] = wide.second[0] + v * (wide.second[1] - wide.second[0])
    density = (1 - 1 / _EVEN) * flow.density(first, second) + wide.holds(first, second) / (_EVEN * wide.area)
    directions = directions_of(form, first, second)
    strength, inside = flow_density(form, directions)
    starts: Scalars = first * form.half_slot_mm if form.kind == KNIFE else np.zeros(RAYS)
    return RaySamples(starts, directions, strength / form.scale, inside, solid_angle(form, directions) / density)


def _sequence(count: int) -> tuple[Scalars, Scalars]:
    """The first (count,) pairs of the R2 sequence."""
    numbers = np.arange(0.5, count, dtype=np.float64)
    return np.mod(numbers * _R2[0], 1.0), np.mod(numbers * _R2[1], 1.0)


class _Flow:
    """The flow over the jet's coordinates, constant in each cell of a grid: what can be drawn from, and its density."""

    def __init__(self, form: JetForm) -> None:
        self._box: Box = box_of(form, TAIL_SIGMAS)
        first = middles(self._box.first, _ROWS)
        second = middles(self._box.second, _COLUMNS)
        rays = directions_of(form, np.repeat(first, _COLUMNS), np.tile(second, _ROWS))
        flow = (flow_density(form, rays)[0] * solid_angle(form, rays)).reshape(_ROWS, _COLUMNS)
        rows = flow.sum(axis=1)
        self._share = flow / rows.sum()
        self._rows = np.concatenate([[0.0], np.cumsum(rows / rows.sum())])
        # Row after row in one ascending table: row k runs from k to k + 1.
        within = np.cumsum(flow / np.where(rows > 0, rows, 1.0)[:, None], axis=1)
        within /= np.where(rows > 0, within[:, -1], 1.0)[:, None]
        self._within = within

    def draw(self, u: Scalars, v: Scalars) -> tuple[Scalars, Scalars]:
        """Coordinates of (n,) pairs of numbers from 0 to 1."""
        row = np.clip(np.searchsorted(self._rows, u, side="right") - 1, 0, _ROWS - 1)
        beyond = (u - self._rows[row]) / (self._rows[row + 1] - self._rows[row])
        table = (self._within + np.arange(_ROWS)[:, None]).ravel()
        place = np.clip(np.searchsorted(table, row + v, side="right"), row * _COLUMNS, (row + 1) * _COLUMNS - 1)
        column = place - row * _COLUMNS
        above = self._within[row, column]
        below = np.where(column > 0, self._within[row, column - 1], 0.0)
        part = np.clip((v - below) / np.where(above > below, above - below, 1.0), 0.0, 1.0)
        first, second = (row + beyond) / _ROWS, (column + part) / _COLUMNS
        return self._scaled(self._box.first, first), self._scaled(self._box.second, second)

    def density(self, first: Scalars, second: Scalars) -> Scalars:
        """How densely ``draw`` visits (n,) coordinates."""
        row = np.floor(self._share_of(self._box.first, first) * _ROWS).astype(np.int64)
        column = np.floor(self._share_of(self._box.second, second) * _COLUMNS).astype(np.int64)
        inside = (row >= 0) & (row < _ROWS) & (column >= 0) & (column < _COLUMNS)
        found = self._share[np.clip(row, 0, _ROWS - 1), np.clip(column, 0, _COLUMNS - 1)]
        return np.where(inside, found, 0.0) * (_ROWS * _COLUMNS / self._box.area)

    @staticmethod
    def _scaled(limits: tuple[float, float], share: Scalars) -> Scalars:
        return limits[0] + share * (limits[1] - limits[0])

    @staticmethod
    def _share_of(limits: tuple[float, float], values: Scalars) -> Scalars:
        return (values - limits[0]) / (limits[1] - limits[0])
