"""What a click meets: the body under it, or the stroke in front of it. Board frame, millimetres."""

from dataclasses import dataclass

import numpy as np

from boards.board import Board
from geometry.arrays import Indices, Points, Triangles
from webui.layers.ground import body_of_triangle
from webui.layers.strokes import StrokeLine

_PARALLEL = 1e-12
_NEAR = 0.008
"""How far beside a stroke a click still means it, as a share of its distance from the eye: about 8 pixels."""


@dataclass(frozen=True, slots=True, eq=False)
class Hit:
    """Where a ray first meets a body."""

    body: str
    point: Points
    """(3,)"""
    distance_mm: float


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """A board laid out for many rays."""

    patches: Triangles
    owner: Indices
    """(n,) body of each patch."""
    names: tuple[str, ...]


def target_of(board: Board) -> Target:
    """Lay a board out for rays."""
    return Target(
        patches=np.concatenate([body.patches for body in board.bodies]),
        owner=body_of_triangle(board),
        names=tuple(body.name for body in board.bodies),
    )


def first_hit(target: Target, origin: Points, direction: Points) -> Hit | None:
    """Find the first body along a ray (Moeller and Trumbore 1997, all patches at once).

    Args:
        target: What the ray may meet.
        origin: (3,) where it begins.
        direction: (3,) its direction, of any length.
    """
    along = direction / np.linalg.norm(direction)
    corner, first, second = target.patches[:, 0], *np.moveaxis(target.patches[:, 1:] - target.patches[:, :1], 1, 0)
    across = np.cross(along, second)
    volume = np.einsum("ij,ij->i", first, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = np.where(np.abs(volume) > _PARALLEL, 1.0 / volume, np.nan)
    away = origin - corner
    u = np.einsum("ij,ij->i", away, across) * inverse
    over = np.cross(away, first)
    v = over @ along * inverse
    distance = np.einsum("ij,ij->i", second, over) * inverse
    inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0)
    if not inside.any():
        return None
    nearest = int(np.argmin(np.where(inside, distance, np.inf)))
    length = float(distance[nearest])
    return Hit(target.names[target.owner[nearest]], origin + length * along, length)


def nearest_stroke(lines: list[StrokeLine], origin: Points, direction: Points, before_mm: float) -> StrokeLine | None:
    """Find the stroke that a ray passes by most closely, in front of what it meets.

    Args:
        lines: Strokes that are shown.
        origin: (3,) where the ray begins.
        direction: (3,) its direction, of any length.
        before_mm: Strokes farther away than this are hidden.
    """
    if not lines:
        return None
    along = direction / np.linalg.norm(direction)
    segments = [line.segments for line in lines]
    owner = np.repeat(np.arange(len(lines)), [len(each) for each in segments])
    ends = np.concatenate(segments)
    begin, run = ends[:, 0] - origin, ends[:, 1] - ends[:, 0]
    share, depth = _closest(begin, run, along)
    gap = np.linalg.norm(begin + share[:, None] * run - depth[:, None] * along, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = np.where((depth > 0) & (depth < before_mm), gap / depth, np.inf)
    best = int(np.argmin(apart))
    return lines[int(owner[best])] if apart[best] < _NEAR else None


def _closest(begin: Points, run: Points, along: Points) -> tuple[Points, Points]:
    """(n,) shares of segments, and lengths along the ray from its origin, where the two are closest."""
    square = np.einsum("ij,ij->i", run, run)
    mixed, shadow = run @ along, begin @ along
    cross = square - mixed**2
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(cross > _PARALLEL, (mixed * shadow - np.einsum("ij,ij->i", run, begin)) / cross, 0.0)
    share = np.clip(share, 0.0, 1.0)
    return share, shadow + share * mixed
