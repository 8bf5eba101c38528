"""Picking by a click: the body under it, or the strokes in front of that. Board frame, millimetres."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Body, Workpiece
from geometry.arrays import Points, Scalars, Triangles
from specs.source import NO_SOURCE, Source
from webui.layers.paths.strokes import StrokeLine

_PARALLEL = 1e-12
_ROUNDING_MM = 1e-6
"""Boxes are a little larger than bodies, so that a ray along a face meets both."""
_NEAR = 0.005
"""Tolerance of a click on a stroke, as a share of its distance from the eye: about 6 pixels."""


@dataclass(frozen=True, slots=True, eq=False)
class Hit:
    """First intersection of a ray with a body."""

    body: str
    point: Points
    """(3,)"""
    distance_mm: float


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """A workpiece arranged for many rays."""

    bodies: tuple[Body, ...]
    low: Points
    """(n, 3) lowest corner of the box around each body."""
    high: Points


def target_of(workpiece: Workpiece) -> Target:
    """Arrange a workpiece for rays."""
    bodies = tuple(body for body in workpiece.pickable_bodies if len(body.patches))
    low = [body.patches.min(axis=(0, 1)) - _ROUNDING_MM for body in bodies]
    high = [body.patches.max(axis=(0, 1)) + _ROUNDING_MM for body in bodies]
    return Target(bodies, np.array(low).reshape(-1, 3), np.array(high).reshape(-1, 3))


def first_hit(target: Target, origin: Points, direction: Points) -> Hit | None:
    """First body along a ray; of two in one place the first of the file.

    Args:
        target: The workpiece.
        origin: (3,) start of the ray.
        direction: (3,) its direction, of any length.
    """
    along = direction / np.linalg.norm(direction)
    best: Hit | None = None
    for index in np.flatnonzero(_boxes_met(target, origin, along)):
        body = target.bodies[int(index)]
        length = _distance(body.patches, origin, along)
        if length < (np.inf if best is None else best.distance_mm):
            best = Hit(body.name, origin + length * along, length)
    return best


def strokes_at(
    lines: Sequence[StrokeLine], origin: Points, direction: Points, before_mm: float, within_mm: float = 0.0
) -> tuple[Source, ...]:
    """Strokes that a ray passes closely, in front of the body that it meets; the closest first.

    Args:
        lines: Visible strokes.
        origin: (3,) start of the ray.
        direction: (3,) its direction, of any length.
        before_mm: Strokes farther away than this are hidden.
        within_mm: Strokes so near to the ray count too, also where that is many pixels.
    """
    if not lines:
        return ()
    along = direction / np.linalg.norm(direction)
    segments = [line.segments for line in lines]
    ends = np.concatenate(segments)
    begin, run = ends[:, 0] - origin, ends[:, 1] - ends[:, 0]
    share, depth = _closest(begin, run, along)
    gap = np.linalg.norm(begin + share[:, None] * run - depth[:, None] * along, axis=1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        reach = np.maximum(_NEAR * depth, within_mm)
        apart = np.where((depth > 0) & (depth < before_mm), gap / reach, np.inf)
    firsts = np.cumsum([0, *(len(each) for each in segments[:-1])])
    closest = np.minimum.reduceat(apart, firsts)
    order = np.argsort(np.round(closest, 3), kind="stable")
    return tuple(dict.fromkeys(lines[int(index)].made_by for index in order if closest[index] < 1.0))


def choose_stroke(makers: Sequence[Source], selected: Source) -> Source:
    """The closest stroke under a click; click after click, the next one there."""
    if selected not in makers:
        return makers[0] if makers else NO_SOURCE
    there = sorted(makers, key=str)
    return there[(there.index(selected) + 1) % len(there)]


def _boxes_met(target: Target, origin: Points, along: Points) -> NDArray[np.bool_]:
    """(n,) which boxes a ray passes through (slabs: Kay and Kajiya 1986)."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        one, other = (target.low - origin) / along, (target.high - origin) / along
        enter = np.fmax.reduce(np.fmin(one, other), axis=1)
        leave = np.fmin.reduce(np.fmax(one, other), axis=1)
    return (enter <= leave) & (leave > 0)


def _distance(patches: Triangles, origin: Points, along: Points) -> float:
    """Distance along a ray of unit direction to the first patch, else infinity (Moeller and Trumbore 1997)."""
    corner = patches[:, 0]
    first, second = patches[:, 1] - corner, patches[:, 2] - corner
    across = np.cross(along, second)
    volume = np.einsum("ij,ij->i", first, across)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        inverse = np.where(np.abs(volume) > _PARALLEL, 1.0 / volume, np.nan)
    away = origin - corner
    over = np.cross(away, first)
    u = np.einsum("ij,ij->i", away, across) * inverse
    v = over @ along * inverse
    distance = np.einsum("ij,ij->i", second, over) * inverse
    inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0)
    return float(np.min(distance, where=inside, initial=np.inf))


def _closest(begin: Points, run: Points, along: Points) -> tuple[Scalars, Scalars]:
    """(n,) shares of segments, and lengths along the ray, at the closest points of both."""
    square = np.einsum("ij,ij->i", run, run)
    mixed, shadow = run @ along, begin @ along
    cross = square - mixed**2
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = np.where(cross > _PARALLEL, (mixed * shadow - np.einsum("ij,ij->i", run, begin)) / cross, 0.0)
    share = np.clip(share, 0.0, 1.0)
    return share, shadow + share * mixed
