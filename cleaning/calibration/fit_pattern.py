"""Fitting the radial profile of a round jet to spray patterns that were measured on flat sheets.

What a sheet gets follows from the profile on a plate at one distance by the solid angle (Jiangsu 2010, eq. (4), with
its exponent corrected), so that sheets at several distances and tilts are one linear least-squares problem.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from cleaning.calibration.measurements import Column, Measurements, read_measurements
from cleaning.calibration.spray_patterns import Rays, places, rays_to, sheet_of
from geometry.arrays import Scalars

_LENGTH = 2000.0
_COLUMNS: Mapping[str, Column] = {
    "height_mm": Column(1.0, 1000.0),
    "tilt_deg": Column(0.0, 80.0, default=0.0),
    "azimuth_deg": Column(-360.0, 360.0, default=0.0),
    "radius_mm": Column(0.0, _LENGTH, optional=True),
    "x_mm": Column(-_LENGTH, _LENGTH, optional=True),
    "y_mm": Column(-_LENGTH, _LENGTH, optional=True),
    "film_um": Column(0.0, 1e9),
    "time_s": Column(1e-3, 1e5, optional=True),
}
_LEAST_ROWS = 8
_FEWEST, _MOST = 5, 21
"""Nodes of a profile."""
_EDGE = 0.02
"""Share of the peak above which a place lies within the pattern."""
_SMOOTHNESS = 0.02
"""Weight of the second differences: it bridges nodes between which nothing was measured."""


@dataclass(frozen=True, slots=True, eq=False)
class PatternFit:
    """A fitted radial profile."""

    measurements: Measurements
    at_mm: float
    """Distance of the plate: the least that was measured."""
    radius_mm: Scalars
    """(k,) from 0 to the edge of the pattern, evenly spaced."""
    flux: Scalars
    """(k,) relative to the peak."""
    flow_lpm: float | None
    """What landed; ``None`` where no times were measured."""
    rms: float
    """Of what is left, relative to the peak."""
    measured_radius_mm: Scalars
    """(n,) of the places, projected on the plate."""
    measured: Scalars
    """(n,) flux there, projected likewise, relative to the peak."""


def calibrate_pattern(path: Path) -> PatternFit:
    """Fit a radial profile to a table of film thickness by place.

    Args:
        path: CSV with height_mm, radius_mm (or x_mm and y_mm), film_um and where known time_s.

    Raises:
        CleaningError: the table cannot be used, or ends within the pattern.
    """
    sheets = read_measurements(path, _COLUMNS, _LEAST_ROWS)
    columns = sheets.columns
    if ("x_mm" in columns and "y_mm" in columns) == ("radius_mm" in columns):
        raise sheets.error("films need places: either radius_mm, or x_mm and y_mm")
    flat = (columns["x_mm"], columns["y_mm"]) if "x_mm" in columns else places(sheets, columns["radius_mm"])
    rays = rays_to(sheets, *flat)
    at_mm = float(columns["height_mm"].min())
    gain = _plate_gain(rays, at_mm)
    rate = columns["film_um"] / columns.get("time_s", np.ones(len(sheets)))
    # Projected on the plate, all sheets show one curve; where the gain is tiny a place weighs little.
    plate = np.where(gain > 0.0, rate / np.maximum(gain, 1e-12), 0.0)
    slope = np.tan(np.minimum(rays.polar, np.radians(89.0)))
    edge = _edge_of(sheets, slope, plate)
    nodes = np.linspace(0.0, edge, int(np.clip(len(np.unique(np.round(slope, 4))) // 2, _FEWEST, _MOST)))
    profile, rms = _solve(_hats(slope, nodes) * gain[:, None], rate)
    peak = float(profile.max())
    return PatternFit(
        measurements=sheets,
        at_mm=at_mm,
        radius_mm=nodes * at_mm,
        flux=profile / peak,
        flow_lpm=_flow_lpm(nodes * at_mm, profile) if "time_s" in columns else None,
        rms=rms / peak,
        measured_radius_mm=slope * at_mm,
        measured=plate / peak,
    )


def pattern_text(fit: PatternFit) -> str:
    """Write the profile as the lines of a nozzle, with a comment on where it comes from."""
    made_up = "SYNTHETIC data, proves nothing: " if fit.measurements.synthetic else ""
    lines = [
        f"# {made_up}fitted to {fit.measurements.source}: {len(fit.measurements)} rows, rms {fit.rms:.3g} of the peak.",
        "pattern: radial",
        f"radius_mm: {round(float(fit.radius_mm[-1]), 2):g}",
        f"at_mm: {fit.at_mm:g}",
        "profile:",
    ]
    pairs = zip(np.round(fit.radius_mm, 2).tolist(), np.round(fit.flux, 4).tolist(), strict=True)
    lines += [f"  - [{radius:g}, {flux:g}]" for radius, flux in pairs]
    if fit.flow_lpm is not None:
        lines.append(f"flow_lpm: {fit.flow_lpm:.4g}")
    return "\n".join(lines) + "\n"


def sheet_rms(fit: PatternFit) -> list[tuple[float, float, int, float]]:
    """Height, tilt, rows and rms of what is left, relative to the peak and projected on the plate, of each sheet."""
    keys, sheet = sheet_of(fit.measurements)
    left = fit.measured - np.interp(fit.measured_radius_mm, fit.radius_mm, fit.flux, right=0.0)
    each = [left[sheet == index] for index in range(len(keys))]
    return [(*key, len(rows), float(np.sqrt(np.mean(rows**2)))) for key, rows in zip(keys, each, strict=True)]


def _plate_gain(rays: Rays, at_mm: float) -> Scalars:
    """(n,) what a place on a sheet gets per flux where its ray meets the plate: (h / l)² cos(alpha) / cos³(theta)."""
    along = np.cos(rays.polar)
    return np.where(along > 1e-3, (at_mm / rays.length) ** 2 * rays.incidence_cosine / np.maximum(along, 1e-3) ** 3, 0)


def _edge_of(sheets: Measurements, slope: Scalars, plate: Scalars) -> float:
    """Tangent of the angle to the edge: halfway between the last place within the pattern and the next.

    Raises:
        CleaningError: nothing was sprayed, or the outermost place still lies within the pattern.
    """
    if float(plate.max()) <= 0.0:
        raise sheets.error("no film is above 0", "film_um", 0)
    within = plate > _EDGE * float(plate.max())
    last = float(slope[within].max())
    beyond = slope[slope > last]
    if not beyond.size:
        row = int(np.argmax(np.where(within, slope, -1.0)))
        share = f"{100 * plate[row] / plate.max():.0f} %"
        message = f"the outermost place still has {share} of the peak; measure until nothing lands"
        raise sheets.error(message, "film_um", row)
    return 0.5 * (last + float(beyond.min()))


def _hats(at: Scalars, nodes: Scalars) -> NDArray[np.float64]:
    """(n, k - 1) hat functions at places; the last node is the edge, where the profile is 0."""
    rows = np.stack([np.interp(at, nodes, column, right=0.0) for column in np.eye(len(nodes))], axis=1)
    return rows[:, :-1]


def _solve(matrix: NDArray[np.float64], rate: Scalars) -> tuple[Scalars, float]:
    """Profile (k,) that meets the rates best without falling below 0, and the rms of what is left."""
    count = matrix.shape[1]
    bends = np.diff(np.eye(count + 1), n=2, axis=0)[:, :count]
    scale = _SMOOTHNESS * np.sqrt(len(rate) / count)
    profile, _ = nnls(np.vstack([matrix, scale * bends]), np.concatenate([rate, np.zeros(len(bends))]))
    return np.append(profile, 0.0), float(np.sqrt(np.mean((matrix @ profile - rate) ** 2)))


def _flow_lpm(radius_mm: Scalars, rate_um_s: Scalars) -> float:
    """Volume that lands in a minute: the integral of 2 pi r q, linear between the nodes."""
    fine = np.linspace(0.0, float(radius_mm[-1]), 4001)
    ring = 2.0 * np.pi * fine * np.interp(fine, radius_mm, rate_um_s)
    return float(np.trapezoid(ring, fine)) * 1e-3 * 60.0 * 1e-6
