"""What is allowed in a recipe but probably not meant."""

import math
from collections.abc import Iterator

from recipes.classes import ComponentClass
from recipes.nozzles import HollowCone
from recipes.paths import ComponentPerimeter, OverFaces
from recipes.recipe import Recipe, use_of
from specs.finding import Finding
from specs.finding_rules import (
    CLASS_OUT_OF_REACH,
    NEAR_WITHIN_MERGE_GAP,
    NO_CLASS_FOR_THE_REST,
    RING_CONTRADICTS_HALF_ANGLE,
    RINSE_BEFORE_CLEAN,
    UNUSED_FUNCTION,
    UNUSED_NOZZLE,
    UNUSED_TEMPLATE,
)
from specs.source import Source

_RING_TOLERANCE_DEG = 8.0
_TAKES_ALL = ComponentClass()


def check_recipe(recipe: Recipe) -> tuple[Finding, ...]:
    """Find what a recipe states in vain: parts without use, classes that cannot match, rings that contradict."""
    checks = (_find_unused, _find_idle_classes, _find_contradictions, _find_early_rinses)
    return tuple(finding for check in checks for finding in check(recipe))


def _find_unused(recipe: Recipe) -> Iterator[Finding]:
    steps = recipe.sequence
    used = {
        "functions": {step.function for step in steps},
        "nozzles": {step.nozzle for step in steps},
        "templates": {name for step in steps for name in step.paths},
    }
    rules = {"functions": UNUSED_FUNCTION, "nozzles": UNUSED_NOZZLE, "templates": UNUSED_TEMPLATE}
    for kind, names in used.items():
        for name in getattr(recipe, kind):
            if name not in names:
                message = f"no step uses {name}; add it to the sequence, or remove it"
                yield Finding(rules[kind], message, Source(entry=f"{kind}.{name}"))


def _find_idle_classes(recipe: Recipe) -> Iterator[Finding]:
    """The first class that matches wins, so nothing reaches a class after one that takes all."""
    taker = ""
    for name, component_class in recipe.classes.items():
        if taker:
            message = f"never matches, because {taker} before it takes every component; put it before {taker}"
            yield Finding(CLASS_OUT_OF_REACH, message, Source(entry=f"classes.{name}"))
        elif component_class == _TAKES_ALL:
            taker = name
    if not taker and not all(isinstance(spec, OverFaces) for spec in recipe.templates.values()):
        message = "no class takes what the others leave; add a last one that states nothing, such as `other: {}`"
        yield Finding(NO_CLASS_FOR_THE_REST, message, Source(entry="classes"))


def _find_contradictions(recipe: Recipe) -> Iterator[Finding]:
    for name, spec in recipe.templates.items():
        if isinstance(spec, ComponentPerimeter) and spec.near is not None and spec.near.within_mm <= spec.merge_gap_mm:
            message = (
                f"near.within_mm {spec.near.within_mm:g} is not above merge_gap_mm {spec.merge_gap_mm:g}: components "
                "so close are followed as one outline, so near seldom holds; raise within_mm"
            )
            yield Finding(NEAR_WITHIN_MERGE_GAP, message, Source(entry=f"templates.{name}.near"))
    for name, nozzle in recipe.nozzles.items():
        if not isinstance(nozzle, HollowCone) or nozzle.wavefront is None:
            continue
        radii = [(inner + outer) / 2 for _, inner, outer in nozzle.wavefront.points]
        measured = math.degrees(math.atan2(sum(radii) / len(radii), nozzle.wavefront.height_mm))
        if abs(measured - nozzle.half_angle_deg) > _RING_TOLERANCE_DEG:
            message = (
                f"the measured ring has a half angle of {measured:.1f} degrees but half_angle_deg states "
                f"{nozzle.half_angle_deg:g}; check height_mm and the radii, or correct half_angle_deg"
            )
            yield Finding(RING_CONTRADICTS_HALF_ANGLE, message, Source(entry=f"nozzles.{name}.wavefront"))


def _find_early_rinses(recipe: Recipe) -> Iterator[Finding]:
    """Nothing has come loose yet where a rinse precedes all washing."""
    steps = [(index, step) for index, step in enumerate(recipe.sequence) if step.enabled]
    uses = [use_of(step.function, recipe.functions[step.function], recipe.nozzles[step.nozzle]) for _, step in steps]
    if "wash" not in uses:
        return
    first = uses.index("wash")
    for (index, step), use in zip(steps[:first], uses, strict=False):
        if use == "rinse":
            message = (
                f"{step.function} rinses before {steps[first][1].function} washes for the first time; "
                f"put it after sequence[{steps[first][0]}]"
            )
            yield Finding(RINSE_BEFORE_CLEAN, message, Source(index))
