"""A fitted ring as a recipe has it: the block of one nozzle, and a recipe with that block."""

from pathlib import Path

import numpy as np

from cleaning.calibration.fit_ring import RingFit
from cleaning.errors import CleaningError
from recipes.errors import RecipeError
from recipes.footprint import RING_EDGE_SIGMAS
from recipes.load import RECIPE, load_recipe, read_recipe_text
from recipes.nozzles import HollowCone, Wavefront
from recipes.start import start_recipe
from specs.yaml.edit import remove_value, set_value
from specs.yaml.load import find_file
from specs.yaml.schema import name_nearest

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
