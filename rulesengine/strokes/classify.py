"""Classes of components, and what the masks that treat some apart match (Sandia 1993, rule 3)."""

from collections.abc import Sequence
from dataclasses import dataclass

from boards.board import Board, Component
from recipes.classes import ComponentClass, ComponentMasks, Range, match_masks, matches
from recipes.errors import RecipeError
from recipes.recipe import Recipe
from specs.finding import Finding
from specs.finding_rules import CLASS_EMPTY, MASK_CONFLICT, MASK_EMPTY
from specs.source import Source


@dataclass(frozen=True, slots=True)
class Classified:
    """A component's class and the rule that put it there."""

    component: str
    component_class: str
    because: str
    """The conditions that held, with the component's numbers, e.g. ``"pins 64 >= 48"``."""


def classify(recipe: Recipe, board: Board) -> tuple[tuple[Classified, ...], tuple[Finding, ...]]:
    """Put every component into the first class that matches it.

    Raises:
        RecipeError: a component matches no class.
    """
    classified: list[Classified] = []
    for component in board.components:
        reasons = ((name, _reasons(conditions, component)) for name, conditions in recipe.classes.items())
        name, because = next(((name, because) for name, because in reasons if because is not None), ("", ""))
        if not name:
            raise RecipeError(
                f"no class takes {component.name} ({component.package or 'no package'}, {component.pins} pins, "
                f"{component.area_mm2:.1f} mm2). Add a last class without conditions, such as `others: {{}}`.",
                path="classes",
            )
        classified.append(Classified(component.name, name, because))
    members = {each.component_class for each in classified}
    findings = tuple(
        Finding(CLASS_EMPTY, f"Class {name!r} has no member on {board.name}.", Source(entry=f"classes/{name}"))
        for name in recipe.classes
        if name not in members
    )
    return tuple(classified), findings


def read_masks(recipe: Recipe, board: Board) -> tuple[ComponentMasks, tuple[Finding, ...]]:
    """Match the masks against the board; a pattern that matches nothing is a finding."""
    names = board.own_names
    masks = match_masks(recipe.masks, names)
    findings = [
        Finding(
            MASK_EMPTY,
            f"Mask pattern {pattern!r} matches no component of {board.name}.",
            Source(entry=f"masks[{index}]"),
        )
        for index, mask in enumerate(recipe.masks)
        for pattern in (*mask.avoid, *mask.clean, *mask.ignore)
        if not any(matches(own, pattern) for own in names.values())
    ]
    findings += [
        Finding(MASK_CONFLICT, f"{name} is to be avoided and to be cleaned; decide which.", Source(entry="masks"))
        for name, _ in masks.avoided
        if name in masks.required
    ]
    return masks, tuple(findings)


def _reasons(conditions: ComponentClass, component: Component) -> str | None:
    """Conditions of a class that a component meets, with its numbers; ``None`` where it does not meet one."""
    reasons = [
        _pattern("package", conditions.package, component.package),
        _pattern("refdes", conditions.refdes, component.name),
        _range("pins", conditions.pins, component.pins),
        _range("area_mm2", conditions.area_mm2, component.area_mm2),
        _range("height_mm", conditions.height_mm, component.height_mm),
        _range("standoff_mm", conditions.standoff_mm, component.gap_height_mm),
        _range("neighbour_mm", conditions.neighbour_mm, component.neighbour_mm),
        _pattern("side", [conditions.side] if conditions.side else [], component.side),
    ]
    return None if None in reasons else ", ".join(filter(None, reasons)) or "takes all that is left"


def _pattern(what: str, patterns: Sequence[str], value: str) -> str | None:
    if not patterns:
        return ""
    hit = next((pattern for pattern in patterns if matches(value, pattern)), None)
    return None if hit is None else f"{what} {value} is {hit}"


def _range(what: str, conditions: Range | None, value: float | None) -> str | None:
    if conditions is None:
        return ""
    if value is None or not conditions.holds(value):
        return None
    ends = [f">= {conditions.min:g}"] if conditions.min is not None else []
    ends += [f"<= {conditions.max:g}"] if conditions.max is not None else []
    return f"{what} {value:.4g} {' and '.join(ends)}"
