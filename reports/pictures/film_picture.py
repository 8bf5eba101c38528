"""Pictures of films: the ripple of parallel passes over their spacing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.coverage.spacing import overlap
from reports.pictures.sheet import (
    ACCENT,
    FAINT,
    FUNCTION_COLOURS,
    INK,
    QUIET,
    TOP_MM,
    add_panels,
    sheet,
    to_bytes,
    write_foot,
    write_title,
)
from rulesengine.levelling.pass_spacing import AllowedSpacing, SpacingTable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PANEL_MM, _BOTTOM_MM = 105.0, 24.0
_CURVE = 600
_LABEL_PCT = 20.0


def draw_spacings(table: SpacingTable, suffix: str) -> bytes:
    """Draw the ripple over the spacing with its valleys, and the film across the passes of the best and the widest.

    Args:
        table: The valleys.
        suffix: ``.png`` or ``.svg``.
    """
    shown = [each for each in dict.fromkeys((table.best, *table.valleys[:1])) if each is not None]
    with sheet(TOP_MM + _PANEL_MM + _BOTTOM_MM) as figure:
        panels = add_panels(figure, 2, 2, bottom_mm=_BOTTOM_MM, spaces=(0.15, 0.2))
        _draw_ripple(panels[0], table)
        for each, colour in zip(shown, FUNCTION_COLOURS, strict=False):
            _draw_film(panels[1], table, each, colour)
        panels[1].axhline(table.film_um, color=FAINT, linewidth=0.8)
        panels[1].set_xlabel("across the passes, mm")
        panels[1].set_ylabel("film, µm")
        if shown:
            panels[1].legend(fontsize=7, frameon=False, loc="lower right")
        write_title(
            figure,
            f"Spacing of passes, {table.nozzle} from {table.height_mm:g} mm",
            f"{table.film_um:g} µm at {table.flow_lpm:.4g} l/min; at most {table.max_speed_mm_s:g} mm/s",
        )
        write_foot(figure, "ripple: (max - min) / (max + min) of endless parallel passes over a flat plate")
        return to_bytes(figure, suffix)


def _draw_ripple(axes: Axes, table: SpacingTable) -> None:
    wet = np.abs(table.across_mm[table.film_um_mm_s > 0.0])
    widest = 2.0 * float(wet.max()) if wet.size else 1.0
    narrowest = min((each.spacing.spacing for each in table.valleys), default=0.3 * widest)
    spacings = np.linspace(0.8 * narrowest, widest, _CURVE)
    found = [overlap(table.across_mm, table.film_um_mm_s, float(each)) for each in spacings]
    speeds = np.array([each.middle for each in found]) / table.film_um
    axes.plot(spacings, [100.0 * each.ripple for each in found], color=INK, linewidth=1.0)
    fast = spacings[speeds > table.max_speed_mm_s]
    if fast.size:
        axes.axvspan(float(spacings[0]), float(fast.max()), color=FAINT, alpha=0.35, linewidth=0)
        axes.text(float(spacings[0]), 29.0, " too fast", color=QUIET, fontsize=7)
    for each in table.valleys:
        place = each.spacing.spacing, 100.0 * each.spacing.ripple
        axes.plot(*place, "o", color=ACCENT if each.allowed else QUIET, markersize=4)
        if each.allowed:
            label = f"{place[0]:.2f} mm\n±{place[1]:.2f} %\n{each.speed_mm_s:.0f} mm/s"
            axes.vlines(place[0], place[1], _LABEL_PCT, color=FAINT, linewidth=0.6)
            axes.annotate(label, (place[0], _LABEL_PCT), (0, 2), textcoords="offset points", fontsize=6.5, ha="center")
    axes.set_ylim(0.0, 31.0)
    axes.set_xlabel("spacing, mm")
    axes.set_ylabel("ripple, ± %")


def _draw_film(axes: Axes, table: SpacingTable, each: AllowedSpacing, colour: str) -> None:
    """Three spacings of the sum, and the passes that make it."""
    spacing, speed = each.spacing.spacing, each.speed_mm_s
    across = np.linspace(-1.5 * spacing, 1.5 * spacing, _CURVE)
    reach = int(np.ceil(table.across_mm[-1] / spacing)) + 2
    passes = [
        np.interp(across - at * spacing, table.across_mm, table.film_um_mm_s / speed, left=0.0, right=0.0)
        for at in range(-reach, reach + 1)
    ]
    for film in passes:
        axes.plot(across, film, color=colour, linewidth=0.4, alpha=0.6)
    label = f"{spacing:.2f} mm, {speed:.0f} mm/s"
    axes.plot(across, np.sum(passes, axis=0), color=colour, linewidth=1.4, label=label)
