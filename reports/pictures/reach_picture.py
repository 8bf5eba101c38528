"""What lands on one component and around it, as multiples of what is needed: the map that R1 and R2 judge by."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from boards.board import Side
from cleaning.verdicts.exposed_area import shown_on_side
from cleaning.verdicts.results import CleaningReport, Part
from geometry.arrays import Scalars
from recipes.recipe import Use
from reports.pictures.cleaning_pictures import WIDTH_MM, CellPixels, least_volume_mm, see_cells
from reports.pictures.sheet import (
    ACCENT,
    BOARD,
    INK,
    Picture,
    View,
    components_of,
    draw_outlines,
    draw_scale_bar,
    frame_board,
    sheet,
    to_bytes,
    write_names,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_USES: dict[Use, str] = {"wash": "washing", "rinse": "rinsing"}
_LEAST, _MOST = 0.1, 100.0
"""Ends of the scale, times what is needed."""
_ROOM = 0.6
"""Around the component, of its longer side."""
_LEAST_ROOM_MM = 2.0
_TITLE_MM = 11.0
_PANEL_MM = 80.0
_TOO_LITTLE, _NEARLY, _ENOUGH, _MUCH = "#d98e2b", "#f7e9c6", "#d5e4ef", "#1d4e85"


def draw_reach(report: CleaningReport, part: Part) -> Picture | None:
    """Draw what washing and what rinsing bring to a component and its neighbours; nothing where no liquid is sprayed.

    All stages of one use on its side count together, as often as loops may do them, and are compared with the least
    volume that a clean part gets.
    """
    component = next(each for each in report.board.components if each.name == part.component)
    uses: list[Use] = [
        use for use in _USES if any(each.use == use and each.side == component.side for each in report.stages)
    ]
    if not uses:
        return None
    view = _around(component.outline.bounds)
    pixels = see_cells(report.facets, component.side, view, 500)
    height_mm = min(_PANEL_MM * view.aspect, 100.0)
    with sheet(height_mm + _TITLE_MM, WIDTH_MM) as figure:
        for column, use in enumerate(uses):
            left = column * 0.5
            top = height_mm / (height_mm + _TITLE_MM)
            axes = figure.add_axes((left, 0.05, 0.43, top - 0.05))
            _draw_panel(axes, report, component.side, pixels, use)
        alt = f"What reaches {component.name} and around it, times what is needed"
        return Picture(".svg", to_bytes(figure, ".svg"), alt)


def times_needed(report: CleaningReport, side: Side, use: Use) -> Scalars:
    """(c,) volume that all stages of a use bring to each cell of a side, times what a clean part gets; 0: never hit."""
    total = np.zeros(len(report.facets.cell_areas_mm2))
    hit = np.zeros(len(total), dtype=np.bool_)
    least = np.inf
    for stage, exposure in zip(report.stages, report.exposures, strict=True):
        if (stage.use, stage.side) == (use, side):
            total += stage.repeats * exposure.supply_mm
            hit |= exposure.volume_mm > 0.0
            least = report.parameters.limits.margin * least_volume_mm(report, stage)
    return np.where(hit, total / least, 0.0)


def _around(bounds: tuple[float, float, float, float]) -> View:
    x0, y0, x1, y1 = bounds
    room = max(_ROOM * max(x1 - x0, y1 - y0), _LEAST_ROOM_MM)
    return View((x0 - room, y0 - room), (x1 + room, y1 + room))


def _draw_panel(axes: Axes, report: CleaningReport, side: Side, pixels: CellPixels, use: Use) -> None:
    from matplotlib.colors import LinearSegmentedColormap, LogNorm

    middle = np.log(1.0 / _LEAST) / np.log(_MOST / _LEAST)
    colours = [(0.0, _TOO_LITTLE), (middle, _NEARLY), (middle, _ENOUGH), (1.0, _MUCH)]
    scale = LinearSegmentedColormap.from_list("needed", colours).with_extremes(under=_TOO_LITTLE, bad=(0, 0, 0, 0))
    frame_board(axes, pixels.view)
    components = components_of(report.board, side)
    draw_outlines(axes, report.board, side, ["none"] * len(components))
    axes.set_facecolor(BOARD)
    shown = shown_on_side(report.facets, report.board, side)
    image = pixels.filled(np.where(shown, times_needed(report, side, use), np.nan))
    (x0, y0), (x1, y1) = pixels.view.low, pixels.view.high
    never = np.zeros((*image.shape, 4))
    never[image == 0.0] = _rgba(ACCENT)
    drawn = axes.imshow(
        np.ma.masked_invalid(np.where(image > 0.0, image, np.nan)), cmap=scale, norm=LogNorm(_LEAST, _MOST),
        extent=(x0, x1, y0, y1), interpolation="nearest", zorder=1.5,
    )  # fmt: skip
    axes.imshow(never, extent=(x0, x1, y0, y1), interpolation="nearest", zorder=1.6)
    bar = axes.figure.colorbar(drawn, ax=axes, fraction=0.046, pad=0.03)
    bar.set_ticks([0.1, 0.3, 1, 3, 10, 30, 100], labels=["0.1", "0.3", "1", "3", "10", "30", "100"])
    bar.minorticks_off()
    bar.outline.set_visible(False)
    write_names(axes, components, [INK] * len(components))
    draw_scale_bar(axes)
    axes.set_title(f"{_USES[use]}: times what is needed", loc="left", fontsize=8)


def _rgba(colour: str) -> tuple[float, float, float, float]:
    from matplotlib.colors import to_rgba

    return to_rgba(colour)
