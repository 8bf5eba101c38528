"""Charts: what was measured against what was fitted, the ripple of passes over their spacing, recipes of a tuning."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from cleaning.calibration.measurements import meet, places, sheet_of
from geometry.coverage.spacing import overlap
from recipes.footprint import RING_EDGE_SIGMAS
from reports.pictures.sheet import ACCENT, FAINT, FUNCTION_COLOURS, INK, QUIET, TOP_MM, Picture, Sheet, open_sheet
from reports.tables.wording import clock
from rulesengine.tuning.trial.request import pareto_front

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from matplotlib.axes import Axes

    from cleaning.calibration.fit_kinetics import GapFit
    from cleaning.calibration.fit_spray import PatternFit, RingFit
    from geometry.arrays import Indices
    from rulesengine.levelling.pass_spacing import AllowedSpacing, SpacingTable
    from rulesengine.tuning.trial.request import Trial, TuningResult

_PANEL_MM = 95.0
_BOTTOM_MM = 20.0
_COLUMNS = 4
_SYNTHETIC = "SYNTHETIC data. "
_SPACING_MM, _SPACING_BOTTOM_MM = 105.0, 24.0
_CURVE = 600
_LABEL_PCT = 20.0
_TUNING_WIDTH_MM, _TUNING_HEIGHT_MM, _TUNING_BOTTOM_MM = 260.0, 118.0, 24.0
_MINUTE_S = 60.0
_ROOM = 0.06


def draw_ring(fit: RingFit, suffix: str) -> bytes:
    """Draw every sheet as seen from the nozzle, with the fitted ring; the same fit gives the same bytes.

    Args:
        fit: The ring.
        suffix: ``.png`` or ``.svg``.
    """
    keys, sheets = sheet_of(fit.measurements)
    azimuth = np.linspace(0.0, 2 * np.pi, 181)
    angle, sigma = fit.half_angle_deg, fit.sigma_deg
    title = (
        f"Half angle {angle.value:.2f}°, sigma {sigma.value:.2f}°",
        f"{_SYNTHETIC * fit.measurements.synthetic}{len(fit.measurements)} rows, rms {fit.rms:.3g} {fit.unit}; "
        f"half angle {angle.low:.2f}° to {angle.high:.2f}°, sigma {sigma.low:.2f}° to {sigma.high:.2f}° (95 %)",
    )
    foot = f"{fit.measurements.source}; mm from where the axis meets the sheet; the nozzle leans towards +x"
    with open_sheet(suffix, _height_mm(len(keys)), title=title, foot=foot) as sheet:
        for index, (axes, key) in enumerate(zip(_panels(sheet, len(keys)), keys, strict=True)):
            _draw_sheet(axes, fit, np.flatnonzero(sheets == index))
            for sigmas, width in ((-RING_EDGE_SIGMAS, 0.8), (0.0, 0.4), (RING_EDGE_SIGMAS, 0.8)):
                polar = fit.middle(azimuth) + sigmas * math.radians(sigma.value)
                axes.plot(*meet(key[0], math.radians(key[1]), polar, azimuth), color=ACCENT, linewidth=width)
            axes.set_title(f"{key[0]:g} mm, tilted {key[1]:g}°", fontsize=8, loc="left")
            axes.set_aspect("equal", adjustable="datalim")
            axes.invert_yaxis()  # azimuths grow clockwise as seen from the nozzle
        return sheet.content()


def _draw_sheet(axes: Axes, fit: RingFit, rows: Indices) -> None:
    columns = fit.measurements.columns
    if "intensity" in columns:
        around = (columns["x_mm"], columns["y_mm"]) if "x_mm" in columns else None
        x, y = around or places(fit.measurements, columns["radius_mm"])
        axes.scatter(x[rows], y[rows], c=columns["intensity"][rows], cmap="Blues", s=9, linewidths=0)
        return
    for name in ("inner_mm", "outer_mm"):
        x, y = places(fit.measurements, columns[name])
        axes.plot(x[rows], y[rows], "o", color=INK, markersize=2.2)


def draw_pattern(fit: PatternFit, suffix: str) -> bytes:
    """Draw the flux over the radius on the plate: what was measured, projected on it, and the fitted profile.

    Args:
        fit: The profile.
        suffix: ``.png`` or ``.svg``.
    """
    flow = "" if fit.flow_lpm is None else f"; {fit.flow_lpm:.4g} l/min landed"
    rows = f"{_SYNTHETIC * fit.measurements.synthetic}{len(fit.measurements)} rows"
    title = (f"Radius {fit.radius_mm[-1]:.2f} mm at {fit.at_mm:g} mm", f"{rows}, rms {fit.rms:.3g} of the peak{flow}")
    foot = f"{fit.measurements.source}; flux relative to the peak over the radius on the plate in mm"
    with open_sheet(suffix, _height_mm(1), title=title, foot=foot) as sheet:
        axes = _panels(sheet, 1)[0]
        keys, sheets = sheet_of(fit.measurements)
        for index, (height, tilt) in enumerate(keys):
            radii, flux = fit.measured_radius_mm[sheets == index], fit.measured[sheets == index]
            label = f"{height:g} mm, tilted {tilt:g}°"
            axes.plot(radii, flux, "o", color=_colour(index), markersize=2.5, label=label)
        axes.plot(fit.radius_mm, fit.flux, color=ACCENT, linewidth=1.2)
        axes.set_xlim(0.0, 1.15 * float(fit.radius_mm[-1]))
        axes.set_ylim(-0.05, 1.2)
        axes.legend(fontsize=6, frameon=False)
        return sheet.content()


def draw_gap(fit: GapFit, suffix: str) -> bytes:
    """Draw what was cleaned over the time, a panel for each temperature and pressure, a colour for each standoff.

    Args:
        fit: The kinetics.
        suffix: ``.png`` or ``.svg``.
    """
    columns = fit.coupons.measurements.columns
    keys = sorted(set(zip(columns["temperature_c"].tolist(), columns["pressure_bar"].tolist(), strict=True)))
    standoffs = sorted(set(columns["standoff_um"].tolist()))
    fitted = ", ".join(f"{name.partition('.')[2]} {each.value:.3g}" for name, each in fit.estimates.items())
    measurements = fit.coupons.measurements
    counted = f"{_SYNTHETIC * measurements.synthetic}{len(fit.predicted)} rows"
    title = ("Cleaned under coupons", f"{counted}, rms {fit.rms:.3g}; {fitted}")
    foot = f"{measurements.source}; share that was cleaned over time in s; lines: fitted"
    with open_sheet(suffix, _height_mm(len(keys)), title=title, foot=foot) as sheet:
        for axes, (celsius, bar) in zip(_panels(sheet, len(keys)), keys, strict=True):
            here = (columns["temperature_c"] == celsius) & (columns["pressure_bar"] == bar)
            for index, standoff in enumerate(standoffs):
                rows = np.flatnonzero(here & (columns["standoff_um"] == standoff))
                times, colour, label = columns["time_s"][rows], _colour(index), f"{standoff:g} µm"
                order = np.argsort(times, kind="stable")
                axes.plot(times[order], fit.predicted[rows][order], color=colour, linewidth=0.9)
                axes.plot(times, fit.coupons.cleaned[rows], "o", color=colour, markersize=3.0, label=label)
            axes.set_ylim(-0.04, 1.04)
            axes.set_title(f"{celsius:g} °C, {bar:g} bar", fontsize=8, loc="left")
            axes.legend(fontsize=6, frameon=False)
        return sheet.content()


def _colour(index: int) -> str:
    return FUNCTION_COLOURS[index % len(FUNCTION_COLOURS)]


def _height_mm(panels: int) -> float:
    return TOP_MM + math.ceil(panels / _COLUMNS) * _PANEL_MM + _BOTTOM_MM


def _panels(sheet: Sheet, count: int) -> list[Axes]:
    panels = sheet.panels(count, min(count, _COLUMNS), _BOTTOM_MM, (0.2, 0.25))
    for axes in panels:
        axes.tick_params(length=2, colors=QUIET)
    return panels


def draw_spacings(table: SpacingTable, suffix: str) -> bytes:
    """Draw the ripple over the spacing with its valleys, and the film across the passes of the best and the widest.

    Args:
        table: The valleys.
        suffix: ``.png`` or ``.svg``.
    """
    shown = [each for each in dict.fromkeys((table.best, *table.valleys[:1])) if each is not None]
    title = (
        f"Spacing of passes, {table.nozzle} from {table.height_mm:g} mm",
        f"{table.film_um:g} µm at {table.flow_lpm:.4g} l/min; at most {table.max_speed_mm_s:g} mm/s",
    )
    foot = "ripple: (max - min) / (max + min) of endless parallel passes over a flat plate"
    with open_sheet(suffix, TOP_MM + _SPACING_MM + _SPACING_BOTTOM_MM, title=title, foot=foot) as sheet:
        ripple, film = sheet.panels(2, 2, _SPACING_BOTTOM_MM, (0.15, 0.2))
        _draw_ripple(ripple, table)
        for each, colour in zip(shown, FUNCTION_COLOURS, strict=False):
            _draw_film(film, table, each, colour)
        film.axhline(table.film_um, color=FAINT, linewidth=0.8)
        film.set_xlabel("across the passes, mm")
        film.set_ylabel("film, µm")
        if shown:
            film.legend(fontsize=7, frameon=False, loc="lower right")
        return sheet.content()


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


def draw_tuning(tuned: TuningResult, suffix: str, chosen: str = "") -> bytes:
    """Draw what was analysed: clean components, liquid and margin over the time of the program.

    The same result gives the same bytes.

    Args:
        tuned: The result.
        suffix: ``.png`` or ``.svg``.
        chosen: Text of the recipe that is marked; empty for the result's own.
    """
    front = pareto_front(tuned.trials)
    mark = next((each for each in tuned.trials if each.text == (chosen or tuned.last.text)), None)
    total = tuned.last.total
    title = (f"{len(tuned.trials)} recipes, {len(front)} on the Pareto front", _chosen_words(mark, total))
    foot = (
        "numbers: Pareto front, no other recipe is as good in time, liquid and cleanliness; red: chosen"
        "\nring: as it was; margin: least amount or time over what a clean verdict needs, 0: not met; predictions"
    )
    with open_sheet(suffix, _TUNING_HEIGHT_MM, _TUNING_WIDTH_MM, title=title, foot=foot) as sheet:
        clean, liquid, margin = sheet.panels(3, 3, _TUNING_BOTTOM_MM, (0.2, 0.2))
        drawn = _Drawn(tuned.trials, {id(each): number for number, each in enumerate(front, 1)}, mark, tuned.trials[0])
        _draw_trials(clean, drawn, lambda trial: float(trial.figures.clean_components))
        clean.set_title("clean components of all recipes", fontsize=9, loc="left")
        clean.set_ylim(-_ROOM * total, (1 + _ROOM) * total)
        clean.axhline(total, color=FAINT, linewidth=0.6, zorder=0)
        cleanest = max((each.figures.clean_components for each in tuned.trials), default=0)
        near = replace(drawn, trials=[each for each in tuned.trials if each.figures.clean_components == cleanest])
        _draw_trials(liquid, near, lambda trial: trial.figures.litres)
        liquid.set_title(f"liquid, l, of those with {cleanest} clean components", fontsize=9, loc="left")
        met = [each for each in near.trials if each.margin]
        _draw_trials(margin, replace(near, trials=met or near.trials), lambda trial: trial.margin)
        margin.set_title("least margin of those, where all is met", fontsize=9, loc="left")
        return sheet.content()


@dataclass(frozen=True, slots=True)
class _Drawn:
    """Recipes that a panel shows."""

    trials: Sequence[Trial]
    numbers: Mapping[int, int]
    """Of those on the front, by identity."""
    mark: Trial | None
    first: Trial


def picture_of_tuning(tuned: TuningResult, chosen: str = "") -> Picture:
    """Draw a tuning for a page."""
    return Picture(".svg", draw_tuning(tuned, ".svg", chosen), "Recipes by time, liquid and clean components")


def _chosen_words(mark: Trial | None, total: int) -> str:
    if mark is None:
        return "predicted by the cleaning model"
    figures, margin = mark.figures, f", margin {mark.margin:.2f}" if mark.margin else ""
    clean = f"{figures.clean_components} of {total} clean"
    return f"chosen: {clean}{margin}, {clock(figures.seconds)}, {figures.litres:.1f} l"


def _draw_trials(axes: Axes, drawn: _Drawn, value: Callable[[Trial], float]) -> None:
    for each in drawn.trials:
        place = each.figures.seconds / _MINUTE_S, value(each)
        number = drawn.numbers.get(id(each))
        colour, size = (FAINT, 4) if number is None else (FUNCTION_COLOURS[0], 5)
        axes.plot(*place, "o", color=colour, markersize=size, zorder=1 if number is None else 2)
        if number is not None:
            axes.annotate(str(number), place, (3, 3), textcoords="offset points", fontsize=7, color=INK, zorder=4)
        if each is drawn.first:
            axes.plot(*place, "o", markersize=9, markerfacecolor="none", color=QUIET, zorder=3)
        if each is drawn.mark:
            axes.plot(*place, "o", color=ACCENT, markersize=7, zorder=3)
    axes.set_xlabel("program, min")
    axes.grid(visible=True, color=FAINT, linewidth=0.3, alpha=0.6)
    axes.tick_params(length=2)
    axes.margins(_ROOM)
