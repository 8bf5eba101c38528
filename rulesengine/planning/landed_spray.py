"""Which share of the spray lands on the board, and from which height half of it would."""

from collections.abc import Hashable, Iterable, Sequence
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
from recipes.footprint import spray_rays
from recipes.nozzles import Nozzle
from recipes.recipe import Recipe
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
