"""Spray patterns on flat sheets: where on them which ray of the nozzle arrived.

A sheet lies flat below the orifice. Places on it are measured from the point that the nozzle's axis meets; azimuth 0,
which is x, points to where the axis tilts, and azimuths grow clockwise as seen from the nozzle, as in a recipe's wave
front. The nozzle's reference azimuth lies in the plane of the tilt.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cleaning.calibration.measurements import Column, Measurements, read_measurements
from geometry.arrays import Indices, Scalars

_LENGTH = 2000.0
_HIGHEST = 1000.0
"""As in a recipe."""
_COLUMNS: Mapping[str, Column] = {
    "height_mm": Column(1.0, _HIGHEST),
    "tilt_deg": Column(0.0, 80.0, default=0.0),
    "azimuth_deg": Column(-360.0, 360.0, optional=True),
    "inner_mm": Column(0.01, _LENGTH, optional=True),
    "outer_mm": Column(0.01, _LENGTH, optional=True),
    "radius_mm": Column(0.0, _LENGTH, optional=True),
    "x_mm": Column(-_LENGTH, _LENGTH, optional=True),
    "y_mm": Column(-_LENGTH, _LENGTH, optional=True),
    "intensity": Column(0.0, 1e12, optional=True),
}
_LEAST_ROWS = 8
_MOST_SHEETS = 100


@dataclass(frozen=True, slots=True, eq=False)
class Rays:
    """The rays from the orifice to n places on sheets. Radians, mm."""

    polar: Scalars
    """(n,) angle from the nozzle's axis."""
    azimuth: Scalars
    """(n,) about it, from the nozzle's reference."""
    length: Scalars
    """(n,) of the ray."""
    incidence_cosine: Scalars
    """(n,) of the angle between ray and the normal of the sheet."""


def read_sheets(path: Path) -> Measurements:
    """Read measured patterns: edges of the ring, or intensities.

    Raises:
        CleaningError: it cannot be used; the message names the line.
    """
    sheets = read_measurements(path, _COLUMNS, _LEAST_ROWS)
    columns = sheets.columns
    if "intensity" in columns:
        if ("x_mm" in columns and "y_mm" in columns) == ("azimuth_deg" in columns and "radius_mm" in columns):
            message = "intensities need places: either x_mm and y_mm, or azimuth_deg and radius_mm"
            raise sheets.error(message)
        if float(columns["intensity"].max()) == 0.0:
            raise sheets.error("no intensity is above 0", "intensity", 0)
    else:
        for name in ("azimuth_deg", "inner_mm", "outer_mm"):
            if name not in columns:
                raise sheets.error(
                    f"column {name!r} is missing; edges of the ring need it, intensities need 'intensity'"
                )
        wrong = np.flatnonzero(columns["inner_mm"] >= columns["outer_mm"])
        if wrong.size:
            message = f"{columns['inner_mm'][wrong[0]]:g} is not below outer_mm, {columns['outer_mm'][wrong[0]]:g}"
            raise sheets.error(message, "inner_mm", int(wrong[0]))
    count = len(set(_keys(sheets)))
    if count > _MOST_SHEETS:
        message = f"{count} pairs of height_mm and tilt_deg are too many; each is a sheet, {_MOST_SHEETS} at most"
        raise sheets.error(message)
    sheets.require_variation("height_mm", "measure at two heights at least, so that a cone can be fitted")
    return sheets


def rays_to(sheets: Measurements, x_mm: Scalars, y_mm: Scalars) -> Rays:
    """Find the rays that arrive at places on sheets.

    With z down and the orifice at the origin, the axis is (sin b, 0, cos b), the nozzle's reference (cos b, 0, -sin b).
    """
    height, tilt = sheets.columns["height_mm"], np.radians(sheets.columns["tilt_deg"])
    forward = x_mm + height * np.tan(tilt)
    along = forward * np.sin(tilt) + height * np.cos(tilt)
    reference = forward * np.cos(tilt) - height * np.sin(tilt)
    length = np.sqrt(forward**2 + y_mm**2 + height**2)
    return Rays(
        polar=np.asarray(np.arctan2(np.hypot(reference, y_mm), along), dtype=np.float64),
        azimuth=np.asarray(np.arctan2(y_mm, reference), dtype=np.float64),
        length=length,
        incidence_cosine=height / length,
    )


def meet(height_mm: float, tilt: float, polar: Scalars, azimuth: Scalars) -> tuple[Scalars, Scalars]:
    """Give x and y on one sheet of where rays arrive, mm: the reverse of ``rays_to``; far away if they never do.

    Args:
        height_mm: Of the sheet.
        tilt: Of the nozzle, rad.
        polar: (n,) angles from its axis, rad.
        azimuth: (n,) about it, rad.
    """
    reference, across, along = np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)
    forward = reference * np.cos(tilt) + along * np.sin(tilt)
    down = np.maximum(along * np.cos(tilt) - reference * np.sin(tilt), 1e-3)
    return height_mm * forward / down - height_mm * np.tan(tilt), height_mm * across / down


def places(sheets: Measurements, radius_mm: Scalars) -> tuple[Scalars, Scalars]:
    """Give x and y on the sheets of places at a radius along the measured azimuths, mm."""
    around = np.radians(sheets.columns["azimuth_deg"])
    return radius_mm * np.cos(around), radius_mm * np.sin(around)


def sheet_of(sheets: Measurements) -> tuple[list[tuple[float, float]], Indices]:
    """Give the sheets of a table, height and tilt of each in the order of the file, and which is each row's."""
    keys = _keys(sheets)
    order = {key: index for index, key in enumerate(dict.fromkeys(keys))}
    return list(order), np.array([order[key] for key in keys], dtype=np.int64)


def _keys(sheets: Measurements) -> list[tuple[float, float]]:
    return list(zip(sheets.columns["height_mm"].tolist(), sheets.columns["tilt_deg"].tolist(), strict=True))


def harmonics(azimuth: Scalars, order: int) -> NDArray[np.float64]:
    """(n, 2 order) cosines and sines of the multiples of an azimuth: what a table about the axis is made of."""
    waves = [wave(turn * azimuth) for turn in range(1, order + 1) for wave in (np.cos, np.sin)]
    return np.column_stack(waves) if waves else np.zeros((len(azimuth), 0))
