"""Passes that serve each component, and findings on components that none serves."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

from boards.board import Board, Side
from programs.plan import PlanItem, SprayPass
from recipes.classes import ComponentMasks
from recipes.paths import ComponentPerimeter, Raster
from recipes.recipe import Recipe, Step
from specs.finding import Finding
from specs.finding_rules import NOT_SERVED, SIDE_NOT_SPRAYED
from specs.source import Source

_LISTED = 10
_SIDES: tuple[Side, ...] = ("top", "bottom")


def served_by(items: Iterable[PlanItem]) -> dict[str, list[str]]:
    """Component name to the templates in their steps whose passes follow it, such as ``"sequence[0]/around"``."""
    places: dict[str, dict[str, None]] = {}
    for item in items:
        if isinstance(item, SprayPass):
            for name in item.made_by.components:
                places.setdefault(name, {})[str(item.made_by.place)] = None
    return {name: list(found) for name, found in places.items()}


def unsprayed(board: Board, items: Iterable[PlanItem]) -> list[str]:
    """Names of components that no pass of their own follows, on sides that nothing sweeps across; masks count too."""
    passes = [item for item in items if isinstance(item, SprayPass)]
    swept: set[Side] = {
        "top" if each.approach[0, 2] < 0 else "bottom"
        for each in passes
        if each.made_by.template and not each.made_by.components
    }
    served = served_by(passes)
    return [each.name for each in board.components if each.side not in swept and each.name not in served]


def find_unserved(
    recipe: Recipe, board: Board, masks: ComponentMasks, steps: Sequence[Step], items: Iterable[PlanItem]
) -> list[Finding]:
    """One finding for each component that must be cleaned and is not, one for a side with some that are not sprayed.

    Where a step follows components, a component is cleaned by a pass of its own; where none does, by what goes
    across the whole side.
    """
    sprayed = {step.side for step in steps}
    followed = {
        step.side
        for step in steps
        if any(isinstance(recipe.templates[name], ComponentPerimeter) for name in step.paths)
    }
    served = served_by(items)
    findings: list[Finding] = []
    for component in board.components:
        if component.name not in masks.required or component.name in dict(masks.avoided):
            continue  # what is avoided too is a conflict, found where the masks are read
        reason = ""
        if component.side not in sprayed:
            reason = f"no step sprays the {component.side} side. Add one with side: {component.side}"
        elif component.side in followed and component.name not in served:
            reason = "no pass goes around it. Give its class passes, or move the masks that keep them out"
        if reason:
            place = component.outline.centroid
            message = f"{component.name} must be cleaned, but {reason}."
            where = (place.x, place.y, board.surface_z_mm(component.side))
            findings.append(Finding(NOT_SERVED, message, Source(entry="masks"), where))
    return findings + _find_unsprayed_sides(recipe, board, masks, steps, list(items))


def _find_unsprayed_sides(
    recipe: Recipe, board: Board, masks: ComponentMasks, steps: Sequence[Step], items: Sequence[PlanItem]
) -> list[Finding]:
    """A finding for each side with components that are not sprayed; an error where nothing but a bare side is."""
    passes = [each for each in items if isinstance(each, SprayPass)]
    masked = {*dict(masks.avoided), *masks.ignored}
    missed = {*unsprayed(board, passes)}
    names = {side: [each.name for each in board.components if each.side == side] for side in _SIDES}
    sides = [
        _SideOf(
            side,
            [each for each in passes if (each.approach[0, 2] < 0) == (side == "top")],
            [name for name in names[side] if name not in masked],
            [name for name in names[side] if name in missed and name not in masked],
        )
        for side in _SIDES
    ]
    bare = bool(passes) and not any(each.passes and each.components for each in sides)
    return [found for each in sides for found in _side(each, recipe, steps, bare=bare)]


@dataclass(frozen=True, slots=True)
class _SideOf:
    """A side of a board: the passes over it, and the names of its components that no mask keeps out."""

    side: Side
    passes: Sequence[SprayPass]
    components: Sequence[str]
    missed: Sequence[str]
    """Those that nothing sprays."""


def _side(here: _SideOf, recipe: Recipe, steps: Sequence[Step], *, bare: bool) -> list[Finding]:
    """Whether components of a side are neither followed by a pass of their own nor swept across."""
    count = len(here.components)
    if not here.missed:
        return []
    place = Source(entry="sequence")
    if here.passes:
        advice = f"{_across(here.side, recipe, steps)}, or give their classes passes"
        what = f"{len(here.missed)} of its {count} components: {_listed(here.missed)}"
        return [Finding(SIDE_NOT_SPRAYED, f"The steps on the {here.side} side do not spray {what}. {advice}", place)]
    advice = f"Add to the sequence: {', '.join(_steps_for(here.side, steps))}"
    if not bare:
        are = "1 component is" if count == 1 else f"{count} components are"
        message = f"No step sprays the {here.side} side, where {are}: {_listed(here.missed)}. {advice}"
        return [Finding(SIDE_NOT_SPRAYED, message, place)]
    message = f"Only the other side is sprayed, and all {count} components are on the {here.side}. {advice}"
    return [Finding(SIDE_NOT_SPRAYED, message, place, override="error")]


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(names[:_LISTED]) + more


def _across(side: Side, recipe: Recipe, steps: Sequence[Step]) -> str:
    """Advise a step that goes across a side, by a raster that the recipe has already where it has one."""
    rasters = [name for name, template in recipe.templates.items() if isinstance(template, Raster)]
    own = [step for step in steps if step.side == side]
    if not rasters or not own:
        return "Add a template that goes across it, such as a raster"
    step = own[0].model_copy(update={"paths": [rasters[0]]})
    return f"Add to the sequence: `- {_flow(step.model_dump(mode='json', exclude_defaults=True))}`"


def _steps_for(side: Side, steps: Sequence[Step]) -> list[str]:
    """Write the steps of a sequence for another side, as lines of YAML."""
    changed = [step.model_copy(update={"side": side}) for step in steps if step.side != side]
    return list(dict.fromkeys(f"`- {_flow(each.model_dump(mode='json', exclude_defaults=True))}`" for each in changed))


def _flow(value: object) -> str:
    """Write plain data as YAML in one line; names of a recipe need no quotes."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key}: {_flow(each)}' for key, each in cast('Mapping[str, object]', value).items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_flow, cast('list[object]', value)))}]"
    return value if isinstance(value, str) else json.dumps(value)
