"""Pictures of a cleaning report: verdicts, what reaches the surface, how evenly and when, what limits components.

The maps around one component show multiples of what is needed, by which R1 and R2 judge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from boards.board import Side
from cleaning.exposure.exposure import Exposure
from cleaning.film.run_off import RunOff
from cleaning.process.stages import Stage
from cleaning.surface.facets import Facets
from cleaning.verdicts.exposed_area import percentile, shown_on_side
from cleaning.verdicts.results import CleaningReport, Part, outcome
from cleaning.verdicts.rules import Outcome
from geometry.arrays import Indices, Scalars
from recipes.recipe import Use
from reports.pictures import sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes

VERDICT_COLOURS: dict[Outcome, str] = {
    "dirty": sheet.ACCENT,
    "marginal": "#e3b04b",
    "clean, wet": "#1d4e85",
    "no verdict": "#aab2b8",
    "clean": "#a9cbe3",
    "avoided": "#e9e4d8",
}
"""Distinct for those who see no red or green, and in grey on paper: what is clean is blue, and deep where wet."""
_DARK: tuple[Outcome, ...] = ("dirty", "clean, wet")
"""Names on these are white."""
WIDTH_MM = 180.0
"""Of all pictures on the page: A4 within its margins."""
_TITLE_MM = 9.0
_LARGEST_PANEL_MM = 150.0
_CURVES_MM = 70.0
_BARS_MM = 5.0
_MOST_AT_ONCE = 50_000
"""Facets that are drawn together: each is an object of matplotlib meanwhile"""
_FLAT = 0.2
"""Facets whose normal rises less than this are walls: from above one would see a line."""
_USES: dict[Use, str] = {"wash": "washing", "rinse": "rinsing"}
_LEAST, _MOST = 0.1, 100.0
"""Ends of the scale around a component, times what is needed."""
_TICKS = (0.1, 0.3, 1, 3, 10, 30, 100)
_ROOM = 0.6
"""Around the component, of its longer side."""
_LEAST_ROOM_MM = 2.0
_REACH_TITLE_MM, _REACH_MM = 11.0, 80.0
_TOO_LITTLE, _NEARLY, _ENOUGH, _MUCH = "#d98e2b", "#f7e9c6", "#d5e4ef", "#1d4e85"


@dataclass(frozen=True, slots=True, eq=False)
class CellPixels:
    """A view of one side from the top, pixel by pixel. Row 0 is at the back (highest y)."""

    view: sheet.View
    cell: Indices
    """(rows, columns) index of the cell, -1 where there is none."""

    def filled(self, values: Scalars) -> NDArray[np.float64]:
        """(rows, columns) value of each pixel's cell; NaN where there is none."""
        return np.where(self.cell >= 0, np.append(values, np.nan)[self.cell], np.nan)


def see_cells(facets: Facets, side: Side, view: sheet.View, most_pixels: int = 900) -> CellPixels:
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
    size = np.array(view.high) - np.array(view.low)
    beyond, plane = 0.01 * size, facets.triangles[seen, :, :2]  # edges have a width
    near = (plane.min(axis=1) < view.high + beyond) & (plane.max(axis=1) > view.low - beyond)
    seen = seen[near.all(axis=1)]
    seen = seen[np.argsort(outward * facets.triangles[seen, :, 2].mean(axis=1), kind="stable")]
    columns, rows = np.maximum(np.round(size / size.max() * most_pixels).astype(int), 1).tolist()
    figure = Figure(figsize=(columns / 100, rows / 100), dpi=100, facecolor="black")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(view.low[0], view.high[0])
    axes.set_ylim(view.low[1], view.high[1])
    canvas.draw()
    for some in np.array_split(seen, -(-len(seen) // _MOST_AT_ONCE) or 1):
        number = facets.cell[some] + 1  # a colour for each cell; black is left for where there is none
        colours = np.column_stack([number >> 16 & 255, number >> 8 & 255, number & 255]) / 255.0
        corners = cast("Sequence[Any]", facets.triangles[some, :, :2])
        triangles = PolyCollection(corners, facecolors=colours, edgecolors=colours, linewidths=0.4, antialiaseds=False)
        axes.add_collection(triangles, autolim=False)
        axes.draw_artist(triangles)
        triangles.remove()
    red, green, blue = np.moveaxis(np.asarray(canvas.buffer_rgba())[:, :, :3].astype(np.int64), 2, 0)
    return CellPixels(view, (red << 16 | green << 8 | blue) - 1)


def draw_verdicts(report: CleaningReport) -> list[sheet.Picture]:
    """Draw each side that has components, each component in the colour of what results for it."""
    return [_draw_verdicts(report, side) for side in sheet.sides_of(report.board)]


def _draw_verdicts(report: CleaningReport, side: Side) -> sheet.Picture:
    view = sheet.view_of(report.board)
    height_mm = min(_LARGEST_PANEL_MM, WIDTH_MM * view.aspect)
    outcomes: list[Outcome] = [
        outcome(part) for part, each in zip(report.parts, report.board.components, strict=True) if each.side == side
    ]
    colours = [VERDICT_COLOURS[each] for each in outcomes]
    letters = ["white" if each in _DARK else sheet.INK for each in outcomes]
    with sheet.open_sheet(".svg", height_mm + _TITLE_MM, WIDTH_MM) as page:
        axes = page.figure.add_axes((0.0, 0.03, 1.0, height_mm / (height_mm + _TITLE_MM) - 0.03))
        sheet.draw_side(axes, report.board, side, view, colours, letters)
        axes.set_title(f"{side} side, as seen from the top", loc="left", fontsize=9)
        return page.picture(f"Verdicts on the {side} side of {report.board.name}")


@dataclass(frozen=True, slots=True)
class _Map:
    """One quantity on the cells."""

    title: str
    unit: str
    scale: str
    """Name of the scale of colours."""
    limit: float | None = None


def draw_exposures(report: CleaningReport) -> list[tuple[Stage, sheet.Picture]]:
    """Draw what reaches the side that a stage sprays: volume, time in the front, the 1993 metric, highest pressure."""
    view = sheet.view_of(report.board)
    sprayed: set[Side] = {stage.side for stage in report.stages}
    pixels = {side: see_cells(report.facets, side, view) for side in sprayed}
    return [(stage, _draw_stage(report, index, pixels[stage.side])) for index, stage in enumerate(report.stages)]


def _draw_stage(report: CleaningReport, index: int, pixels: CellPixels) -> sheet.Picture:
    side, view = report.stages[index].side, pixels.view
    shown = shown_on_side(report.facets, report.board, side)
    maps = _maps(report, report.stages[index], report.exposures[index])
    panel_mm = min(_LARGEST_PANEL_MM, 0.42 * WIDTH_MM * view.aspect) + _TITLE_MM
    height_mm = -(-len(maps) // 2) * panel_mm
    with sheet.open_sheet(".png", height_mm, WIDTH_MM) as page:
        panels = page.grid(len(maps), 2, (0.0, 0.02, 0.93, 1 - _TITLE_MM / height_mm), (0.18, 0.2))
        for axes, (each, values) in zip(panels, maps, strict=True):
            sheet.frame_board(axes, pixels.view)
            sheet.draw_outlines(axes, report.board, side, ["none"] * len(sheet.components_of(report.board, side)))
            _draw_map(axes, pixels, np.where(shown, values, np.nan), each)
        return page.picture(f"What reaches the surface in {report.stages[index].function}, {side} side")


def _maps(report: CleaningReport, stage: Stage, exposure: Exposure) -> list[tuple[_Map, Scalars]]:
    limits = report.parameters.limits
    least = {"wash": limits.wash_volume_mm, "rinse": limits.rinse_volume_mm, "dry": None}[stage.use]
    front_s = (limits.front_s or None) if stage.use == "wash" else None
    supply_mm = np.where(exposure.volume_mm > 0, exposure.supply_mm, 0.0)  # what is never hit stands out
    volume = [(_Map("Volume on each area, run-off included", "mm", "viridis", least), supply_mm)]
    return [
        *(volume if stage.use != "dry" else []),
        (_Map("Time in the wave front", "s", "cividis", front_s), exposure.front_s),
        (_Map("Time in the cone: the 1993 metric", "s", "cividis"), exposure.cone_s),
        (_Map("Highest pressure", "Pa", "viridis"), exposure.peak_pa),
    ]


def _draw_map(axes: Axes, pixels: CellPixels, values: Scalars, shown: _Map) -> None:
    """Draw one quantity; what nothing reached stands out in the accent."""
    from matplotlib import colormaps

    axes.set_aspect("equal", anchor="W")
    axes.set_facecolor(sheet.BOARD)
    image = pixels.filled(values)
    wet = image[image > 0]
    top = float(np.percentile(wet, 99)) if wet.size else 1.0
    scale = colormaps[shown.scale].with_extremes(under=sheet.ACCENT, bad=(0, 0, 0, 0))
    place = {"fraction": 0.04, "pad": 0.02, "shrink": 0.85}
    bar = sheet.draw_image(axes, image, pixels.view.extent, scale, place, vmin=1e-9 * top, vmax=top, zorder=1.5)
    bar.ax.set_ylim(0, top)
    if shown.limit is not None and shown.limit <= top:
        bar.ax.axhline(shown.limit, color="white", linewidth=1.6)
        bar.ax.axhline(shown.limit, color=sheet.INK, linewidth=0.8, linestyle=(0, (2, 1)))
    least = "" if shown.limit is None else f", least {shown.limit:g}"
    axes.set_title(f"{shown.title}, {shown.unit}{least}", loc="left", fontsize=8)


def draw_volumes(report: CleaningReport) -> sheet.Picture | None:
    """Draw which share of the sprayed area gets at least a volume, and how that grows; nothing without a liquid."""
    wet = [index for index, stage in enumerate(report.stages) if stage.use != "dry"]
    if not wet:
        return None
    with sheet.open_sheet(".svg", _CURVES_MM, WIDTH_MM) as page:
        left, right = page.figure.subplots(1, 2)
        page.figure.subplots_adjust(left=0.07, right=0.98, bottom=0.17, top=0.88, wspace=0.2)
        for number, index in enumerate(wet):
            stage, exposure = report.stages[index], report.exposures[index]
            shown = shown_on_side(report.facets, report.board, stage.side)
            areas = np.where(shown, report.facets.cell_areas_mm2, 0.0)
            colour = sheet.FUNCTION_COLOURS[number % len(sheet.FUNCTION_COLOURS)]
            limit = least_volume_mm(report, stage)
            _draw_shares(left, exposure.supply_mm, areas, colour, f"{stage.function}, least {limit:g} mm")
            left.axvline(limit, color=colour, linewidth=0.7, linestyle=(0, (4, 2)))
            times, shares = growth_of(exposure, areas, limit, report.run_off[stage.side])
            right.plot(times, 100 * shares, color=colour, linewidth=1.2, label=stage.function)
        _finish(left, "volume on each area, run-off included, mm", "Area that gets at least so much, %")
        _finish(right, "time in the program, s", "Area that has its least volume, %")
        left.legend(frameon=False, fontsize=7)
        return page.picture("Share of the area by volume and over time")


def least_volume_mm(report: CleaningReport, stage: Stage) -> float:
    """Give the least volume that counts as enough in a stage."""
    limits = report.parameters.limits
    return limits.wash_volume_mm if stage.use == "wash" else limits.rinse_volume_mm


def growth_of(exposure: Exposure, areas: Scalars, limit_mm: float, run_off: RunOff) -> tuple[Scalars, Scalars]:
    """Follow which share of an area has at least a volume, run-off included, at the end of each block of a stage.

    Args:
        exposure: Of the stage.
        areas: (c,) area of each cell that counts, mm2; 0 for those that do not.
        limit_mm: The volume.
        run_off: Of the side that is sprayed.
    """
    growth, total = exposure.growth, max(float(areas.sum()), 1e-30)
    volume = np.zeros(len(areas))
    shares = np.zeros(len(growth.until_s))
    film_mm = np.cumsum(growth.film_mm, axis=0, dtype=np.float64)
    for block, (begin, end) in enumerate(zip(growth.start[:-1].tolist(), growth.start[1:].tolist(), strict=True)):
        np.add.at(volume, growth.cell[begin:end], growth.volume_mm[begin:end])
        supply = volume + run_off.on_cells(volume, film_mm[block]) if len(film_mm) else volume
        shares[block] = float(areas[supply >= (1 - 1e-6) * limit_mm].sum()) / total
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


def draw_limiting(parts: Sequence[Part]) -> sheet.Picture | None:
    """Draw how strongly each factor moves the residue of some components; nothing where none is known."""
    known = [part for part in parts if part.limiting and part.elasticity]
    if not known:
        return None
    factors = list(known[0].elasticity)
    height_mm = 18.0 + _BARS_MM * len(known)
    with sheet.open_sheet(".svg", height_mm, WIDTH_MM) as page:
        panels = page.figure.subplots(1, len(factors), sharex=True, sharey=True, squeeze=False)[0]
        page.figure.subplots_adjust(left=0.1, right=0.99, bottom=10.5 / height_mm, top=1 - 6.5 / height_mm, wspace=0.1)
        for axes, factor in zip(panels, factors, strict=True):
            values = [abs(part.elasticity.get(factor, 0.0)) for part in known]
            colours = [sheet.ACCENT if part.limiting == factor else sheet.QUIET for part in known]
            axes.barh(range(len(known)), values, color=colours, height=0.65)
            axes.set_title("nozzle distance" if factor == "standoff" else factor, loc="left", fontsize=8)
            axes.tick_params(length=0)
            axes.spines[["top", "right", "left"]].set_visible(False)
        panels[0].set_xlim(left=0.0)
        panels[0].locator_params(axis="x", nbins=3)
        panels[0].set_yticks(range(len(known)), [part.component for part in known], color=sheet.INK)
        panels[0].set_ylim(len(known) - 0.4, -0.6)
        panels[0].set_xlabel("% of residue for each % of the factor", loc="left")
        return page.picture("How strongly each factor moves the residue")


def draw_reach(report: CleaningReport, part: Part) -> sheet.Picture | None:
    """Draw what washing and what rinsing bring to a component and its neighbours; nothing where no liquid is sprayed.

    All stages of one use on its side count together, as often as loops may do them, and are compared with the least
    volume that a clean part gets.
    """
    component = next(each for each in report.board.components if each.name == part.component)
    side, (x0, y0, x1, y1) = component.side, component.outline.bounds
    uses: list[Use] = [use for use in _USES if any((each.use, each.side) == (use, side) for each in report.stages)]
    if not uses:
        return None
    room = max(_ROOM * max(x1 - x0, y1 - y0), _LEAST_ROOM_MM)
    pixels = see_cells(report.facets, side, sheet.View((x0 - room, y0 - room), (x1 + room, y1 + room)), 500)
    height_mm = min(_REACH_MM * pixels.view.aspect, 100.0)
    with sheet.open_sheet(".svg", height_mm + _REACH_TITLE_MM, WIDTH_MM) as page:
        for column, use in enumerate(uses):
            top = height_mm / (height_mm + _REACH_TITLE_MM)
            _draw_reach(page.figure.add_axes((column * 0.5, 0.05, 0.43, top - 0.05)), report, side, pixels, use)
        return page.picture(f"What reaches {component.name} and around it, times what is needed")


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


def _draw_reach(axes: Axes, report: CleaningReport, side: Side, pixels: CellPixels, use: Use) -> None:
    from matplotlib.colors import LinearSegmentedColormap, LogNorm, to_rgba

    middle = np.log(1.0 / _LEAST) / np.log(_MOST / _LEAST)
    colours = [(0.0, _TOO_LITTLE), (middle, _NEARLY), (middle, _ENOUGH), (1.0, _MUCH)]
    scale = LinearSegmentedColormap.from_list("needed", colours).with_extremes(under=_TOO_LITTLE, bad=(0, 0, 0, 0))
    sheet.frame_board(axes, pixels.view)
    components = sheet.components_of(report.board, side)
    sheet.draw_outlines(axes, report.board, side, ["none"] * len(components))
    axes.set_facecolor(sheet.BOARD)
    shown = shown_on_side(report.facets, report.board, side)
    image = pixels.filled(np.where(shown, times_needed(report, side, use), np.nan))
    never = np.zeros((*image.shape, 4))
    never[image == 0.0] = to_rgba(sheet.ACCENT)
    reached, place = np.where(image > 0.0, image, np.nan), {"fraction": 0.046, "pad": 0.03}
    bar = sheet.draw_image(axes, reached, pixels.view.extent, scale, place, norm=LogNorm(_LEAST, _MOST), zorder=1.5)
    axes.imshow(never, extent=pixels.view.extent, interpolation="nearest", zorder=1.6)
    bar.set_ticks(list(_TICKS), labels=[f"{each:g}" for each in _TICKS])
    bar.minorticks_off()
    sheet.write_names(axes, components, [sheet.INK] * len(components))
    sheet.draw_scale_bar(axes)
    axes.set_title(f"{_USES[use]}: times what is needed", loc="left", fontsize=8)
