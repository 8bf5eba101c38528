"""Fits to spray patterns on flat sheets: the ring of a hollow cone, and the radial profile of a round jet.

The ring has a half angle that may vary about the axis, and a Gaussian profile in the polar angle. Where its inner and
outer edges were measured, they are taken for two sigmas inside and outside of the middle, as recipes and jets have it.

What a sheet gets follows from the profile on a plate at one distance by the solid angle (Jiangsu 2010, eq. (4), with
its exponent corrected), so that sheets at several distances and tilts are one linear least-squares problem.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from cleaning.calibration.confidence import Estimate, Fit, chance_of_less, half_widths
from cleaning.calibration.measurements import (
    Column,
    Measurements,
    harmonics,
    places,
    rays_to,
    read_measurements,
    read_sheets,
    sheet_of,
)
from cleaning.errors import CleaningError
from geometry.arrays import Scalars
from recipes.footprint import RING_EDGE_SIGMAS

Quantity: TypeAlias = Literal["volume", "pressure"]
"""What an intensity stands for: deposited volume (water-sensitive paper), or stress (pressure film)."""
_ORDER = 2
_LEAST_AZIMUTHS = 8
_WIDEST_GAP = np.pi / 2
_CHANCE = 0.01
_ANGLES = (np.radians(1.0), np.radians(84.0))
_WIDEST_INTERVAL = np.radians(10.0)
"""Of the half width of a 95 % interval."""
_SIGMAS = (np.radians(0.2), np.radians(20.0))


@dataclass(frozen=True, slots=True)
class Sheet:
    """How well one sheet is met."""

    height_mm: float
    tilt_deg: float
    samples: int
    rms: float
    bias: float
    """Mean of measured less fitted; a cone that contracts with distance shows in it."""


@dataclass(frozen=True, slots=True, eq=False)
class RingFit:
    """A fitted ring."""

    measurements: Measurements
    half_angle_deg: Estimate
    """Mean about the axis."""
    sigma_deg: Estimate
    waves_deg: tuple[float, ...]
    """Cosine and sine amplitudes of the half angle, by order; empty where the ring is no worse as a circle."""
    gain: tuple[float, ...]
    """Cosine and sine amplitudes of the intensity about the axis; empty where edges were measured, or none matters."""
    rms: float
    unit: str
    """Of ``rms`` and of the sheets: ``"mm"``, or ``"of the peak"``."""
    sheets: tuple[Sheet, ...]

    def middle(self, azimuth: Scalars) -> Scalars:
        """Half angle at azimuths (n,), both rad."""
        order = len(self.waves_deg) // 2
        waves = harmonics(azimuth, order) @ np.radians(np.array(self.waves_deg, dtype=np.float64))
        return np.asarray(np.radians(self.half_angle_deg.value) + waves, dtype=np.float64)


def calibrate_ring(path: Path, quantity: Quantity = "volume") -> RingFit:
    """Fit half angle, sigma and the ring's irregularity to a table of measured patterns.

    Args:
        path: CSV of edges (azimuth, inner and outer radius) or of intensities, at two heights at least.
        quantity: What intensities stand for.

    Raises:
        CleaningError: the table cannot be used, or shows no ring.
    """
    sheets = read_sheets(path)
    if quantity == "pressure" and "intensity" not in sheets.columns:
        raise CleaningError("--quantity is for intensities, and this table has the edges of a ring.", file=path)
    solve = _edges(sheets) if "intensity" not in sheets.columns else _intensities(sheets, quantity)
    fit = solve(0)
    if _sees_around(sheets):
        wavy = solve(_ORDER)
        if wavy.fit.freedom > 0 and chance_of_less(fit.fit, wavy.fit) < _CHANCE:
            fit = wavy
    return _conclude(sheets, fit)


@dataclass(frozen=True, slots=True, eq=False)
class _Solved:
    """The optimum for one number of harmonics: parameters are middle, sigma, waves, gain."""

    fit: Fit
    left: NDArray[np.float64]
    """(n, k) what is left of each row."""
    order: int
    unit: str


_Solve: TypeAlias = Callable[[int], _Solved]


def _edges(sheets: Measurements) -> _Solve:
    """Prepare the fit of edges: linear in all parameters, weighted so that what is left is in mm on the sheet."""
    radii = (sheets.columns["inner_mm"], sheets.columns["outer_mm"])
    rays = [rays_to(sheets, *places(sheets, radius)) for radius in radii]
    nearby = [rays_to(sheets, *places(sheets, radius + 1e-3)) for radius in radii]
    weights = [1e-3 / (near.polar - ray.polar) for near, ray in zip(nearby, rays, strict=True)]

    ones = np.ones(len(sheets))

    def solve(order: int) -> _Solved:
        rows = [
            np.column_stack([ones, side * RING_EDGE_SIGMAS * ones, harmonics(ray.azimuth, order)])
            for ray, side in zip(rays, (-1.0, 1.0), strict=True)
        ]
        design = np.vstack([weight[:, None] * row for weight, row in zip(weights, rows, strict=True)])
        target = np.concatenate([weight * ray.polar for weight, ray in zip(weights, rays, strict=True)])
        found = np.asarray(np.linalg.lstsq(design, target)[0], dtype=np.float64)
        left = (target - design @ found).reshape(2, -1).T
        by_row = design.reshape(2, len(ones), -1).swapaxes(0, 1).reshape(2 * len(ones), -1)
        fit = Fit(found, float(np.sum(left**2)), left.size - len(found), -by_row)
        return _Solved(fit, left, order, "mm")

    return solve


def _intensities(sheets: Measurements, quantity: Quantity) -> _Solve:
    """Prepare the fit of intensities; how strong each sheet is altogether is unknown and fitted with the rest."""
    from scipy.optimize import least_squares

    around = (sheets.columns["x_mm"], sheets.columns["y_mm"]) if "x_mm" in sheets.columns else None
    rays = rays_to(sheets, *(around or places(sheets, sheets.columns["radius_mm"])))
    keys, sheet = sheet_of(sheets)
    members = np.array([sheet == index for index in range(len(keys))])
    peaks = np.array([sheets.columns["intensity"][mine].max() for mine in members])
    measured = sheets.columns["intensity"] / np.maximum(peaks, 1e-300)[sheet]
    spread = rays.incidence_cosine ** (2 if quantity == "pressure" else 1) / rays.length**2
    weight = measured / spread
    start = float(np.clip(weight @ rays.polar / weight.sum(), *_ANGLES))

    def residuals(values: Scalars, order: int) -> Scalars:
        waves = harmonics(rays.azimuth, order)
        middle = values[0] + waves @ values[2 : 2 + 2 * order]
        shape = spread * (1.0 + waves @ values[2 + 2 * order :])
        shape = shape * np.exp(-0.5 * ((rays.polar - middle) / values[1]) ** 2)
        strength = (members @ (shape * measured)) / np.maximum(members @ shape**2, 1e-300)
        return np.asarray(measured - strength[sheet] * shape, dtype=np.float64)

    def solve(order: int) -> _Solved:
        low = np.array([_ANGLES[0], _SIGMAS[0], *np.full(2 * order, -0.3), *np.full(2 * order, -1.0)])
        high = np.array([_ANGLES[1], _SIGMAS[1], *np.full(2 * order, 0.3), *np.full(2 * order, 1.0)])
        starts = [np.array([start, sigma, *np.zeros(4 * order)]) for sigma in np.radians([1.5, 3.0, 6.0])]
        tried = [least_squares(residuals, first, bounds=(low, high), args=(order,)) for first in starts]
        best = tried[int(np.argmin([round(float(each.cost), 12) for each in tried]))]
        freedom = len(measured) - len(low) - len(keys)
        fit = Fit(np.asarray(best.x, dtype=np.float64), 2.0 * float(best.cost), freedom, np.asarray(best.jac))
        return _Solved(fit, np.asarray(best.fun)[:, None], order, "of the peak")

    return solve


def _sees_around(sheets: Measurements) -> bool:
    """Whether the ring was measured at enough azimuths on all sides to fit how it varies about the axis."""
    columns = sheets.columns
    around = np.radians(columns["azimuth_deg"]) if "azimuth_deg" in columns else None
    if around is None:
        around = np.arctan2(columns["y_mm"], columns["x_mm"])
    distinct = np.unique(np.round(around % (2 * np.pi), 3))
    gaps = np.diff(np.append(distinct, distinct[0] + 2 * np.pi))
    return len(distinct) >= _LEAST_AZIMUTHS and float(gaps.max()) <= _WIDEST_GAP


def _conclude(sheets: Measurements, solved: _Solved) -> RingFit:
    fit, order = solved.fit, solved.order
    half = _check_ring(sheets, solved)
    angle, sigma = (
        Estimate(*(float(np.degrees(each)) for each in (value, value - wide, value + wide)))
        for value, wide in zip(fit.parameters[:2], half[:2], strict=True)
    )
    keys, sheet = sheet_of(sheets)
    each_left = [solved.left[sheet == index] for index in range(len(keys))]
    met = [(len(left), float(np.sqrt(np.mean(left**2))), float(np.mean(left))) for left in each_left]
    return RingFit(
        measurements=sheets,
        half_angle_deg=angle,
        sigma_deg=sigma,
        waves_deg=tuple(np.degrees(fit.parameters[2 : 2 + 2 * order]).tolist()),
        gain=tuple(fit.parameters[2 + 2 * order :].tolist()),
        rms=float(np.sqrt(np.mean(solved.left**2))),
        unit=solved.unit,
        sheets=tuple(Sheet(*key, *numbers) for key, numbers in zip(keys, met, strict=True)),
    )


def _check_ring(sheets: Measurements, solved: _Solved) -> Scalars:
    """Give the half widths of the intervals of what was fitted, rad.

    Raises:
        CleaningError: the fit is no ring, or the measurements do not determine it.
    """
    fit, order = solved.fit, solved.order
    angle, sigma = fit.parameters[:2]
    if fit.freedom <= 0:
        raise sheets.error(f"{len(sheets)} rows are too few for what is fitted to them")
    around = np.arange(0.0, 2 * np.pi, np.radians(1.0))
    middle = angle + harmonics(around, order) @ fit.parameters[2 : 2 + 2 * order]
    inside = _ANGLES[0] < middle.min() and middle.max() < _ANGLES[1] and 1.01 * _SIGMAS[0] < sigma < 0.99 * _SIGMAS[1]
    if not inside:
        spread = f", between {np.degrees(middle.min()):.1f} and {np.degrees(middle.max()):.1f} around" if order else ""
        message = (
            f"these patterns show no ring: the fit ends at a half angle of {np.degrees(angle):.1f}{spread} and a sigma "
            f"of {np.degrees(sigma):.1f} degrees. Radii are measured from where the nozzle's axis meets the sheet"
        )
        raise sheets.error(message)
    half = half_widths(fit, solved.left)
    if not (half[:2] <= _WIDEST_INTERVAL).all():
        message = (
            "these measurements do not determine a ring: its half angle or sigma could be off by more than "
            f"{np.degrees(_WIDEST_INTERVAL):.0f} degrees. Measure at more places, in and beside the ring, and at "
            "several heights; look for rows that are wrong"
        )
        raise sheets.error(message)
    return half


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
    # What a place on a sheet gets per flux where its ray meets the plate: (h / l)² cos(alpha) / cos³(theta).
    along = np.cos(rays.polar)
    near = (at_mm / rays.length) ** 2 * rays.incidence_cosine
    gain = np.where(along > 1e-3, near / np.maximum(along, 1e-3) ** 3, 0)
    rate = columns["film_um"] / columns.get("time_s", np.ones(len(sheets)))
    # Projected on the plate, all sheets show one curve; where the gain is tiny a place weighs little.
    plate = np.where(gain > 0.0, rate / np.maximum(gain, 1e-12), 0.0)
    slope = np.tan(np.minimum(rays.polar, np.radians(89.0)))
    edge = _edge_of(sheets, slope, plate)
    nodes = np.linspace(0.0, edge, int(np.clip(len(np.unique(np.round(slope, 4))) // 2, _FEWEST, _MOST)))
    # Hat functions of all nodes but the last: that is the edge, where the profile is 0.
    hats = np.stack([np.interp(slope, nodes, column, right=0.0) for column in np.eye(len(nodes))], axis=1)[:, :-1]
    # The profile that meets the rates best without falling below 0, and without bends.
    matrix, count = hats * gain[:, None], hats.shape[1]
    bends = np.diff(np.eye(count + 1), n=2, axis=0)[:, :count]
    scale = _SMOOTHNESS * np.sqrt(len(rate) / count)
    solved, _ = nnls(np.vstack([matrix, scale * bends]), np.concatenate([rate, np.zeros(len(bends))]))
    profile, rms = np.append(solved, 0.0), float(np.sqrt(np.mean((matrix @ solved - rate) ** 2)))
    # Volume that lands in a minute: the integral of 2 pi r q, linear between the nodes.
    fine = np.linspace(0.0, float((nodes * at_mm)[-1]), 4001)
    ring = 2.0 * np.pi * fine * np.interp(fine, nodes * at_mm, profile)
    peak = float(profile.max())
    return PatternFit(
        measurements=sheets,
        at_mm=at_mm,
        radius_mm=nodes * at_mm,
        flux=profile / peak,
        flow_lpm=float(np.trapezoid(ring, fine)) * 1e-3 * 60.0 * 1e-6 if "time_s" in columns else None,
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
