"""A placement as a sheet: box plots of the configurations, the points of the workpiece, the map over the table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reports.cards.placement import CRITERIA, METRICS, value_text, worst_words
from reports.pictures.sheet import (
    ACCENT,
    FAINT,
    INK,
    LEFT_MM,
    QUIET,
    SHEET_MM,
    TOP_MM,
    Picture,
    sheet,
    to_bytes,
    write_foot,
    write_title,
)
from reports.tables.wording import amount
from robotcell.placement.configurations import PlacementDetails
from robotcell.placement.placement_map import PlacementMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable

_HEIGHT_MM = 170.0
_BOTTOM_MM = 24.0
COLOURS = "viridis"
"""Colours of values: dark is worse, light is better."""
_BAR = 0.32


def draw_placement(details: PlacementDetails, mapped: PlacementMap | None, suffix: str) -> bytes:
    """Draw the box plots, the points from above in the colours of their values, and the map if there is one.

    Raises:
        JobError: the suffix is neither ``.png`` nor ``.svg``.
    """
    with sheet(_HEIGHT_MM) as figure:
        score, goal = details.score, details.goal
        stated = f"{CRITERIA[goal.criterion]} of {METRICS[goal.metric]} is {value_text(score.value, goal.metric)}"
        failing = f"infeasible, {amount(len(details.failing), 'point')} of {len(details.targets.tool)} not good enough"
        title = f"{details.cell.robot.name}: {stated if score.value >= 0.0 else failing}"
        write_title(figure, title, f"worst: {worst_words(details)}")
        shares = [1.15, 1.0, 1.0] if mapped is not None else [1.15, 1.0]
        grid = figure.add_gridspec(
            1, len(shares), width_ratios=shares, left=(LEFT_MM + 30) / SHEET_MM[0], right=1 - 10 / SHEET_MM[0],
            bottom=_BOTTOM_MM / _HEIGHT_MM, top=1 - TOP_MM / _HEIGHT_MM, wspace=0.3,
        )  # fmt: skip
        _draw_boxes(figure.add_subplot(grid[0, 0]), details)
        _draw_points(figure.add_subplot(grid[0, 1]), details)
        if mapped is not None:
            _draw_map(figure.add_subplot(grid[0, 2]), details, mapped)
        count = len(details.targets.tool)
        write_foot(
            figure, f"{details.cell.name}; {count} points, bodies checked. Boxes: 5, 25, 50, 75, 95 % of the points"
        )
        return to_bytes(figure, suffix)


def placement_picture(details: PlacementDetails, mapped: PlacementMap | None) -> Picture:
    """Give the sheet as a picture of a page."""
    alt = f"Box plots of the configurations, points of the workpiece{'' if mapped is None else ', map of placements'}"
    return Picture(".svg", draw_placement(details, mapped, ".svg"), alt)


def _draw_boxes(axes: Axes, details: PlacementDetails) -> None:
    rows = details.configurations
    for row, each in enumerate(rows):
        used = each.branch in details.score.branches
        colour = INK if used else QUIET
        low, first, middle, third, high = each.box.tolist()
        if not np.isfinite(middle):
            continue
        axes.plot((low, first), (row, row), color=colour, linewidth=1.0)
        axes.plot((third, high), (row, row), color=colour, linewidth=1.0)
        for end in (low, high):
            axes.plot((end, end), (row - 0.15, row + 0.15), color=colour, linewidth=1.0)
        axes.barh(row, third - first, 2 * _BAR, first, color="#d5e4ef" if used else "#eef1ec", edgecolor=colour)
        axes.plot((middle, middle), (row - _BAR, row + _BAR), color=colour, linewidth=2.0)
        least = float(each.values[np.isfinite(each.values)].min())
        axes.plot(least, row, marker="o", markersize=3.5, color=ACCENT if used else QUIET, linestyle="none")
    names = [f"{each.name}\n{each.reached:.0%} reached" for each in rows]
    axes.set_yticks(range(len(rows)), names)
    axes.invert_yaxis()
    if details.goal.floor > 0.0:
        axes.axvline(details.goal.floor, color=ACCENT, linewidth=0.8, linestyle="--")
    axes.set_xlim(left=0.0)
    axes.set_title(f"{METRICS[details.goal.metric]} of each configuration", loc="left", fontsize=9)
    axes.set_xlabel("dot: the least; dashed: the floor" if details.goal.floor > 0.0 else "dot: the least")


def _draw_points(axes: Axes, details: PlacementDetails) -> None:
    at, values = 1e3 * details.targets.T_board_tcp[:, :3, 3], details.values
    there = np.isfinite(values)
    drawn = axes.scatter(at[there, 0], at[there, 1], c=values[there], cmap=COLOURS, s=14, linewidths=0)
    axes.plot(at[~there, 0], at[~there, 1], marker="x", color=ACCENT, markersize=4, linestyle="none")
    worst = details.worst
    axes.plot(at[worst, 0], at[worst, 1], marker="o", markersize=11, markerfacecolor="none", markeredgecolor=ACCENT)
    axes.annotate(
        f"point {worst}",
        (float(at[worst, 0]), float(at[worst, 1])),
        xytext=(7, 7),
        textcoords="offset points",
        color=ACCENT,
        fontsize=8,
    )
    if there.any():
        _add_scale(axes, drawn)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title("points of the workpiece from above, mm", loc="left", fontsize=9)


def _draw_map(axes: Axes, details: PlacementDetails, mapped: PlacementMap) -> None:
    x, y = 1e3 * mapped.x, 1e3 * mapped.y
    half = 0.5 * np.array([x[1] - x[0], y[1] - y[0]])
    extent = (x[0] - half[0], x[-1] + half[0], y[0] - half[1], y[-1] + half[1])
    drawn = axes.imshow(
        np.ma.masked_invalid(mapped.highest.T), origin="lower", extent=extent, cmap=COLOURS, interpolation="nearest"
    )
    i, j, _ = mapped.best
    if mapped.score.value >= 0.0:
        at = (x[i], y[j]) if mapped.refined_at is None else (1e3 * mapped.refined_at[0], 1e3 * mapped.refined_at[1])
        axes.plot(*at, marker="+", markersize=12, color=ACCENT, markeredgewidth=2)
    base = 1e3 * details.cell.T_cell_base[:2, 3]
    if extent[0] <= base[0] <= extent[1] and extent[2] <= base[1] <= extent[3]:
        axes.plot(*base, marker="s", markersize=7, color=INK)
    axes.set_facecolor(FAINT)
    _add_scale(axes, drawn)
    axes.set_title("map: best over the yaws; +: best node, refined; square: base", loc="left", fontsize=9)


def _add_scale(axes: Axes, drawn: ScalarMappable) -> None:
    """Colours and their values, below the ticks of the axes."""
    bar = axes.figure.colorbar(drawn, ax=axes, fraction=0.046, pad=0.09, location="bottom")
    bar.outline.set_visible(False)
