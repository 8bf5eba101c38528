"""What the joints of a robot do, drawn: position, speed and acceleration against their limits, over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from programs.program import MoveTo
from programs.summary import by_function
from reports.pictures.sheet import (
    ACCENT,
    FUNCTION_COLOURS,
    INK,
    LEFT_MM,
    RIGHT_MM,
    SHEET_MM,
    TOP_MM,
    sheet,
    to_bytes,
    write_foot,
    write_title,
)
from robotcell.robot.rates import Rates, rates_of
from robotcell.robot.robot import Joint
from robotcell.track import CellReport

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW_MM = 30.0
_BOTTOM_MM = 18.0
_QUANTITIES = ("position", "speed", "acceleration")
_MOST_POINTS = 4000
"""Columns of the picture: of more moments, the least and the greatest of each column are drawn."""


def draw_joints(report: CellReport, suffix: str) -> bytes:
    """Draw a report whose robot can do the program; the same report gives the same bytes.

    Args:
        report: What the robot does.
        suffix: ``.png`` or ``.svg``.
    """
    rates = rates_of(report.program, report.joints)
    joints = report.cell.robot.joints
    height_mm = TOP_MM + (len(joints) + 1) * _ROW_MM + _BOTTOM_MM
    with sheet(height_mm) as figure:
        grid = figure.add_gridspec(
            len(joints) + 1,
            3,
            left=LEFT_MM / SHEET_MM[0],
            right=1 - RIGHT_MM / SHEET_MM[0],
            top=1 - TOP_MM / height_mm,
            bottom=_BOTTOM_MM / height_mm,
            hspace=0.42,
            wspace=0.12,
        )
        for row, joint in enumerate(joints):
            for column, (values, limits) in enumerate(_curves(joint, rates, row)):
                axes = figure.add_subplot(grid[row, column])
                times = rates.times if len(values) == len(rates.times) else 0.5 * (rates.times[1:] + rates.times[:-1])
                _draw_curve(axes, times, values, limits)
                unit = "deg" if joint.kind == "revolute" else "mm"
                axes.set_title(f"{joint.name}, {_QUANTITIES[column]} ({unit}{_per(column)})", fontsize=7, loc="left")
                axes.tick_params(labelbottom=False)
                _mark_functions(axes, report)
        _draw_measures([figure.add_subplot(grid[len(joints), column]) for column in range(3)], report)
        totals = report.program.totals
        origin = report.asked.origin
        write_title(
            figure,
            f"{origin.board} in {report.cell.name}",
            f"{report.cell.robot.name}, {totals.duration_s:.1f} s, asked for {report.asked.totals.duration_s:.1f} s",
        )
        _write_functions(figure, report)
        write_foot(figure, f"recipe {origin.recipe}, board {origin.board_sha256[:16]}; time in s along every panel")
        return to_bytes(figure, suffix)


def _per(column: int) -> str:
    return ("", "/s", "/s²")[column]


def _curves(joint: Joint, rates: Rates, index: int) -> list[tuple[Scalars, tuple[float, float]]]:
    """Position, speed and acceleration of a joint in degrees or millimetres, each with its limits."""
    scale = 180.0 / np.pi if joint.kind == "revolute" else 1e3
    limits = [(joint.lowest, joint.highest), (-joint.speed, joint.speed), (-joint.acceleration, joint.acceleration)]
    rows = (rates.q, rates.speed, rates.acceleration)
    return [(scale * row[:, index], (scale * low, scale * high)) for row, (low, high) in zip(rows, limits, strict=True)]


def _draw_curve(axes: Axes, times: Scalars, values: Scalars, limits: tuple[float, float]) -> None:
    """Draw a quantity over time, and its limits where they are near enough to be seen."""
    axes.plot(*_thinned(times, values), color=INK, linewidth=0.5)
    low, high = float(values.min()), float(values.max())
    room = max(high - low, 1e-3)
    for limit in limits:
        if np.isfinite(limit) and low - 1.5 * room <= limit <= high + 1.5 * room:
            axes.axhline(limit, color=ACCENT, linewidth=0.7, linestyle=(0, (4, 2)))
    axes.margins(x=0)
    axes.tick_params(length=2)


def _thinned(times: Scalars, values: Scalars) -> tuple[Scalars, Scalars]:
    """Keep the least and the greatest of each of many short spans, in order."""
    if len(times) <= _MOST_POINTS:
        return times, values
    edges = np.linspace(0, len(times), _MOST_POINTS // 2 + 1).astype(np.int64)
    picked: list[int] = []
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        span = values[begin:end]
        picked += sorted({begin + int(np.argmin(span)), begin + int(np.argmax(span))})
    index = np.array(picked, dtype=np.int64)
    return times[index], values[index]


def _draw_measures(panels: Sequence[Axes], report: CellReport) -> None:
    """Draw how far the robot is from singular postures and from bodies."""
    times = np.array([item.time_s for item in report.program.instructions if isinstance(item, MoveTo)])
    near: NDArray[np.float64] = report.clearance.distances * 1e3
    curves = [
        ("manipulability w", times, report.singularity),
        ("inverse condition", times, report.condition),
        ("distance to board and fixtures (mm)", times[report.clearance_at], near),
    ]
    for axes, (title, at, values) in zip(panels, curves, strict=True):
        axes.plot(*_thinned(at, values), color=INK, linewidth=0.5)
        axes.set_title(title, fontsize=7, loc="left")
        axes.set_ylim(bottom=0.0)
        axes.margins(x=0)
        axes.tick_params(length=2)
        _mark_functions(axes, report)
    panels[2].axhline(report.cell.margin * 1e3, color=ACCENT, linewidth=0.7, linestyle=(0, (4, 2)))


def _mark_functions(axes: Axes, report: CellReport) -> None:
    """Show by a strip along the bottom which function runs when."""
    colours = _colours(report)
    for each in by_function(report.program):
        span = (each.start_s, each.start_s + each.duration_s)
        axes.axvspan(*span, ymax=0.05, color=colours[each.function], linewidth=0)


def _colours(report: CellReport) -> dict[str, str]:
    names = dict.fromkeys(each.function for each in by_function(report.program))
    return {name: FUNCTION_COLOURS[index % len(FUNCTION_COLOURS)] for index, name in enumerate(names)}


def _write_functions(figure: Figure, report: CellReport) -> None:
    """Write the functions in the colours of the strip."""
    height_mm = figure.get_figheight() * 25.4
    for index, (name, colour) in enumerate(_colours(report).items()):
        place = 0.6 + 0.09 * (index % 4)
        figure.text(place, 1 - (17.0 + 5.0 * (index // 4)) / height_mm, name, fontsize=9, color=colour, va="center")
