"""Fits as files: kinetics as a parameter set, a ring as the lines of a nozzle or a recipe; all else is inherited."""

import json
import os
import re
from pathlib import Path

import numpy as np

from cleaning.calibration.fit_kinetics import GapFit
from cleaning.calibration.fit_spray import RingFit
from cleaning.errors import CleaningError
from cleaning.parameters.load import parameter_library, read_parameters_text
from cleaning.parameters.provenance import is_day
from recipes.errors import RecipeError
from recipes.footprint import RING_EDGE_SIGMAS
from recipes.load import RECIPE, load_recipe, read_recipe_text
from recipes.nozzles import HollowCone, Wavefront
from recipes.start import start_recipe
from specs.yaml.edit import remove_value, set_value
from specs.yaml.load import find_file
from specs.yaml.schema import name_nearest

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.-]*")


def calibrated_set(fit: GapFit, source: str | Path, file: Path, date: str = "") -> str:
    """Write a parameter set that extends another by what was fitted.

    Args:
        fit: The kinetics.
        source: The set that the fit began with: a library name or a file.
        file: Where the new set will stand; it is named after it.
        date: Of the measurement, as in 2026-11-21; empty if it is not known.

    Raises:
        CleaningError: the file's name cannot be a set's, the date is none, or a fitted value is out of bounds.
    """
    if _NAME.fullmatch(file.stem) is None:
        message = f"{file.stem!r} cannot name a set: begin with a letter; use letters, digits and _ . - only"
        raise CleaningError(message, file=file)
    if date and not is_day(date):
        raise CleaningError(f"{date!r} is no date; write it as in 2026-11-21")
    values = {name: _rounded(estimate.value) for name, estimate in fit.estimates.items()}
    undetermined, synthetic = fit.undetermined.items(), fit.coupons.measurements.synthetic
    fitted = ", ".join(name.partition(".")[2] for name in fit.estimates)
    coupons = "made-up coupons" if synthetic else "coupons"
    description = f"{fitted} fitted to {len(fit.predicted)} {coupons}; all else as {Path(source).stem}."
    base = str(source)
    if base not in parameter_library():  # the way from the new file to the old one
        base = json.dumps(Path(os.path.relpath(Path(source).resolve(), file.parent.resolve())).as_posix())
    lines = [
        f"# Fitted by washboard to {fit.coupons.measurements.source}.",
        *(["# SYNTHETIC data: this proves nothing about a line, and verdicts keep their grade."] * synthetic),
        *(
            f"# {name} is not determined by them and stays {lost.kept:g}; the rest holds with that."
            for name, lost in undetermined
        ),
        f"parameters: {file.stem}",
        f"description: {json.dumps(description)}",
        f"extends: {base}",
    ]
    for block in ("soil", "film"):
        own = {name: value for name, value in values.items() if name.startswith(f"{block}.")}
        lines += [f"{block}:"] * bool(own) + [f"  {name.partition('.')[2]}: {value:g}" for name, value in own.items()]
    lines += ["provenance:", *(_provenance(fit, name, date) for name in values)]
    text = "\n".join(lines) + "\n"
    try:
        read_parameters_text(text, file=file)
    except CleaningError as error:
        message = f"the fitted values cannot be those of a line, so no set was written. It would be refused: {error}"
        raise CleaningError(message) from None
    return text


def _provenance(fit: GapFit, name: str, date: str) -> str:
    estimate, measurements = fit.estimates[name], fit.coupons.measurements
    entry = [
        f"known: {'synthetic' if measurements.synthetic else 'calibrated'}",
        f"source: {json.dumps(measurements.source, ensure_ascii=False)}",
        *([f'date: "{date}"'] if date else []),
        f"samples: {len(measurements)}",
        f"rms: {fit.rms:.3g}",
        f"interval: [{_rounded(estimate.low):g}, {_rounded(estimate.high):g}]",
    ]
    return f"  {name}: {{{', '.join(entry)}}}"


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


_AZIMUTHS_DEG = np.arange(0.0, 360.0, 15.0)
_LEAST_ANGLE = np.radians(0.5)
_WIDEST_ANGLE = np.radians(85.0)


def wavefront_of(fit: RingFit) -> Wavefront | None:
    """Give the ring on a flat plate by azimuth, at the least height that was measured; nothing for a plain circle."""
    if not fit.waves_deg:
        return None
    height = min(sheet.height_mm for sheet in fit.sheets)
    middle = fit.middle(np.radians(_AZIMUTHS_DEG))
    half = RING_EDGE_SIGMAS * np.radians(fit.sigma_deg.value)
    inner = height * np.tan(np.maximum(middle - half, _LEAST_ANGLE))
    outer = height * np.tan(np.minimum(middle + half, _WIDEST_ANGLE))
    rows = zip(_AZIMUTHS_DEG.tolist(), inner.tolist(), outer.tolist(), strict=True)
    return Wavefront(height_mm=height, points=[(around, round(low, 2), round(high, 2)) for around, low, high in rows])


def nozzle_text(fit: RingFit) -> str:
    """Write what was fitted as the lines of a nozzle, with a comment on where it comes from."""
    lines = [f"# {_fit_text(fit)}", *(f"{key}: {value:g}" for key, value in _numbers(fit).items())]
    wavefront = wavefront_of(fit)
    if wavefront is not None:
        lines += ["wavefront:", f"  height_mm: {wavefront.height_mm:g}", "  points:"]
        lines += [f"    - [{around:g}, {inner:g}, {outer:g}]" for around, inner, outer in wavefront.points]
    return "\n".join(lines) + "\n"


def recipe_with_ring(fit: RingFit, source: str | Path, nozzle: str, file: Path) -> str:
    """Write a recipe like another one, comments and all, whose nozzle has the fitted ring.

    Args:
        fit: The ring.
        source: The recipe to begin with: a library name or a file.
        nozzle: Name of its hollow cone.
        file: Where the new recipe will stand; it is named after it.

    Raises:
        CleaningError: there is no such hollow cone, or its ring does not suit the recipe.
        RecipeError: the recipe cannot be used.
    """
    _, before = choose_nozzle(source, nozzle)
    text = start_recipe(source, file)
    for key, value in _numbers(fit).items():
        text = set_value(text, ("nozzles", nozzle, key), value)
    wavefront = wavefront_of(fit)
    if wavefront is not None:
        value = {"height_mm": wavefront.height_mm, "points": [list(point) for point in wavefront.points]}
        text = set_value(text, ("nozzles", nozzle, "wavefront"), value)
    elif before.wavefront is not None:
        text = remove_value(text, ("nozzles", nozzle, "wavefront"))
    first, _, rest = text.partition("\n")
    comment = f"# Nozzle {nozzle}: {_fit_text(fit)}\n"
    text = f"{first}\n{comment}{rest}" if first.startswith("#") else f"{comment}{text}"
    try:
        read_recipe_text(text, file=file)
    except RecipeError as error:
        message = f"the fitted ring does not suit this recipe, so none was written. It would be refused: {error}"
        raise CleaningError(message, path=f"nozzles.{nozzle}", file=find_file(source, RECIPE)) from None
    return text


def choose_nozzle(source: str | Path, name: str | None) -> tuple[str, HollowCone]:
    """Find a hollow cone of a recipe.

    Args:
        source: The recipe: a library name or a file.
        name: Of the nozzle; ``None`` for its only hollow cone.

    Raises:
        CleaningError: there is none of that name, it is no hollow cone, or there is more than one to choose from.
        RecipeError: the recipe cannot be used.
    """
    nozzles = load_recipe(source).nozzles
    cones = {key: nozzle for key, nozzle in nozzles.items() if isinstance(nozzle, HollowCone)}
    if name is None and len(cones) == 1:
        return next(iter(cones.items()))
    if name is not None and name in cones:
        return name, cones[name]
    if not cones:
        message = "this recipe has no hollow cone; name one that has with --recipe"
    else:
        problem = "--nozzle must name one" if name is None else f"{name!r} is no hollow cone of this recipe"
        message = f"{problem}; {name_nearest(name or '', cones)}"
    raise CleaningError(message, path="nozzles", file=find_file(source, RECIPE))


def _numbers(fit: RingFit) -> dict[str, float]:
    return {"half_angle_deg": round(fit.half_angle_deg.value, 2), "ring_sigma_deg": round(fit.sigma_deg.value, 2)}


def _fit_text(fit: RingFit) -> str:
    made_up = "SYNTHETIC data, proves nothing: " if fit.measurements.synthetic else ""
    return (
        f"{made_up}fitted to {fit.measurements.source}: {len(fit.measurements)} rows, rms {fit.rms:.3g} {fit.unit}, "
        f"half angle {_range(fit.half_angle_deg.interval)}, sigma {_range(fit.sigma_deg.interval)} degrees (95 %)."
    )


def _range(interval: tuple[float, float]) -> str:
    return f"{interval[0]:.2f} to {interval[1]:.2f}"
