"""Plots of joint curves over time with their limits, as HTML."""

from collections.abc import Sequence
from html import escape

import numpy as np

from reports.pictures.joint_picture import Curve, envelope
from webui.theme.palette import ACCENT, COLLIDING, INK, NAMED, QUIET, to_hex

_COLUMNS = 400
_HEAD_PX, _PLOT_PX, _FOOT_PX = 16, 40, 6


def curves_html(curves: Sequence[Curve], end_s: float) -> str:
    """Plots of curves one below the other, as wide as their container; limits are drawn where they are near."""
    rows = "".join(_row_html(curve, end_s, to_hex(NAMED[index % len(NAMED)])) for index, curve in enumerate(curves))
    return (
        f'<div style="margin:0 12px;font-size:11px;color:{to_hex(INK)};font-variant-numeric:tabular-nums">{rows}</div>'
    )


def plot_cursor_html(now_s: float, end_s: float, curves: int) -> str:
    """Cursor over the plots above, at the time that is shown."""
    height = curves * (_HEAD_PX + _PLOT_PX + _FOOT_PX)
    left = 100 * min(max(now_s / end_s, 0.0), 1.0) if end_s > 0 else 0.0
    return (
        '<div style="position:relative;height:0;margin:0 12px"><div style="position:absolute;'
        f"left:{left:.3f}%;top:-{height}px;height:{height}px;width:1px;background:{to_hex(ACCENT)}"
        '"></div></div>'
    )


def _row_html(curve: Curve, end_s: float, colour: str) -> str:
    low, high = envelope(curve.times, curve.values, end_s, _COLUMNS)
    bottom, top = curve.span
    x = np.linspace(0.0, 100.0, len(low))
    upper, lower = (100.0 * (top - edge) / (top - bottom) for edge in (high, low))
    corners = " ".join(f"{at:.2f},{y:.1f}" for at, y in zip([*x, *x[::-1]], [*upper, *lower[::-1]], strict=True))
    marks = [(limit, to_hex(COLLIDING), "4 3") for limit in (curve.lowest, curve.highest)]
    if curve.quantity != "position":
        marks.append((0.0, "#d5dade", "none"))
    lines = "".join(
        f'<line x1="0" x2="100" y1="{y:.1f}" y2="{y:.1f}" stroke="{stroke}" stroke-width="1" '
        f'stroke-dasharray="{dashes}" vector-effect="non-scaling-stroke"/>'
        for y, stroke, dashes in ((100 * (top - at) / (top - bottom), stroke, dashes) for at, stroke, dashes in marks)
        if 0 <= y <= 100
    )
    return (
        f'<div style="height:{_HEAD_PX}px;line-height:{_HEAD_PX}px;display:flex;justify-content:space-between">'
        f'<span style="color:{colour};font-weight:600">{escape(curve.name)}</span>'
        f'<span style="color:{to_hex(COLLIDING if curve.use > 1.0 + 1e-3 else QUIET)}">{escape(curve.summary)}</span>'
        '</div><svg viewBox="0 0 100 100" preserveAspectRatio="none" style="display:block;width:100%;'
        f'height:{_PLOT_PX}px;margin-bottom:{_FOOT_PX}px;background:#f6f7f8">{lines}'
        f'<polygon points="{corners}" fill="{colour}" stroke="{colour}" stroke-width="1" stroke-linejoin="round" '
        'vector-effect="non-scaling-stroke"/></svg>'
    )
