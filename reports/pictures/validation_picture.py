"""What was published against what the model predicts, a panel for each reference."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reports.cards.validation import row_names, validation_words
from reports.pictures.sheet import ACCENT, FAINT, FUNCTION_COLOURS, INK, QUIET, TOP_MM, open_sheet

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from cleaning.validation.compare import Comparison

_COLUMNS = 3
_WIDTH_MM, _PANEL_MM, _BOTTOM_MM = 300.0, 74.0, 40.0
_DECADE = 10.0
_LONGEST = 32
_GREEN = FUNCTION_COLOURS[1]


def draw_validation(found: Sequence[Comparison], suffix: str) -> bytes:
    """Draw every reference; the same comparisons give the same bytes.

    Args:
        found: All comparisons.
        suffix: ``.png`` or ``.svg``.
    """
    rows = math.ceil(len(found) / _COLUMNS)
    title = ("The model against what was published", validation_words(found))
    foot = "rings: published, of a law where the panel names one; dots: predicted, with their range; a row a place"
    height = TOP_MM + rows * _PANEL_MM + _BOTTOM_MM
    with open_sheet(suffix, height, _WIDTH_MM, title=title, foot=foot) as sheet:
        panels = sheet.panels(len(found), min(len(found), _COLUMNS), _BOTTOM_MM, (0.22, 1.0))
        for axes, each in zip(panels, found, strict=True):
            _draw(axes, each)
        return sheet.content()


def _draw(axes: Axes, each: Comparison) -> None:
    rows, predicted, low, high = each.compared
    places = np.arange(len(rows.labels))
    values = np.concatenate([rows.published, predicted, low, high])
    known = values[np.isfinite(values)]
    if known.min() > 0.0 and known.max() > _DECADE * known.min():
        axes.set_yscale("log")
        for ticks in (axes.yaxis.set_major_formatter, axes.yaxis.set_minor_formatter):
            ticks(_plain)
    else:
        axes.yaxis.set_major_formatter(_short_number)
        axes.set_ylim(min(-0.04 * float(known.max()), 1.1 * float(known.min())), 1.12 * float(known.max()))
    for at in np.flatnonzero(np.isfinite(low) & (high > low)):
        axes.plot([at, at], [low[at], high[at]], color=FAINT, linewidth=3.0, zorder=1)
    axes.plot(places, rows.published, "o", markersize=6, markerfacecolor="none", color=INK, zorder=3)
    axes.plot(places, predicted, "o", markersize=3.2, color=ACCENT, zorder=4)
    axes.set_xticks(places, [_short(name) for name in row_names(rows)], rotation=90, fontsize=6)
    axes.set_xlim(-0.6, len(places) - 0.4)
    axes.tick_params(length=2, colors=QUIET)
    axes.text(0.0, 1.03, each.quantity.words, transform=axes.transAxes, fontsize=5.5, color=QUIET)
    colour = {"holds": _GREEN, "expected failure": QUIET}.get(each.standing, ACCENT)
    law = " (law)" * (each.reference.holds == "law")
    axes.set_title(f"{each.reference.reference}{law}: {each.standing}", fontsize=8, loc="left", color=colour, pad=11)


def _plain(value: float, _: float) -> str:
    """Numbers of a logarithmic scale, those that begin with 1, 2 and 5."""
    return f"{value:g}" if f"{value:e}"[0] in "125" else ""


def _short_number(value: float, _: float) -> str:
    """Numbers of a linear scale, each with its power of ten."""
    return f"{value:.6g}"


def _short(label: str) -> str:
    return label if len(label) <= _LONGEST else f"{label[: _LONGEST - 1]}…"
