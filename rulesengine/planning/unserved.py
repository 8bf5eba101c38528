"""Passes that serve each component, and findings on components that none serves."""

from collections.abc import Iterable, Sequence

from boards.board import Board, Side
from programs.plan import PlanItem, SprayPass
from recipes.paths import ComponentPerimeter
from recipes.recipe import Recipe, Step
from rulesengine.strokes.classify import ComponentMasks
from specs.finding import Finding
from specs.finding_rules import NOT_SERVED, SIDE_NOT_SPRAYED
from specs.source import Source


def served_by(items: Iterable[PlanItem]) -> dict[str, list[str]]:
    """Component name to the templates in their steps whose passes follow it, such as ``"sequence[0]/around"``."""
    places: dict[str, dict[str, None]] = {}
    for item in items:
        if isinstance(item, SprayPass):
            for name in item.made_by.components:
                places.setdefault(name, {})[str(item.made_by.place)] = None
    return {name: list(found) for name, found in places.items()}


def find_unserved(
    recipe: Recipe, board: Board, masks: ComponentMasks, steps: Sequence[Step], items: Iterable[PlanItem]
) -> list[Finding]:
    """One finding for each component that must be cleaned and is not, one for a side most of which is not sprayed.

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
    return findings + [found for side in ("top", "bottom") for found in _side(board, side, masks, list(items))]


def _side(board: Board, side: Side, masks: ComponentMasks, items: Sequence[PlanItem]) -> list[Finding]:
    """Whether most components of a side are neither followed by a pass of their own nor swept across."""
    passes = [each for each in items if isinstance(each, SprayPass) and (each.approach[0, 2] < 0) == (side == "top")]
    served, masked = served_by(passes), {*dict(masks.avoided), *masks.ignored}
    here = [each.name for each in board.components if each.side == side and each.name not in masked]
    left = [name for name in here if name not in served]
    if 2 * len(left) <= len(here) or any(each.made_by.template and not each.made_by.components for each in passes):
        return []
    advice = f"Add steps with side: {side}"
    message = f"No step sprays the {side} side, where {len(left)} components are. {advice}."
    if passes:
        advice = "Add a template that goes across it, such as a raster, or give more classes passes"
        message = f"The steps on the {side} side spray {len(here) - len(left)} of its {len(here)} components. {advice}."
    return [Finding(SIDE_NOT_SPRAYED, message, Source(entry="sequence"))]
