"""Ray samples of a jet: the same at every run, and spread evenly however many are drawn.

Two rays of three follow the flow, one is spread evenly over the outer cone; each knows the density with which both
together visit its direction (balance heuristic, Veach and Guibas 1995), so that one set measures volumes, impulses and
times without bias. Directions come from Roberts' R2 sequence, a Kronecker sequence: any run of neighbours is spread
evenly, and so are neighbours of neighbours.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cleaning.jet.compiled_jet import EDGE_SIGMAS, KNIFE, TAIL_SIGMAS, JetForm
from cleaning.jet.jet import Jet
from cleaning.jet.jet_coordinates import Box, box_of, directions_of, flow_density, middles, solid_angle
from geometry.arrays import Directions, Scalars

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


def ray_samples_of(jet: Jet) -> RaySamples:
    """Draw the rays of a jet."""
    form = jet.form
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
        return (
            self._scaled(self._box.first, (row + beyond) / _ROWS),
            self._scaled(self._box.second, (column + part) / _COLUMNS),
        )

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
