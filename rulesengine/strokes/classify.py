"""Which class takes a component, and which components are served at all (Sandia 1993, rule 3)."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase

from boards.board import Board, Component
from recipes.classes import ComponentClass, Range
from recipes.errors import RecipeError
from recipes.recipe import Recipe
from specs.finding import Finding
from specs.finding_rules import CLASS_EMPTY, MASK_CONFLICT, MASK_EMPTY


@dataclass(frozen=True, slots=True)
class Classified:
    """A component's class and the rule that put it there."""

    component: str
    component_class: str
    because: str
    """The conditions that held, with the component's numbers, e.g. ``"pins 64 >= 48"``."""


@dataclass(frozen=True, slots=True)
class Service:
    """What the masks say about each component; whoever is in neither set is served like any other."""

    avoided: tuple[tuple[str, float], ...]
    """Name and margin, mm."""
    ignored: frozenset[str]
    demanded: frozenset[str]


def classify(recipe: Recipe, board: Board) -> tuple[tuple[Classified, ...], tuple[Finding, ...]]:
    """Put every component into the first class that matches it.

    Raises:
        RecipeError: a component matches no class.
    """
    classified = tuple(_first_match(recipe, component) for component in board.components)
    members = {each.component_class for each in classified}
    findings = tuple(
        Finding(CLASS_EMPTY, f"Class {name!r} has no member on {board.name}.", f"classes/{name}")
        for name in recipe.classes
        if name not in members
    )
    return classified, findings


def service(recipe: Recipe, board: Board) -> tuple[Service, tuple[Finding, ...]]:
    """Read the masks against the board; a pattern that matches nothing is a finding."""
    names = [component.name for component in board.components]
    avoided: dict[str, float] = {}
    ignored: set[str] = set()
    demanded: set[str] = set()
    findings: list[Finding] = []
    for index, mask in enumerate(recipe.masks):
        for pattern in (*mask.avoid, *mask.clean, *mask.ignore):
            hits = [name for name in names if _matches(name, pattern)]
            if not hits:
                message = f"Mask pattern {pattern!r} matches no component of {board.name}."
                findings.append(Finding(MASK_EMPTY, message, f"masks[{index}]"))
            if mask.avoid:
                avoided |= {name: max(mask.margin_mm, avoided.get(name, 0.0)) for name in hits}
            elif mask.clean:
                demanded |= set(hits)
            else:
                ignored |= set(hits)
    findings += [
        Finding(MASK_CONFLICT, f"{name} is to be avoided and to be cleaned; decide which.", "masks")
        for name in names
        if name in avoided and name in demanded
    ]
    return Service(tuple(avoided.items()), frozenset(ignored - demanded), frozenset(demanded)), tuple(findings)


def _first_match(recipe: Recipe, component: Component) -> Classified:
    for name, wanted in recipe.classes.items():
        because = _why(wanted, component)
        if because is not None:
            return Classified(component.name, name, because)
    raise RecipeError(
        f"no class takes {component.name} ({component.package or 'no package'}, {component.pins} pins, "
        f"{component.area_mm2:.1f} mm2). Add a last class without conditions, such as `others: {{}}`.",
        path="classes",
    )


def _why(wanted: ComponentClass, component: Component) -> str | None:
    """Say why a component belongs to a class; None if it does not."""
    reasons: list[str] = []
    checks: list[Callable[[], str | None]] = [
        lambda: _pattern("package", wanted.package, component.package),
        lambda: _pattern("refdes", wanted.refdes, component.name),
        lambda: _range("pins", wanted.pins, component.pins),
        lambda: _range("area_mm2", wanted.area_mm2, component.area_mm2),
        lambda: _range("height_mm", wanted.height_mm, component.height_mm),
        lambda: _range("standoff_mm", wanted.standoff_mm, component.gap_height_mm),
        lambda: _range("neighbour_mm", wanted.neighbour_mm, component.neighbour_mm),
        lambda: _pattern("side", [wanted.side] if wanted.side else [], component.side),
    ]
    for check in checks:
        reason = check()
        if reason is None:
            return None
        if reason:
            reasons.append(reason)
    return ", ".join(reasons) or "takes all that is left"


def _pattern(what: str, patterns: Iterable[str], value: str) -> str | None:
    patterns = list(patterns)
    if not patterns:
        return ""
    hit = next((pattern for pattern in patterns if _matches(value, pattern)), None)
    return None if hit is None else f"{what} {value} is {hit}"


def _matches(value: str, pattern: str) -> bool:
    return fnmatchcase(value.upper(), pattern.upper())


def _range(what: str, wanted: Range | None, value: float | None) -> str | None:
    if wanted is None:
        return ""
    if value is None or not wanted.holds(value):
        return None
    ends = [f">= {wanted.min:g}"] if wanted.min is not None else []
    ends += [f"<= {wanted.max:g}"] if wanted.max is not None else []
    return f"{what} {value:.4g} {' and '.join(ends)}"
