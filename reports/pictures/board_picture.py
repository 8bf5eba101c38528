"""A picture of a board: what was understood of it."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from boards.board import Board, Side
from reports.pictures.sheet import (
    ACCENT,
    INK,
    LEFT_MM,
    SHEET_MM,
    SIDES,
    TOP_MM,
    add_panels,
    arrange,
    check_suffix,
    components_of,
    draw_outlines,
    draw_scale_bar,
    frame_board,
    sheet,
    to_bytes,
    view_of,
    write_foot,
    write_names,
    write_title,
)
from specs.finding import Finding, worst_first

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LISTED_FINDINGS = 9
_SCALE_MM = 36.0
"""Room for the scale of heights at the right."""


def draw_board(board: Board, suffix: str) -> bytes:
    """Draw what was understood of a board: its outline, its components by height, its findings.

    Args:
        board: The board.
        suffix: ``.png`` or ``.svg``.

    Raises:
        JobError: another suffix.
    """
    check_suffix(suffix)
    sides: list[Side] = [side for side in SIDES if components_of(board, side)] or ["top"]
    tallest = max((component.height_mm for component in board.components), default=1.0)
    view = view_of(board)
    width_mm = SHEET_MM[0] - LEFT_MM - _SCALE_MM
    lines, places = _list_findings(board.findings)
    foot_mm = 16.0 + 3.6 * len(lines)
    layout = arrange(len(sides), view, width_mm, SHEET_MM[1] - TOP_MM - foot_mm)
    height_mm = TOP_MM + layout.height_mm + foot_mm
    with sheet(height_mm) as figure:
        x0, y0, x1, y1 = board.outline.bounds
        counts = ", ".join(f"{len(components_of(board, side))} on the {side}" for side in sides)
        write_title(
            figure,
            board.name,
            f"{x1 - x0:.1f} x {y1 - y0:.1f} mm    {board.top_z_mm - board.bottom_z_mm:.2f} mm thick    "
            f"{len(board.components)} components: {counts}",
        )
        panels = add_panels(
            figure, len(sides), layout.columns, bottom_mm=foot_mm + 6, right_mm=_SCALE_MM, spaces=(0.03, 0.12)
        )
        for axes, side in zip(panels, sides, strict=True):
            frame_board(axes, view)
            _draw_side(axes, board, side, tallest)
            for number, (x, y, _) in enumerate(places, start=1):
                axes.plot(x, y, marker="o", markersize=11, markerfacecolor="none", markeredgecolor=ACCENT, zorder=8)
                axes.text(x, y, f"   {number}", color=ACCENT, fontsize=7, va="center", zorder=8, clip_on=True)
        bottom, top = (foot_mm + 6) / height_mm, 1 - TOP_MM / height_mm
        scale = figure.add_axes((1 - 0.7 * _SCALE_MM / SHEET_MM[0], bottom, 0.010, top - bottom))
        _draw_height_scale(scale, tallest)
        place = (LEFT_MM / SHEET_MM[0], foot_mm / height_mm)
        figure.text(*place, "\n".join(lines), fontsize=7, va="top", linespacing=1.35)
        write_foot(figure, f"board sha256 {board.sha256[:16]}    both sides as seen from the top")
        return to_bytes(figure, suffix)


def _draw_side(axes: Axes, board: Board, side: Side, tallest: float) -> None:
    from matplotlib import colormaps

    components = components_of(board, side)
    shade = colormaps["YlGnBu"]
    levels = [0.08 + 0.80 * component.height_mm / tallest for component in components]
    draw_outlines(axes, board, side, [shade(level) for level in levels])
    write_names(axes, components, ["white" if level > 0.55 else INK for level in levels])
    draw_scale_bar(axes)
    axes.set_title(f"{side}, {len(components)} components", loc="left", fontsize=11, fontweight="bold")


def _draw_height_scale(axes: Axes, tallest: float) -> None:
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    used = ListedColormap(colormaps["YlGnBu"](np.linspace(0.08, 0.88, 256)))
    scale = axes.figure.colorbar(ScalarMappable(Normalize(0, tallest), used), cax=axes)
    scale.set_label("height, mm")
    axes.spines[:].set_visible(False)


def _list_findings(findings: Sequence[Finding]) -> tuple[list[str], list[tuple[float, float, float]]]:
    """Lines that list the findings, worst first, those with a place numbered; and these places."""
    lines: list[str] = []
    places: list[tuple[float, float, float]] = []
    for finding in worst_first(findings)[:_LISTED_FINDINGS]:
        number = ""
        if finding.where is not None:
            places.append(finding.where)
            number = f"({len(places)}) "
        lines += wrap(f"{number}{finding.severity}: {finding.message}", 230, subsequent_indent="      ")
    if len(findings) > _LISTED_FINDINGS:
        lines.append(f"and {len(findings) - _LISTED_FINDINGS} more")
    return lines, places
