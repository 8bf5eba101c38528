"""Consistency of a recipe: what must hold between its parts; a recipe that breaks it is refused."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Literal, cast

from recipes.nozzles import HollowCone, Nozzle
from recipes.paths import ComponentPerimeter, OverFaces, PathSpec, Slices, StraightLine
from recipes.recipe import Function, Recipe, film_in, use_of
from specs.yaml.located import YamlPath, spell_path
from specs.yaml.problems import Problem
from specs.yaml.schema import name_nearest

_DEFAULT = "default"
_SINGULAR = {"functions": "function", "nozzles": "nozzle", "templates": "template", "classes": "class"}
_FLATTEST_DEG = 85.0  # a ray of the spray flatter than this does not close on the board (cleaning model, section 1.1)
_CLEARANCE: YamlPath = ("limits", "clearance_mm")


def find_problems(recipe: Recipe) -> list[Problem]:
    """Problems between the parts of a recipe, each of which is valid by itself."""
    checks: tuple[Callable[[Recipe], Iterator[Problem]], ...] = (
        _check_references,
        _check_by_class,
        _check_values,
        _check_slices,
        _check_films,
        _check_film_steps,
        _check_steps,
    )
    return [problem for check in checks for problem in check(recipe)]


def values_of(spec: PathSpec, field: str) -> Iterator[tuple[YamlPath, float]]:
    """Every number that a template may take for a field: the one, those by class, the one near neighbours."""
    value = cast('float | dict[str, float] | Literal["auto"] | None', getattr(spec, field, None))
    if isinstance(value, dict):
        yield from (((field, name), number) for name, number in value.items())
    elif value is not None and value != "auto":
        yield (field,), value
    if isinstance(spec, ComponentPerimeter) and spec.near is not None:
        near = cast("float | None", getattr(spec.near, field, None))
        if near is not None:
            yield ("near", field), near


def _check_references(recipe: Recipe) -> Iterator[Problem]:
    """Every step names what exists."""
    for index, step in enumerate(recipe.sequence):
        at: YamlPath = ("sequence", index)
        if step.function not in recipe.functions:
            yield _unknown((*at, "function"), "functions", step.function, recipe.functions)
        if step.nozzle not in recipe.nozzles:
            yield _unknown((*at, "nozzle"), "nozzles", step.nozzle, recipe.nozzles)
        for place, name in enumerate(step.paths):
            if name not in recipe.templates:
                yield _unknown((*at, "paths", place), "templates", name, recipe.templates)
    if not any(step.enabled for step in recipe.sequence):
        yield Problem(("sequence",), "no step is enabled, so there is nothing to do; enable one")


def _check_by_class(recipe: Recipe) -> Iterator[Problem]:
    """Values by class name classes that exist, and leave none without a value."""
    if not recipe.classes and not all(isinstance(spec, OverFaces) for spec in recipe.templates.values()):
        yield Problem(("classes",), "is empty; give at least one class, such as `all: {}`")
    if _DEFAULT in recipe.classes:
        yield Problem(("classes", _DEFAULT), "stands for all classes not listed; give the class another name")
    for name, spec in recipe.templates.items():
        at: YamlPath = ("templates", name)
        served = list(recipe.classes)
        if isinstance(spec, ComponentPerimeter):
            for place, only in enumerate(spec.only):
                if only not in recipe.classes:
                    yield _unknown((*at, "only", place), "classes", only, recipe.classes)
            served = spec.only or served
        for field in type(spec).model_fields:
            value = getattr(spec, field)
            if isinstance(value, dict):
                yield from _check_classes((*at, field), cast("dict[str, float]", value), served, recipe)


def _check_classes(at: YamlPath, value: dict[str, float], served: list[str], recipe: Recipe) -> Iterator[Problem]:
    for name in value:
        if name != _DEFAULT and name not in recipe.classes:
            yield _unknown((*at, name), "classes", name, [*recipe.classes, _DEFAULT])
    missing = [name for name in served if name not in value]
    if missing and _DEFAULT not in value:
        others = tuple(("classes", name) for name in missing)
        yield Problem(at, f"has no value for {', '.join(missing)}; add it or `default:`", others)


def _check_values(recipe: Recipe) -> Iterator[Problem]:
    """The orifice stays above the clearance over the bare board, lines have two ends, masks are not blank."""
    clearance = recipe.limits.clearance_mm
    for name, spec in recipe.templates.items():
        for path, height in values_of(spec, "height_mm"):
            if height <= clearance:
                message = f"{height:g} mm is not above the clearance ({clearance:g} mm, limits.clearance_mm); raise it"
                yield Problem(("templates", name, *path), message, (_CLEARANCE,))
        if isinstance(spec, StraightLine) and math.dist(spec.from_mm, spec.to_mm) < 1e-3:
            message = "is where the line begins; a line needs two points"
            yield Problem(("templates", name, "to"), message, (("templates", name, "from"),))
    if recipe.limits.park_height_mm <= clearance:
        message = f"{recipe.limits.park_height_mm:g} mm is not above the clearance ({clearance:g} mm); raise it"
        yield Problem(("limits", "park_height_mm"), message, (_CLEARANCE,))
    for index, mask in enumerate(recipe.masks):
        for kind in ("avoid", "clean", "ignore"):
            for place, pattern in enumerate(cast("list[str]", getattr(mask, kind))):
                if not pattern.strip():
                    yield Problem(("masks", index, kind, place), "is blank and matches nothing; write a refdes or J*")


def _check_slices(recipe: Recipe) -> Iterator[Problem]:
    """Curves over a face have a number or a spacing, of a film both, and a direction that is one."""
    for name, spec in recipe.templates.items():
        if not isinstance(spec, Slices):
            continue
        if spec.slices != "auto" and spec.spacing_mm != "auto" and spec.film is None:
            message = "states the spacing besides slices, the number of curves; leave one of them out"
            yield Problem(("templates", name, "spacing_mm"), message, (("templates", name, "slices"),))
        if spec.along != "auto" and math.hypot(*spec.along) < 1e-3:
            yield Problem(("templates", name, "along"), "is no direction; give one such as [1, 0, 0]")


def _check_films(recipe: Recipe) -> Iterator[Problem]:
    """Films leave no other goal beside them, and are thicker than their tolerance."""
    for name, spec in recipe.templates.items():
        film = film_in(spec)
        if film is None:
            continue
        for key in ("required_s", "repair"):
            if key in spec.model_fields_set:
                message = "is a time in the cone, and film states a thickness; leave one of them out"
                if key == "repair":
                    message = "adds time in the cone, and a film is levelled; leave it out"
                yield Problem(("templates", name, key), message, (("templates", name, "film"),))
        if film.tolerance_um > film.thickness_um:
            message = f"is more than the film ({film.thickness_um:g} µm); lower it"
            yield Problem(("templates", name, "film", "tolerance_um"), message)


def _check_film_steps(recipe: Recipe) -> Iterator[Problem]:
    """A film has a step of its own that sprays a liquid, a known number of times."""
    for index, step in enumerate(recipe.sequence):
        films = [name for name in step.paths if film_in(recipe.templates.get(name)) is not None]
        function, nozzle = recipe.functions.get(step.function), recipe.nozzles.get(step.nozzle)
        if not films or function is None or nozzle is None:
            continue
        at: YamlPath = ("sequence", index)
        if len(set(step.paths)) > 1:
            yield Problem((*at, "paths"), f"{films[0]} lays a film: give it a step of its own")
        if use_of(step.function, function, nozzle) == "dry":
            yield Problem((*at, "paths"), f"{films[0]} lays a film, and this step blows gas; take another nozzle")
        for key in ("until", "least_time_s"):
            if getattr(step, key) is not None:
                message = f"repeats by need, and {films[0]} lays a film of one thickness; leave it out"
                yield Problem((*at, key), message)


def _check_steps(recipe: Recipe) -> Iterator[Problem]:
    """Speeds and tilts of a template suit the function and the nozzle of each step that uses it."""
    found: dict[tuple[YamlPath, str, str], Problem] = {}
    for index, step in enumerate(recipe.sequence):
        function, nozzle = recipe.functions.get(step.function), recipe.nozzles.get(step.nozzle)
        for place, name in enumerate(step.paths):
            spec, use = recipe.templates.get(name), ("sequence", index, "paths", place)
            if function is None or nozzle is None or spec is None:
                continue
            for problem in (*_too_fast(spec, function, step.function, use), *_too_flat(spec, nozzle, step.nozzle, use)):
                path: YamlPath = ("templates", name, *problem.path)
                found.setdefault((path, step.function, step.nozzle), replace(problem, path=path))
    yield from found.values()


def _too_fast(spec: PathSpec, function: Function, name: str, use: YamlPath) -> Iterator[Problem]:
    """Speeds above the maximum of the function; paths begin at the template."""
    fastest = function.max_speed_mm_s
    film = film_in(spec)
    stated: list[tuple[YamlPath, float]] = []
    for key in ("speed_mm_s", "max_speed_mm_s") if film is not None else ():
        value = getattr(film, key)
        if value != "auto":
            stated.append((("film", key), value))
    for path, speed in (*values_of(spec, "speed_mm_s"), *stated):
        if speed > fastest:
            step = spell_path(use[:2])
            message = (
                f"{speed:g} mm/s is above the maximum {fastest:g} mm/s: {step} uses it for {name}; lower it or use "
                "another template"
            )
            yield Problem(path, message, (("functions", name, "max_speed_mm_s"), use))


def _too_flat(spec: PathSpec, nozzle: Nozzle, name: str, use: YamlPath) -> Iterator[Problem]:
    """Tilts at which the spray does not close on the board; paths begin at the template."""
    spread = half_spread_deg(nozzle)
    for path, tilt in values_of(spec, "tilt_deg"):
        if tilt + spread >= _FLATTEST_DEG:
            message = (
                f"spray not closed on board: tilt {tilt:g} + half angle {spread:.3g} of {name} "
                f"is not below {_FLATTEST_DEG:g} degrees; tilt less than {_FLATTEST_DEG - spread:.3g}"
            )
            at = ("nozzles", name)
            yield Problem(path, message, ((*at, "half_angle_deg"), (*at, "wavefront"), use))


def half_spread_deg(nozzle: Nozzle) -> float:
    """Widest angle from the nozzle's axis to its spray; a measured wave front counts if it is wider."""
    if isinstance(nozzle, HollowCone) and nozzle.wavefront is not None:
        outer = max(point[2] for point in nozzle.wavefront.points)
        return max(nozzle.half_angle_deg, math.degrees(math.atan2(outer, nozzle.wavefront.height_mm)))
    return nozzle.half_angle_deg


def _unknown(path: YamlPath, section: str, name: str, known: Iterable[str]) -> Problem:
    message = f"there is no {_SINGULAR[section]} {name!r}; {name_nearest(name, known)}"
    return Problem(path, message, ((section, name),))
