"""What reaches the exposed surface of one component, or of the bare board, summed up: the least before the mean."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from cleaning.exposure import Exposure
from cleaning.facets import Facets
from cleaning.results import ExposedPart
from geometry.arrays import Indices, Scalars

_WALL = -0.2
_LIFT_MM = 1e-6
_LOW = 0.05
"""Percentile that stands for the places that get little."""


def facing(facets: Facets, board: Board, up: float) -> Indices:
    """Find the cells that face the side whose normal is (0, 0, ``up``).

    Walls belong to both sides, unless they stand beyond the other surface, as ends of pins do.
    """
    beyond = board.bottom_z_mm if up > 0 else -board.top_z_mm
    here = (up * facets.cell_normals[:, 2] > _WALL) & (up * facets.cell_centres[:, 2] > beyond - _LIFT_MM)
    return np.flatnonzero(here)


def cells_of(facets: Facets, board: Board, component: int, up: float) -> Indices:
    """Find the cells of a component, or with -1 of the bare board, that face a side."""
    cells = facing(facets, board, up)
    return cells[facets.cell_component[cells] == component]


def exposed_part(exposure: Exposure, facets: Facets, cells: Indices) -> ExposedPart:
    """Sum up one stage over some cells; hidden ones are counted and not judged."""
    shown = cells[facets.cell_exposed[cells]]
    areas = facets.cell_areas_mm2[shown]
    hidden = float(facets.cell_areas_mm2[cells].sum() - areas.sum())
    if not len(shown):
        return ExposedPart(0.0, hidden, 0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0)
    missed = float(areas[exposure.cone_s[shown] <= 0].sum() / areas.sum())
    return ExposedPart(
        area_mm2=float(areas.sum()),
        hidden_mm2=hidden,
        missed_share=missed,
        volume_mm=_spread(exposure.volume_mm[shown], areas),
        front_s=_spread(exposure.front_s[shown], areas),
        cone_s=_spread(exposure.cone_s[shown], areas),
        peak_pa=float(exposure.peak_pa[shown].max()),
    )


def together(exposures: Sequence[Exposure]) -> Exposure:
    """Add up several stages of one use; how the volume grew and who gave it is not kept apart."""
    first = exposures[0]
    if len(exposures) == 1:
        return first
    return replace(
        first,
        cone_s=np.sum([each.cone_s for each in exposures], axis=0),
        front_s=np.sum([each.front_s for each in exposures], axis=0),
        volume_mm=np.sum([each.volume_mm for each in exposures], axis=0),
        peak_pa=np.max([each.peak_pa for each in exposures], axis=0),
        impulse_n_pa_s=np.sum([each.impulse_n_pa_s for each in exposures], axis=0),
        impulse_t_pa_s=np.sum([each.impulse_t_pa_s for each in exposures], axis=0),
        hits=np.sum([each.hits for each in exposures], axis=0),
    )


def _spread(values: Scalars, areas: Scalars) -> tuple[float, float, float]:
    """Least, 5th percentile by area, mean by area."""
    return float(values.min()), percentile(values, areas, _LOW), float(np.average(values, weights=areas))


def percentile(values: Scalars, weights: NDArray[np.float64], share: float) -> float:
    """Give the least value that at least this share of the weights does not exceed."""
    order = np.argsort(values, kind="stable")
    reached = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(reached, share * reached[-1] * (1.0 - 1e-12))])
