"""Curves of a cleaning report: how evenly a board is wet, when it is, and what limits its components."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cleaning.exposure.exposure import Exposure
from cleaning.process.stages import Stage
from cleaning.verdicts.exposed_area import percentile, shown_on_side
from cleaning.verdicts.results import CleaningReport, Part
from geometry.arrays import Scalars
from reports.pictures.cleaning_pictures import WIDTH_MM
from reports.pictures.sheet import ACCENT, FUNCTION_COLOURS, INK, QUIET, Picture, sheet, to_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HEIGHT_MM = 70.0
_BARS_MM = 5.0


def draw_volumes(report: CleaningReport) -> Picture | None:
    """Draw which share of the sprayed area gets at least a volume, and how that grows; nothing without a liquid."""
    wet = [index for index, stage in enumerate(report.stages) if stage.use != "dry"]
    if not wet:
        return None
    with sheet(_HEIGHT_MM, WIDTH_MM) as figure:
        left, right = figure.subplots(1, 2)
        figure.subplots_adjust(left=0.07, right=0.98, bottom=0.17, top=0.88, wspace=0.2)
        for number, index in enumerate(wet):
            stage, exposure = report.stages[index], report.exposures[index]
            shown = shown_on_side(report.facets, report.board, stage.side)
            areas = np.where(shown, report.facets.cell_areas_mm2, 0.0)
            colour = FUNCTION_COLOURS[number % len(FUNCTION_COLOURS)]
            limit = least_volume_mm(report, stage)
            _draw_shares(left, exposure.volume_mm, areas, colour, f"{stage.function}, least {limit:g} mm")
            left.axvline(limit, color=colour, linewidth=0.7, linestyle=(0, (4, 2)))
            times, shares = growth_of(exposure, areas, limit)
            right.plot(times, 100 * shares, color=colour, linewidth=1.2, label=stage.function)
        _finish(left, "volume on each area, mm", "Area that gets at least so much, %")
        _finish(right, "time in the program, s", "Area that has its least volume, %")
        left.legend(frameon=False, fontsize=7)
        return Picture(".svg", to_bytes(figure, ".svg"), "Share of the area by volume and over time")


def least_volume_mm(report: CleaningReport, stage: Stage) -> float:
    """Give the least volume that counts as enough in a stage."""
    limits = report.parameters.limits
    return limits.wash_volume_mm if stage.use == "wash" else limits.rinse_volume_mm


def growth_of(exposure: Exposure, areas: Scalars, limit_mm: float) -> tuple[Scalars, Scalars]:
    """Follow which share of an area has at least a volume at the end of each block of a stage.

    Args:
        exposure: Of the stage.
        areas: (c,) area of each cell that counts, mm2; 0 for those that do not.
        limit_mm: The volume.
    """
    growth, total = exposure.growth, max(float(areas.sum()), 1e-30)
    volume = np.zeros(len(areas))
    shares = np.zeros(len(growth.until_s))
    for block, (begin, end) in enumerate(zip(growth.start[:-1].tolist(), growth.start[1:].tolist(), strict=True)):
        np.add.at(volume, growth.cell[begin:end], growth.volume_mm[begin:end])
        shares[block] = float(areas[volume >= (1 - 1e-6) * limit_mm].sum()) / total
    return growth.until_s, shares


def _draw_shares(axes: Axes, volume: Scalars, areas: Scalars, colour: str, label: str) -> None:
    counted = areas > 0
    if not counted.any():
        return
    order = np.argsort(volume[counted], kind="stable")
    values, weights = volume[counted][order], areas[counted][order]
    beyond = 1 - np.cumsum(weights) / weights.sum()
    thin = np.unique(np.linspace(0, len(values) - 1, 400).astype(np.int64))
    fifth = percentile(values, weights, 0.05)
    axes.plot(values[thin], 100 * beyond[thin], color=colour, linewidth=1.2, label=f"{label}; p5 {fifth:.2g} mm")
    axes.plot(fifth, 95, marker="o", markersize=4, color=colour)


def _finish(axes: Axes, across: str, title: str) -> None:
    axes.set_xlabel(across)
    axes.set_title(title, loc="left", fontsize=8)
    axes.set_ylim(0, 102)
    axes.set_xlim(left=0 if across.startswith("volume") else None)
    axes.spines[["top", "right"]].set_visible(False)


def draw_limiting(parts: Sequence[Part]) -> Picture | None:
    """Draw how strongly each factor moves the residue of some components; nothing where none is known."""
    known = [part for part in parts if part.limiting and part.elasticity]
    if not known:
        return None
    factors = list(known[0].elasticity)
    height_mm = 18.0 + _BARS_MM * len(known)
    with sheet(height_mm, WIDTH_MM) as figure:
        panels = figure.subplots(1, len(factors), sharex=True, sharey=True, squeeze=False)[0]
        figure.subplots_adjust(left=0.1, right=0.99, bottom=10.5 / height_mm, top=1 - 6.5 / height_mm, wspace=0.1)
        for axes, factor in zip(panels, factors, strict=True):
            values = [abs(part.elasticity.get(factor, 0.0)) for part in known]
            colours = [ACCENT if part.limiting == factor else QUIET for part in known]
            axes.barh(range(len(known)), values, color=colours, height=0.65)
            axes.set_title("nozzle distance" if factor == "standoff" else factor, loc="left", fontsize=8)
            axes.tick_params(length=0)
            axes.spines[["top", "right", "left"]].set_visible(False)
        panels[0].set_xlim(left=0.0)
        panels[0].set_yticks(range(len(known)), [part.component for part in known], color=INK)
        panels[0].set_ylim(len(known) - 0.4, -0.6)
        panels[0].set_xlabel("% of residue for each % of the factor", loc="left")
        return Picture(".svg", to_bytes(figure, ".svg"), "How strongly each factor moves the residue")
