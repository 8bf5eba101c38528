"""Pictures of a cleaning report: verdicts on the board, and what reaches its surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from boards.board import Side
from cleaning.exposure.exposure import Exposure
from cleaning.process.stages import Stage
from cleaning.surface.facets import Facets
from cleaning.verdicts.cleanliness import Outcome, outcome
from cleaning.verdicts.exposed_area import shown_on_side
from cleaning.verdicts.results import CleaningReport
from geometry.arrays import Indices, Scalars
from reports.pictures.sheet import (
    ACCENT,
    BOARD,
    INK,
    SIDES,
    Picture,
    View,
    components_of,
    draw_outlines,
    draw_scale_bar,
    frame_board,
    sheet,
    to_bytes,
    view_of,
    write_names,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

VERDICT_COLOURS: dict[Outcome, str] = {
    "dirty": ACCENT,
    "marginal": "#e3b04b",
    "clean, wet": "#1d4e85",
    "no verdict": "#aab2b8",
    "clean": "#a9cbe3",
}
"""Distinct for those who see no red or green, and in grey on paper: what is clean is blue, and deep where wet."""
_DARK: tuple[Outcome, ...] = ("dirty", "clean, wet")
"""Names on these are white."""
WIDTH_MM = 180.0
"""Of all pictures on the page: A4 within its margins."""
_TITLE_MM = 9.0
_LARGEST_PANEL_MM = 150.0
_FLAT = 0.2
"""Facets whose normal rises less than this are walls: from above one would see a line."""


@dataclass(frozen=True, slots=True, eq=False)
class CellPixels:
    """A view of one side from the top, pixel by pixel. Row 0 is at the back (highest y)."""

    view: View
    cell: Indices
    """(rows, columns) index of the cell, -1 where there is none."""

    def filled(self, values: Scalars) -> NDArray[np.float64]:
        """(rows, columns) value of each pixel's cell; NaN where there is none."""
        return np.where(self.cell >= 0, np.append(values, np.nan)[self.cell], np.nan)


def see_cells(facets: Facets, side: Side, view: View, most_pixels: int = 900) -> CellPixels:
    """Draw the exposed facets that face a side, the outermost last, each in a colour that is its cell's number.

    Args:
        facets: The surface.
        side: The side to look at; x and y stay as seen from the top.
        view: The part of the plane.
        most_pixels: Along the longer side of the picture.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    outward = 1.0 if side == "top" else -1.0
    seen = np.flatnonzero(facets.exposed & (outward * facets.normals[:, 2] > _FLAT))
    seen = seen[np.argsort(outward * facets.triangles[seen, :, 2].mean(axis=1), kind="stable")]
    size = np.array(view.high) - np.array(view.low)
    columns, rows = np.maximum(np.round(size / size.max() * most_pixels).astype(int), 1).tolist()
    figure = Figure(figsize=(columns / 100, rows / 100), dpi=100, facecolor="black")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(view.low[0], view.high[0])
    axes.set_ylim(view.low[1], view.high[1])
    number = facets.cell[seen] + 1  # a colour for each cell; black is left for where there is none
    colours = np.column_stack([number >> 16 & 255, number >> 8 & 255, number & 255]) / 255.0
    corners = cast("Sequence[Any]", facets.triangles[seen, :, :2])
    triangles = PolyCollection(corners, facecolors=colours, edgecolors=colours, linewidths=0.4, antialiaseds=False)
    axes.add_collection(triangles, autolim=False)
    canvas.draw()
    red, green, blue = np.moveaxis(np.asarray(canvas.buffer_rgba())[:, :, :3].astype(np.int64), 2, 0)
    return CellPixels(view, (red << 16 | green << 8 | blue) - 1)


def draw_verdicts(report: CleaningReport) -> list[Picture]:
    """Draw each side that has components, each component in the colour of what results for it."""
    sides: list[Side] = [side for side in SIDES if components_of(report.board, side)] or ["top"]
    return [_draw_side(report, side) for side in sides]


def _draw_side(report: CleaningReport, side: Side) -> Picture:
    view = view_of(report.board)
    height_mm = min(_LARGEST_PANEL_MM, WIDTH_MM * view.aspect)
    components = components_of(report.board, side)
    outcomes: list[Outcome] = [
        outcome(part) for part, each in zip(report.parts, report.board.components, strict=True) if each.side == side
    ]
    with sheet(height_mm + _TITLE_MM, WIDTH_MM) as figure:
        axes = figure.add_axes((0.0, 0.03, 1.0, height_mm / (height_mm + _TITLE_MM) - 0.03))
        frame_board(axes, view)
        draw_outlines(axes, report.board, side, [VERDICT_COLOURS[each] for each in outcomes])
        write_names(axes, components, ["white" if each in _DARK else INK for each in outcomes])
        draw_scale_bar(axes)
        axes.set_title(f"{side} side, as seen from the top", loc="left", fontsize=9)
        return Picture(".svg", to_bytes(figure, ".svg"), f"Verdicts on the {side} side of {report.board.name}")


@dataclass(frozen=True, slots=True)
class _Map:
    """One quantity on the cells."""

    title: str
    unit: str
    scale: str
    """Name of the scale of colours."""
    limit: float | None = None


def draw_exposures(report: CleaningReport) -> list[tuple[Stage, Picture]]:
    """Draw what reaches the side that a stage sprays: volume, time in the front, the 1993 metric, highest pressure."""
    view = view_of(report.board)
    sprayed: set[Side] = {stage.side for stage in report.stages}
    pixels = {side: see_cells(report.facets, side, view) for side in sprayed}
    return [(stage, _draw_stage(report, index, pixels[stage.side])) for index, stage in enumerate(report.stages)]


def _draw_stage(report: CleaningReport, index: int, pixels: CellPixels) -> Picture:
    side, view = report.stages[index].side, pixels.view
    shown = shown_on_side(report.facets, report.board, side)
    maps = _maps(report, report.stages[index], report.exposures[index])
    panel_mm = min(_LARGEST_PANEL_MM, 0.42 * WIDTH_MM * view.aspect) + _TITLE_MM
    rows = -(-len(maps) // 2)
    with sheet(rows * panel_mm, WIDTH_MM) as figure:
        grid = figure.add_gridspec(
            rows, 2, left=0.0, right=0.93, bottom=0.02, top=1 - _TITLE_MM / (rows * panel_mm), wspace=0.18, hspace=0.2
        )
        for number, (each, values) in enumerate(maps):
            axes = figure.add_subplot(grid[number // 2, number % 2])
            draw_outlines(axes, report.board, side, ["none"] * len(components_of(report.board, side)))
            _draw_map(axes, pixels, np.where(shown, values, np.nan), each)
        name = f"{report.stages[index].function}, {side} side"
        return Picture(".png", to_bytes(figure, ".png"), f"What reaches the surface in {name}")


def _maps(report: CleaningReport, stage: Stage, exposure: Exposure) -> list[tuple[_Map, Scalars]]:
    limits = report.parameters.limits
    least = {"wash": limits.wash_volume_mm, "rinse": limits.rinse_volume_mm, "dry": None}[stage.use]
    front_s = (limits.front_s or None) if stage.use == "wash" else None
    volume = [(_Map("Volume on each area", "mm", "viridis", least), exposure.volume_mm)]
    return [
        *(volume if stage.use != "dry" else []),
        (_Map("Time in the wave front", "s", "cividis", front_s), exposure.front_s),
        (_Map("Time in the cone: the 1993 metric", "s", "cividis"), exposure.cone_s),
        (_Map("Highest pressure", "Pa", "viridis"), exposure.peak_pa),
    ]


def _draw_map(axes: Axes, pixels: CellPixels, values: Scalars, shown: _Map) -> None:
    """Draw one quantity; what nothing reached stands out in the accent."""
    from matplotlib import colormaps

    frame_board(axes, pixels.view)
    axes.set_aspect("equal", anchor="W")
    axes.set_facecolor(BOARD)
    image = pixels.filled(values)
    wet = image[image > 0]
    top = float(np.percentile(wet, 99)) if wet.size else 1.0
    scale = colormaps[shown.scale].with_extremes(under=ACCENT, bad=(0, 0, 0, 0))
    (x0, y0), (x1, y1) = pixels.view.low, pixels.view.high
    drawn = axes.imshow(
        np.ma.masked_invalid(image), cmap=scale, vmin=1e-9 * top, vmax=top, extent=(x0, x1, y0, y1),
        interpolation="nearest", zorder=1.5,
    )  # fmt: skip
    bar = axes.figure.colorbar(drawn, ax=axes, fraction=0.04, pad=0.02, shrink=0.85)
    bar.outline.set_visible(False)
    bar.ax.set_ylim(0, top)
    if shown.limit is not None and shown.limit <= top:
        bar.ax.axhline(shown.limit, color="white", linewidth=1.6)
        bar.ax.axhline(shown.limit, color=INK, linewidth=0.8, linestyle=(0, (2, 1)))
    least = "" if shown.limit is None else f", least {shown.limit:g}"
    axes.set_title(f"{shown.title}, {shown.unit}{least}", loc="left", fontsize=8)
