"""Which side of a board a stage sprays, and which cells belong to that side."""

import numpy as np
from numpy.typing import NDArray

from boards.board import Side
from cleaning.results import CleaningReport
from cleaning.stages import Stage
from rulesengine.drawing import SIDES


def sides_of(stage: Stage) -> tuple[Side, ...]:
    """Give the sides at which the jet of a stage points, the top first."""
    along = stage.samples.axes[:, 2, 2]
    pointed = {"top": bool((along < 0).any()), "bottom": bool((along > 0).any())}
    return tuple(side for side in SIDES if pointed[side])


def cells_of(report: CleaningReport, side: Side) -> NDArray[np.bool_]:
    """(c,) the exposed cells of a side: those of its components, and of the bare board what faces that way."""
    facets = report.facets
    named = np.array([component.side == side for component in report.board.components] + [False])
    upward = facets.cell_normals[:, 2] > 0 if side == "top" else facets.cell_normals[:, 2] < 0
    return facets.cell_exposed & np.where(facets.cell_component >= 0, named[facets.cell_component], upward)


def cells_sprayed(report: CleaningReport, stage: Stage) -> NDArray[np.bool_]:
    """(c,) the exposed cells of all sides that a stage sprays."""
    found = np.zeros(len(report.facets.cell_areas_mm2), dtype=np.bool_)
    for side in sides_of(stage):
        found |= cells_of(report, side)
    return found
