"""Position, speed and acceleration of every joint over time, against its limits, drawn one over the other."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Literal, TypeAlias

import numpy as np

from geometry.arrays import Scalars
from robotcell.robot.robot import Joint, Robot
from webui.layers.robot.robot import JointMotion, joints_at
from webui.theme.palette import ACCENT, COLLIDING, INK, NAMED, QUIET, to_hex

Quantity: TypeAlias = Literal["position", "speed", "acceleration"]

_COLUMNS = 400
_HEAD_PX, _PLOT_PX, _FOOT_PX = 16, 40, 6
_SHORTEST_S = 1e-6
_PAD = 0.08
_UNITS: dict[Quantity, str] = {"position": "", "speed": "/s", "acceleration": "/s\N{SUPERSCRIPT TWO}"}


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """One quantity of one joint over time, in degrees or millimetres."""

    name: str
    quantity: Quantity
    unit: str
    times: Scalars
    """(n,) s, ascending."""
    values: Scalars
    """(n,)"""
    lowest: float
    """What the joint may do; infinite where it may do anything."""
    highest: float


def joint_curves(robot: Robot, motion: JointMotion, quantity: Quantity) -> list[Curve]:
    """Give a quantity of each joint; speeds and accelerations are those between two samples.

    Speeds are means, accelerations the changes between the slopes of parabolas through three samples each: exact for a
    joint that speeds up evenly, also where samples are not evenly apart.

    Args:
        robot: Knows the limits.
        motion: How the joints stand when.
        quantity: What to give.
    """
    times = key_times(motion)
    rows = joints_at(motion, times)
    if quantity == "acceleration" and len(times) > 2:
        rows = np.asarray(np.gradient(rows, times, axis=0, edge_order=2), dtype=np.float64)
    if quantity != "position":
        times, rows = _differences(times, rows)
    return [
        _curve(joint, quantity, times, column) for joint, column in zip(robot.joints, rows.T, strict=True) if len(times)
    ]


def key_times(motion: JointMotion) -> Scalars:
    """(n,) program times, s, between which every joint moves evenly: at moves and at both ends of waits."""
    times = np.unique(np.concatenate([motion.times, motion.wait_ends]))
    return times[np.concatenate([[True], np.diff(times) > _SHORTEST_S])]


def envelope(times: Scalars, values: Scalars, end_s: float, columns: int = _COLUMNS) -> tuple[Scalars, Scalars]:
    """Least and greatest value, (columns,) each, in equal stretches of the time from 0 to the end."""
    edges = np.linspace(0.0, end_s, columns + 1)
    inside = (times > 0) & (times < end_s)
    all_times = np.concatenate([times[inside], edges[:-1], edges[1:]])
    all_values = np.concatenate([values[inside], *[np.interp(edges, times, values)[each] for each in (_FIRST, _LAST)]])
    column = np.minimum(np.searchsorted(edges, times[inside], side="right") - 1, columns - 1)
    column = np.concatenate([column, np.arange(columns), np.arange(columns)])
    order = np.lexsort((all_times, column))
    starts = np.searchsorted(column[order], np.arange(columns))
    ordered = all_values[order]
    return np.minimum.reduceat(ordered, starts), np.maximum.reduceat(ordered, starts)


_FIRST, _LAST = slice(None, -1), slice(1, None)


def curves_html(curves: Sequence[Curve], end_s: float) -> str:
    """Draw curves one over the other, as wide as their place; limits are drawn where they are near."""
    rows = "".join(_row_html(curve, end_s, to_hex(NAMED[index % len(NAMED)])) for index, curve in enumerate(curves))
    return (
        f'<div style="margin:0 12px;font-size:11px;color:{to_hex(INK)};font-variant-numeric:tabular-nums">{rows}</div>'
    )


def plot_cursor_html(now_s: float, end_s: float, curves: int) -> str:
    """Draw the moment that is shown over the curves that stand above."""
    height = curves * (_HEAD_PX + _PLOT_PX + _FOOT_PX)
    left = 100 * min(max(now_s / end_s, 0.0), 1.0) if end_s > 0 else 0.0
    return (
        '<div style="position:relative;height:0;margin:0 12px"><div style="position:absolute;'
        f"left:{left:.3f}%;top:-{height}px;height:{height}px;width:1px;background:{to_hex(ACCENT)}"
        '"></div></div>'
    )


def use_of(curve: Curve) -> float:
    """Greatest share of what a joint may do that it does; for a position how far it is from the middle of its range."""
    middle, half = (curve.lowest + curve.highest) / 2, (curve.highest - curve.lowest) / 2
    if not np.isfinite(half):
        return 0.0
    return float(np.abs(curve.values - middle).max() / half)


def _curve(joint: Joint, quantity: Quantity, times: Scalars, values: Scalars) -> Curve:
    scale, unit = (1000.0, " mm") if joint.kind == "prismatic" else (180.0 / np.pi, "\N{DEGREE SIGN}")
    most = joint.speed if quantity == "speed" else joint.acceleration
    lowest, highest = (joint.lowest, joint.highest) if quantity == "position" else (-most, most)
    return Curve(joint.name, quantity, unit + _UNITS[quantity], times, scale * values, scale * lowest, scale * highest)


def _differences(times: Scalars, rows: Scalars) -> tuple[Scalars, Scalars]:
    """Rates of change of (n, k) rows, and the moments in the middle at which they hold."""
    return (times[1:] + times[:-1]) / 2, np.diff(rows, axis=0) / np.diff(times)[:, None]


def _row_html(curve: Curve, end_s: float, colour: str) -> str:
    low, high = envelope(curve.times, curve.values, end_s)
    bottom, top = _range_of(curve, float(low.min()), float(high.max()))
    x = np.linspace(0.0, 100.0, len(low))
    upper, lower = (100.0 * (top - edge) / (top - bottom) for edge in (high, low))
    corners = " ".join(f"{at:.2f},{y:.1f}" for at, y in zip([*x, *x[::-1]], [*upper, *lower[::-1]], strict=True))
    beyond = use_of(curve) > 1.0 + 1e-3
    return (
        f'<div style="height:{_HEAD_PX}px;line-height:{_HEAD_PX}px;display:flex;justify-content:space-between">'
        f'<span style="color:{colour};font-weight:600">{escape(curve.name)}</span>'
        f'<span style="color:{to_hex(COLLIDING if beyond else QUIET)}">{escape(_words(curve))}</span></div>'
        f'<svg viewBox="0 0 100 100" preserveAspectRatio="none" style="display:block;width:100%;height:{_PLOT_PX}px;'
        f'margin-bottom:{_FOOT_PX}px;background:#f6f7f8">{_limits_svg(curve, bottom, top)}'
        f'<polygon points="{corners}" fill="{colour}" stroke="{colour}" stroke-width="1" stroke-linejoin="round" '
        'vector-effect="non-scaling-stroke"/></svg>'
    )


def _range_of(curve: Curve, low: float, high: float) -> tuple[float, float]:
    """What a drawing spans: all that a rate may be, so that its size shows; for positions what is used."""
    if curve.quantity != "position" and np.isfinite(curve.highest):
        low, high = min(low, curve.lowest), max(high, curve.highest)
    pad = max(_PAD * (high - low), 0.5)
    return low - pad, high + pad


def _limits_svg(curve: Curve, bottom: float, top: float) -> str:
    """Lines at the limits that are in sight, and at nothing for rates."""
    marks = [(limit, to_hex(COLLIDING), "4 3") for limit in (curve.lowest, curve.highest)]
    if curve.quantity != "position":
        marks.append((0.0, "#d5dade", "none"))
    return "".join(
        f'<line x1="0" x2="100" y1="{y:.1f}" y2="{y:.1f}" stroke="{colour}" stroke-width="1" '
        f'stroke-dasharray="{dashes}" vector-effect="non-scaling-stroke"/>'
        for y, colour, dashes in ((100 * (top - at) / (top - bottom), colour, dashes) for at, colour, dashes in marks)
        if 0 <= y <= 100
    )


def _words(curve: Curve) -> str:
    """What it does at most, and how that is to what it may do."""
    if curve.quantity == "position":
        low, high = float(curve.values.min()), float(curve.values.max())
        reach = f"{low:.0f} to {high:.0f}{curve.unit}"
        near = min(low - curve.lowest, curve.highest - high)
        if not np.isfinite(near):
            return f"{reach}, no limit"
        return (
            f"{reach}, {near:.0f}{curve.unit} to the limit" if near >= 0 else f"{reach}, {-near:.1f}{curve.unit} beyond"
        )
    most = float(np.abs(curve.values).max())
    if not np.isfinite(curve.highest):
        return f"{most:.0f}{curve.unit}, no limit"
    return f"{most:.0f} of {curve.highest:.0f}{curve.unit} ({use_of(curve):.0%})"
