"""Which share of the spray lands on the board, and from which height half of it would."""

from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import cast

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from boards.board import Board, Side
from geometry.arrays import Points
from programs.plan import Dwell, PlanItem, SprayPass
from recipes.nozzles import Nozzle
from recipes.recipe import Recipe
from recipes.spray_rays import spray_rays
from specs.finding import Finding
from specs.finding_rules import SPRAY_BESIDE_BOARD
from specs.source import Source

LEAST_SHARE = 0.5
"""Of a template's spray; less is a finding."""
_RAYS = 360
_POSES = 96
"""Of a template: evenly chosen in time."""
_LOWEST = 0.2
"""Share of the height below which no height is proposed."""
_HALVINGS = 6
_FLATTEST = 1e-3


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


@dataclass(slots=True)
class _Way:
    """Where the open nozzle goes with one template in one step, piece by piece."""

    nozzle: str
    begin: list[Points] = field(default_factory=list[Points])
    """(3,) each"""
    end: list[Points] = field(default_factory=list[Points])
    axes: list[NDArray[np.float64]] = field(default_factory=list[NDArray[np.float64]])
    """(3, 3) each; rows: tool x, y, z"""
    seconds: list[float] = field(default_factory=list[float])


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
    found = _ways_of(items)
    return [_landed(made_by, way, recipe, board) for made_by, way in found.items() if sum(way.seconds) > 0.0]


def find_spray_beside(recipe: Recipe, board: Board, items: Iterable[PlanItem]) -> list[Finding]:
    """One finding for each template of which less than half of the spray lands on the board."""
    return [
        Finding(SPRAY_BESIDE_BOARD, _message(each), each.made_by)
        for each in landed_shares(recipe, board, items)
        if each.share < LEAST_SHARE
    ]


def _message(landed: Landed) -> str:
    words = f"{landed.share:.0%} of the spray lands on the board from {landed.height_mm:.0f} mm."
    if landed.mended_mm is None:
        return f"{words} No lower height makes it half: keep the path farther inside the board."
    return f"{words} From {landed.mended_mm:.0f} mm half of it would: lower height_mm, or keep the path farther inside."


def _ways_of(items: Iterable[PlanItem]) -> dict[Source, _Way]:
    found: dict[Source, _Way] = {}
    last: SprayPass | None = None
    for item in items:
        if isinstance(item, SprayPass) and item.jet.liquid:
            last = item
            way = found.setdefault(item.made_by.place, _Way(item.jet.nozzle))
            lengths = np.linalg.norm(np.diff(item.tcp, axis=0), axis=1)
            for at, seconds in enumerate((lengths / item.speeds_mm_s).tolist()):
                _add(way, item, (at, at + 1), seconds)
        elif isinstance(item, Dwell) and item.jet.liquid and last is not None:
            _add(found.setdefault(item.made_by.place, _Way(item.jet.nozzle)), last, (-1, -1), item.duration_s)
    return found


def _add(way: _Way, item: SprayPass, ends: tuple[int, int], seconds: float) -> None:
    begin, end = ends
    way.begin.append(item.tcp[begin])
    way.end.append(item.tcp[end])
    x, z = item.reference[begin], item.approach[begin]
    way.axes.append(np.stack([x, np.cross(z, x), z]))
    way.seconds.append(seconds)


def _landed(made_by: Source, way: _Way, recipe: Recipe, board: Board) -> Landed:
    side: Side = "top" if way.axes[0][2, 2] < 0 else "bottom"
    until, tcp, axes = _poses(way)
    drop = board.surface_z_mm(side) - tcp[:, 2]
    poses = np.concatenate([tcp[:, :2], drop[:, None], axes.reshape(_POSES, 9)], axis=1)
    share, mended = _follow(poses.tobytes(), cast(Hashable, recipe.nozzles[way.nozzle]), board.outline)
    height = float(np.mean(np.abs(drop)))
    return Landed(made_by, until, height, share, None if mended is None else mended * height)


def _poses(way: _Way) -> tuple[float, Points, NDArray[np.float64]]:
    """Seconds of a way, and (n, 3) places and (n, 3, 3) axes of poses that stand for the same time each."""
    until = np.cumsum(way.seconds)
    moments = (np.arange(_POSES) + 0.5) / _POSES * until[-1]
    piece = np.minimum(np.searchsorted(until, moments), len(until) - 1)
    seconds = np.array(way.seconds)[piece]
    done = 1.0 - (until[piece] - moments) / np.where(seconds > 0.0, seconds, 1.0)
    begin, end, axes = np.array(way.begin)[piece], np.array(way.end)[piece], np.array(way.axes)[piece]
    return float(until[-1]), begin + done[:, None] * (end - begin), axes


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
    return now, None if now >= LEAST_SHARE else _mended(share)


def _mended(share: Callable[[float], float]) -> float | None:
    """Greatest share of the height from which half of the spray would land; ``None`` if there is none."""
    low, high = _LOWEST, 1.0
    if share(low) < LEAST_SHARE:
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if share(middle) >= LEAST_SHARE else (low, middle)
    return low
