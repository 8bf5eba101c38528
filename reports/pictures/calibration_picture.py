"""Pictures of calibrations: what was measured against what was fitted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cleaning.calibration.fit_kinetics import GapFit
from cleaning.calibration.fit_pattern import PatternFit
from cleaning.calibration.fit_ring import RingFit
from cleaning.calibration.spray_patterns import meet, places, sheet_of
from geometry.arrays import Indices
from recipes.footprint import RING_EDGE_SIGMAS
from reports.pictures.sheet import (
    ACCENT,
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

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PANEL_MM = 95.0
_BOTTOM_MM = 20.0
_COLUMNS = 4
_SYNTHETIC = "SYNTHETIC data. "


def draw_ring(fit: RingFit, suffix: str) -> bytes:
    """Draw every sheet as seen from the nozzle, with the fitted ring; the same fit gives the same bytes.

    Args:
        fit: The ring.
        suffix: ``.png`` or ``.svg``.
    """
    keys, sheets = sheet_of(fit.measurements)
    azimuth = np.linspace(0.0, 2 * np.pi, 181)
    with sheet(_height_mm(len(keys))) as figure:
        for index, (axes, key) in enumerate(zip(_panels(figure, len(keys)), keys, strict=True)):
            _draw_sheet(axes, fit, np.flatnonzero(sheets == index))
            for sigmas, width in ((-RING_EDGE_SIGMAS, 0.8), (0.0, 0.4), (RING_EDGE_SIGMAS, 0.8)):
                polar = fit.middle(azimuth) + sigmas * math.radians(fit.sigma_deg.value)
                x, y = meet(key[0], math.radians(key[1]), polar, azimuth)
                axes.plot(x, y, color=ACCENT, linewidth=width)
            axes.set_title(f"{key[0]:g} mm, tilted {key[1]:g}°", fontsize=8, loc="left")
            axes.set_aspect("equal", adjustable="datalim")
            axes.invert_yaxis()  # azimuths grow clockwise as seen from the nozzle
        angle, sigma = fit.half_angle_deg, fit.sigma_deg
        write_title(
            figure,
            f"Half angle {angle.value:.2f}°, sigma {sigma.value:.2f}°",
            f"{_SYNTHETIC * fit.measurements.synthetic}{len(fit.measurements)} rows, rms {fit.rms:.3g} {fit.unit}; "
            f"half angle {angle.low:.2f}° to {angle.high:.2f}°, sigma {sigma.low:.2f}° to {sigma.high:.2f}° (95 %)",
        )
        write_foot(
            figure, f"{fit.measurements.source}; mm from where the axis meets the sheet; the nozzle leans towards +x"
        )
        return to_bytes(figure, suffix)


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
    with sheet(_height_mm(1)) as figure:
        axes = _panels(figure, 1)[0]
        keys, sheets = sheet_of(fit.measurements)
        for index, (height, tilt) in enumerate(keys):
            rows = sheets == index
            colour = FUNCTION_COLOURS[index % len(FUNCTION_COLOURS)]
            label = f"{height:g} mm, tilted {tilt:g}°"
            axes.plot(fit.measured_radius_mm[rows], fit.measured[rows], "o", color=colour, markersize=2.5, label=label)
        axes.plot(fit.radius_mm, fit.flux, color=ACCENT, linewidth=1.2)
        axes.set_xlim(0.0, 1.15 * float(fit.radius_mm[-1]))
        axes.set_ylim(-0.05, 1.2)
        axes.legend(fontsize=6, frameon=False)
        synthetic = _SYNTHETIC * fit.measurements.synthetic
        flow = "" if fit.flow_lpm is None else f"; {fit.flow_lpm:.4g} l/min landed"
        write_title(
            figure,
            f"Radius {fit.radius_mm[-1]:.2f} mm at {fit.at_mm:g} mm",
            f"{synthetic}{len(fit.measurements)} rows, rms {fit.rms:.3g} of the peak{flow}",
        )
        write_foot(figure, f"{fit.measurements.source}; flux relative to the peak over the radius on the plate in mm")
        return to_bytes(figure, suffix)


def draw_gap(fit: GapFit, suffix: str) -> bytes:
    """Draw what was cleaned over the time, a panel for each temperature and pressure, a colour for each standoff.

    Args:
        fit: The kinetics.
        suffix: ``.png`` or ``.svg``.
    """
    columns = fit.coupons.measurements.columns
    keys = sorted(set(zip(columns["temperature_c"].tolist(), columns["pressure_bar"].tolist(), strict=True)))
    standoffs = sorted(set(columns["standoff_um"].tolist()))
    with sheet(_height_mm(len(keys))) as figure:
        for axes, (celsius, bar) in zip(_panels(figure, len(keys)), keys, strict=True):
            here = (columns["temperature_c"] == celsius) & (columns["pressure_bar"] == bar)
            for index, standoff in enumerate(standoffs):
                rows = np.flatnonzero(here & (columns["standoff_um"] == standoff))
                colour = FUNCTION_COLOURS[index % len(FUNCTION_COLOURS)]
                times = columns["time_s"][rows]
                order = np.argsort(times, kind="stable")
                axes.plot(times[order], fit.predicted[rows][order], color=colour, linewidth=0.9)
                label = f"{standoff:g} µm"
                axes.plot(times, fit.coupons.cleaned[rows], "o", color=colour, markersize=3.0, label=label)
            axes.set_ylim(-0.04, 1.04)
            axes.set_title(f"{celsius:g} °C, {bar:g} bar", fontsize=8, loc="left")
            axes.legend(fontsize=6, frameon=False)
        fitted = ", ".join(f"{name.partition('.')[2]} {each.value:.3g}" for name, each in fit.estimates.items())
        synthetic = _SYNTHETIC * fit.coupons.measurements.synthetic
        write_title(
            figure, "Cleaned under coupons", f"{synthetic}{len(fit.predicted)} rows, rms {fit.rms:.3g}; {fitted}"
        )
        write_foot(figure, f"{fit.coupons.measurements.source}; share that was cleaned over time in s; lines: fitted")
        return to_bytes(figure, suffix)


def _height_mm(panels: int) -> float:
    return TOP_MM + math.ceil(panels / _COLUMNS) * _PANEL_MM + _BOTTOM_MM


def _panels(figure: Figure, count: int) -> list[Axes]:
    panels = add_panels(figure, count, min(count, _COLUMNS), bottom_mm=_BOTTOM_MM, spaces=(0.2, 0.25))
    for axes in panels:
        axes.tick_params(length=2, colors=QUIET)
    return panels
