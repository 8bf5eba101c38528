"""Checking what rays estimate for chosen components against the exact sum over all samples."""

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from boards.board import Board
from cleaning.errors import CleaningError
from cleaning.exposure.exact import exact_exposure
from cleaning.jet.jet import jet_of
from cleaning.prepared_board import PreparedBoard
from cleaning.verdicts.exposed_area import exposed_part
from cleaning.verdicts.results import CleaningReport
from geometry.arrays import Indices
from specs.source import Source


@dataclass(frozen=True, slots=True)
class Verified:
    """Volume on one component and its time in the cone in one stage, by both ways; of the exposed surface."""

    component: str
    function: str
    made_by: Source
    """Of the stage."""
    rays_mm: float
    """Mean by area of what lands, as the report has it."""
    exact_mm: float
    worst_mm: float
    """Largest difference in one cell."""
    cells: int
    cone_s: float
    """Mean by area, as the report has it."""
    cone_error_s: float
    """95 % error that the report states for it."""
    exact_cone_s: float


def verify(report: CleaningReport, prepared: PreparedBoard, names: Sequence[str]) -> tuple[Verified, ...]:
    """Work out exactly what reaches some components, in every stage that sprays a liquid.

    Args:
        report: An analysis of the board.
        prepared: The board that was analysed.
        names: Components.

    Raises:
        CleaningError: the board has no such component.
    """
    check_names(report.board, names)
    facets, index = prepared.facets, {each.name: row for row, each in enumerate(report.board.components)}
    found: list[Verified] = []
    for name in dict.fromkeys(names):
        judged = prepared.cells[index[name]]
        cells: Indices = judged[facets.cell_exposed[judged]]
        share = facets.cell_areas_mm2[cells] / max(float(facets.cell_areas_mm2[cells].sum()), 1e-30)
        for stage, exposure in zip(report.stages, report.exposures, strict=True):
            if stage.use == "dry":
                continue
            jet = jet_of(stage, prepared.parameters.spray)
            exact = exact_exposure(stage, jet, facets, prepared.scene, cells)
            rays = exposure.volume_mm[cells]
            worst_mm = float(np.abs(rays - exact.volume_mm).max(initial=0.0))
            means = float(rays @ share), float(exact.volume_mm @ share)
            part = exposed_part(exposure, facets, cells)
            cone = part.cone_s[2], part.cone_error_s, float(exact.cone_s @ share)
            found.append(Verified(name, stage.function, stage.made_by, *means, worst_mm, len(cells), *cone))
    return tuple(found)


def check_names(board: Board, names: Sequence[str]) -> None:
    """Refuse names that no component bears.

    Raises:
        CleaningError: the board has no such component.
    """
    known = [component.name for component in board.components]
    for name in names:
        if name not in known:
            near = get_close_matches(name, known, 1, cutoff=0.5)
            meant = f" Did you mean {near[0]}?" if near else ""
            raise CleaningError(f"{board.name} has no component {name!r}.{meant}")
