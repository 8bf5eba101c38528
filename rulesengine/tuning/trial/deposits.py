"""Deposits of each template of each step on the surface, cell by cell: amounts add up, whatever the order."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Side
from cleaning.exposure.exposure import Exposure
from cleaning.process.stages import Stage
from cleaning.verdicts.exposed_area import BARE, cells_of, cells_of_each
from cleaning.verdicts.results import CleaningReport
from geometry.arrays import Indices, Scalars
from rulesengine.tuning.trial.requirements import BOARD

_LEAST = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Deposit:
    """Liquid that one template leaves in one step, all its repeats together."""

    step: str
    """Such as ``"sequence[0]"``."""
    template: str
    seconds: float
    """Spraying."""
    volume_mm: NDArray[np.float32]
    """(c,) on each cell of the surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Deposits:
    """All deposits of a program, and the cells of each component."""

    each: tuple[Deposit, ...]
    areas_mm2: Scalars
    """(c,)"""
    cells: Mapping[tuple[str, Side], Indices]
    """The exposed cells of each component on its own side, and of the bare board on both."""


def deposits_of(report: CleaningReport) -> Deposits:
    """Deposits of an analysis by step and template."""
    facets, board = report.facets, report.board
    cells: dict[tuple[str, Side], Indices] = {
        (component.name, component.side): own
        for component, own in zip(board.components, cells_of_each(facets, board), strict=True)
    }
    for stage in report.stages:
        if (BOARD, stage.side) not in cells:
            cells[BOARD, stage.side] = cells_of(facets, board, BARE, stage.side)
    shown = {key: own[facets.cell_exposed[own]] for key, own in cells.items()}
    found = (
        deposit
        for stage, exposure in zip(report.stages, report.exposures, strict=True)
        for deposit in _of_stage(stage, exposure)
    )
    return Deposits(tuple(found), facets.cell_areas_mm2, shown)


def spray_durations(stage: Stage) -> Iterator[tuple[tuple[str, str], float]]:
    """Seconds for which each template sprays in a stage, by step and template."""
    of_sample = stage.samples.templates
    for template in dict.fromkeys(of_sample.tolist()):
        yield (str(stage.made_by), template), float(stage.samples.seconds[of_sample == template].sum())


def _of_stage(stage: Stage, exposure: Exposure) -> Iterator[Deposit]:
    samples, growth, of_sample = stage.samples, exposure.growth, stage.samples.templates
    last = np.searchsorted(samples.times, growth.until_s) - 1
    of_entry = np.repeat(of_sample[last], np.diff(growth.start))
    count = len(exposure.volume_mm)
    grown = np.bincount(growth.cell, growth.volume_mm, minlength=count)
    for (step, template), seconds in spray_durations(stage):
        mine = of_entry == template
        own = np.bincount(growth.cell[mine], growth.volume_mm[mine], minlength=count)
        # Cells that few rays hit have been refined since they grew: the shares are kept all the same.
        share = np.divide(own, grown, out=np.full(count, own.sum() / max(grown.sum(), _LEAST)), where=grown > 0)
        yield Deposit(step, template, seconds, (share * exposure.volume_mm).astype(np.float32))
