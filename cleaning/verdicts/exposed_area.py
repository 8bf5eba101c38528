"""Which surface a side has, and what reaches it, summed up for a component or the bare board: the least first."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from boards.board import Board, Side
from cleaning.exposure.exposure import Exposure
from cleaning.surface.facets import Facets
from cleaning.verdicts.results import ExposedPart
from geometry.arrays import Indices, Scalars

_SIDES: tuple[Side, ...] = ("top", "bottom")
_WALL = -0.2
_LIFT_MM = 1e-6
LOW = 0.05
"""Percentile that stands for the places that get little."""
FEW = 3
"""Cells that are so few that one of them decides nothing."""
_TWO_SIDED = 2.0
"""Standard errors of a 95 % interval."""
_OF_RAYS = 2.5
"""Likewise of rays: a few of them count for much, so that the standard error is often too small."""
BARE = -1
"""Index of a component that stands for the bare board."""


def cells_of_side(facets: Facets, board: Board, side: Side) -> Indices:
    """Find the cells of a side: of its components and of the bare board, those that face it.

    Walls belong to it, unless they stand beyond the other surface, as ends of pins do; so those of the bare board
    belong to both sides. Fixtures belong to none. Hidden cells are among them.
    """
    of_side = np.array([component.side == side for component in board.components] + [True])  # the bare board is last
    cells = np.flatnonzero(of_side[facets.cell_component])
    return _facing(facets, board, side, cells)


def shown_on_side(facets: Facets, board: Board, side: Side) -> NDArray[np.bool_]:
    """(c,) which cells of a side are exposed: what can be sprayed there."""
    shown = np.zeros(len(facets.cell_exposed), dtype=np.bool_)
    cells = cells_of_side(facets, board, side)
    shown[cells] = facets.cell_exposed[cells]
    return shown


def cells_of(facets: Facets, board: Board, component: int, side: Side) -> Indices:
    """Find those cells of a side that belong to one of its components, or to the bare board, which is ``BARE``."""
    return _facing(facets, board, side, np.flatnonzero(facets.cell_component == component))


def cells_beyond(cells: Indices, facets: Facets, board: Board, side: Side, margins_mm: Mapping[str, float]) -> Indices:
    """Keep those of the bare board's cells that are beyond the margins of the components on that side."""
    grown = [
        component.outline.buffer(margins_mm[component.name])
        for component in board.components
        if component.name in margins_mm and component.side == side
    ]
    centres = facets.cell_centres[cells]
    return cells[~shapely.contains_xy(shapely.union_all(grown), centres[:, 0], centres[:, 1])] if grown else cells


def cells_of_each(facets: Facets, board: Board) -> tuple[Indices, ...]:
    """Find the cells of every component on its own side, as ``cells_of`` does, in one go."""
    order = np.argsort(facets.cell_component, kind="stable")
    ends = np.searchsorted(facets.cell_component[order], np.arange(len(board.components) + 1))
    faces = {side: np.zeros(len(order), dtype=np.bool_) for side in _SIDES}
    for side in _SIDES:
        faces[side][_facing(facets, board, side, np.arange(len(order)))] = True
    groups = (order[begin:end] for begin, end in pairwise(ends.tolist()))
    return tuple(cells[faces[component.side][cells]] for component, cells in zip(board.components, groups, strict=True))


def _facing(facets: Facets, board: Board, side: Side, cells: Indices) -> Indices:
    up = 1.0 if side == "top" else -1.0
    beyond = board.bottom_z_mm if side == "top" else -board.top_z_mm
    faces = (up * facets.cell_normals[cells, 2] > _WALL) & (up * facets.cell_centres[cells, 2] > beyond - _LIFT_MM)
    fixture = np.array([body.role == "fixture" for body in board.bodies])
    if fixture.any() and (facets.cell_component[cells] == BARE).any():
        body = np.zeros(len(facets.cell_areas_mm2), dtype=np.int64)
        body[facets.cell] = facets.body
        faces &= ~fixture[body[cells]]
    return cells[faces]


def exposed_part(exposure: Exposure, facets: Facets, cells: Indices) -> ExposedPart:
    """Sum up one stage over some cells; hidden ones are counted and not judged."""
    shown = cells[facets.cell_exposed[cells]]
    areas = facets.cell_areas_mm2[shown]
    hidden = float(facets.cell_areas_mm2[cells].sum() - areas.sum())
    if not len(shown):
        none = (0.0, 0.0, 0.0)
        return ExposedPart(0.0, hidden, 0.0, none, none, none, none, 0.0, 0.0)
    apart = np.linalg.norm(exposure.cone_error_s[shown] * areas) / areas.sum()
    shared = np.average(exposure.cone_shared_error_s[shown], weights=areas)
    missed = float(areas[exposure.cone_s[shown] <= 0].sum() / areas.sum())
    return ExposedPart(
        area_mm2=float(areas.sum()),
        hidden_mm2=hidden,
        missed_share=missed,
        volume_mm=_spread(exposure.volume_mm[shown], areas),
        supply_mm=_spread(exposure.supply_on(shown), areas),
        front_s=_spread(exposure.front_s[shown], areas),
        cone_s=_spread(exposure.cone_s[shown], areas),
        cone_error_s=float(np.hypot(_OF_RAYS * apart, _TWO_SIDED * shared)),
        peak_pa=float(exposure.peak_pa[shown].max()),
    )


def together(exposures: Sequence[Exposure]) -> Exposure:
    """Add up several stages of one use; how the volume grew and who gave it is not kept apart."""
    first = exposures[0]
    if len(exposures) == 1:
        return first
    added = ("cone_s", "front_s", "volume_mm", "run_off_mm", "impulse_n_pa_s", "impulse_t_pa_s", "hits")
    changes = {name: np.sum([getattr(each, name) for each in exposures], axis=0) for name in added}
    for name in ("cone_error_s", "cone_shared_error_s"):
        changes[name] = np.linalg.norm([getattr(each, name) for each in exposures], axis=0)
    return replace(first, peak_pa=np.max([each.peak_pa for each in exposures], axis=0), **changes)


def _spread(values: Scalars, areas: Scalars) -> tuple[float, float, float]:
    """Least, low, mean by area."""
    return float(values.min()), low_value(values, areas), float(values @ areas / areas.sum())


def low_value(values: Scalars, areas: Scalars) -> float:
    """Give the value that stands for the places that get least: the 5th percentile by area.

    One cell alone stands for no place, and on small parts it is the least wetted twentieth: there it is the mean of the
    ``FEW`` cells that get least, if that is more.
    """
    order = np.argsort(values, kind="stable")
    least = order[:FEW]
    return max(_reached(values, areas, order, LOW), float(values[least] @ areas[least] / areas[least].sum()))


def percentile(values: Scalars, weights: NDArray[np.float64], share: float) -> float:
    """Give the least value that at least this share of the weights does not exceed."""
    return _reached(values, weights, np.argsort(values, kind="stable"), share)


def _reached(values: Scalars, weights: NDArray[np.float64], order: Indices, share: float) -> float:
    """Give that value of (n,) values in ascending order."""
    reached = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(reached, share * reached[-1] * (1.0 - 1e-12))]])
