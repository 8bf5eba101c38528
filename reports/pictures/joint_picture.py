"""What the joints of a robot do over time, against their limits: position, speed and acceleration, drawn as a sheet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from geometry.arrays import Scalars
from programs.program import MoveTo
from programs.summary import by_function
from reports.pictures.sheet import ACCENT, FUNCTION_COLOURS, INK, QUIET, TOP_MM, open_sheet
from robotcell.motion.retime import Rates, rates_of
from robotcell.robot.robot import Joint
from robotcell.track import CellReport

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Quantity: TypeAlias = Literal["position", "speed", "acceleration"]
QUANTITIES: tuple[Quantity, ...] = ("position", "speed", "acceleration")
_PER: dict[Quantity, str] = {"position": "", "speed": "/s", "acceleration": "/s²"}
_ROW_MM = 30.0
_BOTTOM_MM = 18.0
_COLUMNS = 2000
"""Stretches of time of which the sheet shows the least and the greatest value."""
_PAD = 0.08


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """One quantity of one joint over time, in degrees or millimetres."""

    name: str
    quantity: Quantity
    unit: str
    """Such as ``"°/s"`` or ``"mm"``."""
    times: Scalars
    """(n,) s, ascending."""
    values: Scalars
    """(n,)"""
    lowest: float
    """Limit of the joint; infinite where it has none."""
    highest: float

    @property
    def use(self) -> float:
        """Greatest share of the limit that is used; for a position, the distance from the middle of its range."""
        middle, half = (self.lowest + self.highest) / 2, (self.highest - self.lowest) / 2
        return float(np.abs(self.values - middle).max() / half) if np.isfinite(half) else 0.0

    @property
    def span(self) -> tuple[float, float]:
        """Range of a drawing: a rate within its limits, so that its size shows; a position as far as it is used."""
        low, high = float(self.values.min()), float(self.values.max())
        if self.quantity != "position" and np.isfinite(self.highest):
            low, high = min(low, self.lowest), max(high, self.highest)
        pad = max(_PAD * (high - low), 0.5)
        return low - pad, high + pad

    @property
    def summary(self) -> str:
        """Extremes of the quantity, and how near they are to the limits."""
        unit = self.unit if self.unit.startswith("°") else f" {self.unit}"
        if self.quantity == "position":
            low, high = float(self.values.min()), float(self.values.max())
            reach, near = f"{low:.0f} to {high:.0f}{unit}", min(low - self.lowest, self.highest - high)
            if not np.isfinite(near):
                return f"{reach}, no limit"
            return f"{reach}, {near:.0f}{unit} to the limit" if near >= 0 else f"{reach}, {-near:.1f}{unit} beyond"
        most = float(np.abs(self.values).max())
        if not np.isfinite(self.highest):
            return f"{most:.0f}{unit}, no limit"
        return f"{most:.0f} of {self.highest:.0f}{unit} ({self.use:.0%})"


def joint_curves(joints: Sequence[Joint], rates: Rates, quantity: Quantity) -> list[Curve]:
    """Give a quantity of each joint over time: speeds are means of the intervals between moves."""
    times = (rates.times[1:] + rates.times[:-1]) / 2 if quantity == "speed" else rates.times
    rows = {"position": rates.q, "speed": rates.speed, "acceleration": rates.acceleration}[quantity]
    curves: list[Curve] = []
    for joint, column in zip(joints, rows.T, strict=True):
        scale, unit = (180.0 / np.pi, "°") if joint.kind == "revolute" else (1e3, "mm")
        most = joint.speed if quantity == "speed" else joint.acceleration
        low, high = (joint.lowest, joint.highest) if quantity == "position" else (-most, most)
        unit += _PER[quantity]
        curves.append(Curve(joint.name, quantity, unit, times, scale * column, scale * low, scale * high))
    return curves


def envelope(times: Scalars, values: Scalars, end_s: float, columns: int) -> tuple[Scalars, Scalars]:
    """Least and greatest value, (columns,) each, in equal stretches of the time from 0 to the end."""
    edges = np.linspace(0.0, end_s, columns + 1)
    inside = (times > 0) & (times < end_s)
    at_edges = np.interp(edges, times, values)
    all_times = np.concatenate([times[inside], edges[:-1], edges[1:]])
    all_values = np.concatenate([values[inside], at_edges[:-1], at_edges[1:]])
    column = np.minimum(np.searchsorted(edges, times[inside], side="right") - 1, columns - 1)
    column = np.concatenate([column, np.arange(columns), np.arange(columns)])
    order = np.lexsort((all_times, column))
    starts = np.searchsorted(column[order], np.arange(columns))
    ordered = all_values[order]
    return np.minimum.reduceat(ordered, starts), np.maximum.reduceat(ordered, starts)


def draw_joints(report: CellReport, suffix: str) -> bytes:
    """Draw a report whose robot can do the program; the same report gives the same bytes.

    Args:
        report: Joint motion of the robot.
        suffix: ``.png`` or ``.svg``.
    """
    rates, joints = rates_of(report.program, report.joints), report.cell.robot.joints
    functions = by_function(report.program)
    names = dict.fromkeys(each.function for each in functions)
    colours = {name: FUNCTION_COLOURS[index % len(FUNCTION_COLOURS)] for index, name in enumerate(names)}
    origin, takes_s = report.requested.origin, report.program.totals.duration_s
    planned = f"programmed {report.requested.totals.duration_s:.1f} s"
    times = f"{report.cell.robot.name}, {takes_s:.1f} s, {planned}"
    foot = f"recipe {origin.recipe}, board {origin.board_sha256[:16]}; time in s along every panel"
    height_mm = TOP_MM + (len(joints) + 1) * _ROW_MM + _BOTTOM_MM
    with open_sheet(suffix, height_mm, title=(f"{origin.board} in {report.cell.name}", times), foot=foot) as sheet:
        panels = sheet.panels(3 * len(joints) + 3, 3, _BOTTOM_MM, (0.12, 0.42))
        for column, quantity in enumerate(QUANTITIES):
            for row, curve in enumerate(joint_curves(joints, rates, quantity)):
                axes = panels[3 * row + column]
                _draw_values(axes, report, f"{curve.name}, {quantity} ({curve.unit})", (curve.times, curve.values))
                axes.set_title(curve.summary, fontsize=6.5, loc="right", color=QUIET)
                low, high = curve.span
                axes.set_ylim(low, high)
                _draw_limits(axes, [limit for limit in (curve.lowest, curve.highest) if low <= limit <= high])
                axes.tick_params(labelbottom=False)
        _draw_measures(panels[-3:], report)
        for axes in panels:  # a strip along the bottom: which function runs when
            for each in functions:
                span = (each.start_s, each.start_s + each.duration_s)
                axes.axvspan(*span, ymax=0.05, color=colours[each.function], linewidth=0)
        for index, (name, colour) in enumerate(colours.items()):
            place = (0.6 + 0.09 * (index % 4), 1 - (17.0 + 5.0 * (index // 4)) / height_mm)
            sheet.figure.text(*place, name, fontsize=9, color=colour, va="center")
        return sheet.content()


def _draw_values(axes: Axes, report: CellReport, title: str, curve: tuple[Scalars, Scalars]) -> None:
    """Draw times and values of a quantity; of many moments the least and the greatest value of each stretch."""
    end_s = report.program.totals.duration_s
    low, high = envelope(*curve, end_s, _COLUMNS)
    middles = (np.arange(_COLUMNS) + 0.5) / _COLUMNS * end_s
    axes.fill_between(middles, low, high, facecolor=INK, edgecolor=INK, linewidth=0.5)
    axes.set_xlim(0.0, end_s)
    axes.set_title(title, fontsize=7, loc="left")
    axes.tick_params(length=2)


def _draw_limits(axes: Axes, limits: Sequence[float]) -> None:
    for limit in limits:
        axes.axhline(limit, color=ACCENT, linewidth=0.7, linestyle=(0, (4, 2)))


def _draw_measures(panels: Sequence[Axes], report: CellReport) -> None:
    """Draw how far the robot is from singular configurations and from bodies."""
    times = np.array([item.time_s for item in report.program.instructions if isinstance(item, MoveTo)])
    curves = [
        ("manipulability w", (times, report.singularity)),
        ("inverse condition", (times, report.condition)),
        ("distance to board and fixtures (mm)", (times[report.clearance_at], report.clearance.distances * 1e3)),
    ]
    for axes, (title, curve) in zip(panels, curves, strict=True):
        _draw_values(axes, report, title, curve)
        axes.set_ylim(bottom=0.0)
    _draw_limits(panels[2], [report.cell.margin * 1e3])
