"""Findings on where the spray of a plan goes: components that no pass serves, spray that misses the board."""

import json
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from boards.board import Board, Side
from geometry.arrays import Points, Scalars
from programs.plan import Dwell, PlanItem, SprayPass
from recipes.classes import ComponentMasks
from recipes.footprint import spray_rays
from recipes.nozzles import Nozzle
from recipes.paths import ComponentPerimeter, Raster
from recipes.recipe import Recipe, Step
from specs.finding import Finding
from specs.finding_rules import NOT_SERVED, SIDE_NOT_SPRAYED, SPRAY_BESIDE_BOARD
from specs.source import Source

_LISTED = 10
_SIDES: tuple[Side, ...] = ("top", "bottom")
LEAST_SHARE = 0.5
"""Of a template's spray; less is a finding."""
_RAYS = 360
_POSES = 96
"""Of a template: evenly chosen in time."""
_LOWEST = 0.2
"""Share of the height below which no height is proposed."""
_HALVINGS = 6
_FLATTEST = 1e-3


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
    others = [step.model_copy(update={"side": here.side}) for step in steps if step.side != here.side]
    lines = [f"`- {_flow(each.model_dump(mode='json', exclude_defaults=True))}`" for each in others]
    advice = f"Add to the sequence: {', '.join(dict.fromkeys(lines))}"
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


def _flow(value: object) -> str:
    """Write plain data as YAML in one line; names of a recipe need no quotes."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key}: {_flow(each)}' for key, each in cast('Mapping[str, object]', value).items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_flow, cast('list[object]', value)))}]"
    return value if isinstance(value, str) else json.dumps(value)


@dataclass(frozen=True, slots=True)
class Landed:
    """The spray of one template in one step."""

    made_by: Source
    seconds: float
    """For which it is sprayed, at the programmed speed."""
    height_mm: float
    """Mean height of the orifice above the surface."""
    share: float
    """That lands on the board."""
    mended_mm: float | None
    """Greatest height from which half of it would; ``None`` where more does already, or from no height."""


class _Piece(NamedTuple):
    """Stretches (k,) of a way, each at one speed with the nozzle held as at its beginning."""

    nozzle: str
    begin: Points
    end: Points
    axes: NDArray[np.float64]
    """(k, 3, 3); rows: tool x, y, z"""
    seconds: Scalars


def landed_shares(recipe: Recipe, board: Board, items: Iterable[PlanItem]) -> list[Landed]:
    """Follow the spray of each template in each step to the plane of the board; gas is left out.

    Heights of components do not count: what would hit one beyond the rim is taken to miss the board.

    Args:
        recipe: Has the nozzles.
        board: Whose outline and cut-outs.
        items: Of a plan.

    Returns:
        In the order of the first pass of each.
    """
    ways: dict[Source, list[_Piece]] = {}
    last: SprayPass | None = None
    for item in items:
        if not isinstance(item, SprayPass | Dwell) or not item.jet.liquid:
            continue
        last = item if isinstance(item, SprayPass) else last
        if last is None:
            continue
        pieces = ways.setdefault(item.made_by.place, [])
        if isinstance(item, SprayPass):
            lengths = np.linalg.norm(np.diff(item.tcp, axis=0), axis=1)
            pieces.append(_piece(item, slice(-1), item.tcp[1:], lengths / item.speeds_mm_s))
        else:
            pieces.append(_piece(last, slice(-1, None), last.tcp[-1:], np.array([item.duration_s])))
    return [
        _landed(made_by, pieces, recipe, board)
        for made_by, pieces in ways.items()
        if sum(float(piece.seconds.sum()) for piece in pieces) > 0.0
    ]


def _piece(item: SprayPass, at: slice, end: Points, seconds: Scalars) -> _Piece:
    x, z = item.reference[at], item.approach[at]
    return _Piece(item.jet.nozzle, item.tcp[at], end, np.stack([x, np.cross(z, x), z], axis=1), seconds)


def find_spray_beside(recipe: Recipe, board: Board, items: Iterable[PlanItem]) -> list[Finding]:
    """One finding for each template of which less than half of the spray lands on the board."""
    findings: list[Finding] = []
    for each in landed_shares(recipe, board, items):
        if each.share < LEAST_SHARE:
            advice = (
                "No lower height makes it half: keep the path farther inside the board."
                if each.mended_mm is None
                else f"From {each.mended_mm:.0f} mm half of it would: lower height_mm, or keep the path farther inside."
            )
            message = f"{each.share:.0%} of the spray lands on the board from {each.height_mm:.0f} mm. {advice}"
            findings.append(Finding(SPRAY_BESIDE_BOARD, message, each.made_by))
    return findings


def _landed(made_by: Source, pieces: Sequence[_Piece], recipe: Recipe, board: Board) -> Landed:
    """Follow the spray from poses that stand for the same time each."""
    begin, end, axes, seconds = (np.concatenate([piece[at] for piece in pieces]) for at in range(1, 5))
    until = np.cumsum(seconds)
    moments = (np.arange(_POSES) + 0.5) / _POSES * until[-1]
    which = np.minimum(np.searchsorted(until, moments), len(until) - 1)
    done = 1.0 - (until[which] - moments) / np.where(seconds[which] > 0.0, seconds[which], 1.0)
    tcp = begin[which] + done[:, None] * (end[which] - begin[which])
    side: Side = "top" if axes[0, 2, 2] < 0 else "bottom"
    drop = board.surface_z_mm(side) - tcp[:, 2]
    poses = np.concatenate([tcp[:, :2], drop[:, None], axes[which].reshape(_POSES, 9)], axis=1)
    nozzle = cast(Hashable, recipe.nozzles[pieces[0].nozzle])
    share, mended = _follow(poses.tobytes(), nozzle, board.outline)
    height = float(np.mean(np.abs(drop)))
    return Landed(made_by, float(until[-1]), height, share, None if mended is None else mended * height)


@lru_cache(maxsize=64)  # an edit leaves the spray of most templates as it was, and a report gives all of it anew
def _follow(content: bytes, nozzle: Nozzle, outline: Polygon) -> tuple[float, float | None]:
    """Share of the spray that lands inside an outline, and the greatest share of the height from which half would.

    Args:
        content: (n, 12) poses: x, y, z from the orifice to the surface, and the tool's axes, row by row.
        nozzle: What sprays.
        outline: Of the board.
    """
    shapely.prepare(outline)
    poses = np.frombuffer(content).reshape(_POSES, 12)
    poles, drop, axes = poses[:, :2], poses[:, 2:3], poses[:, 3:].reshape(_POSES, 3, 3)
    # Other rays at every pose: those of all poses together are spread evenly.
    rays = spray_rays(nozzle, _POSES * _RAYS)
    slopes, weights = rays.slopes.reshape(_POSES, _RAYS, 2), rays.weights.reshape(_POSES, _RAYS)
    ways = np.concatenate([slopes, np.ones((_POSES, _RAYS, 1))], axis=2) @ axes
    # Rays that do not fall towards the board miss it wherever they go.
    falling = ways[..., 2] * np.sign(drop) > _FLATTEST
    places = poles[:, None] + ways[..., :2] * (drop / np.where(falling, ways[..., 2], np.inf))[..., None]
    poles = poles + axes[:, 2, :2] * (drop / axes[:, 2, 2:])
    around = places - poles[:, None]

    def share(factor: float) -> float:
        spots = poles[:, None] + factor * around
        lands = shapely.contains_xy(outline, spots[..., 0], spots[..., 1]) & falling
        return float(np.sum(lands * weights))

    now = share(1.0)
    if now >= LEAST_SHARE or share(_LOWEST) < LEAST_SHARE:
        return now, None
    low, high = _LOWEST, 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if share(middle) >= LEAST_SHARE else (low, middle)
    return now, low
