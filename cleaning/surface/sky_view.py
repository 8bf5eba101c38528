"""Which facets see the open sky, so that spray may reach them at all."""

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from geometry.arrays import Directions, Indices, Points, Scalars
from geometry.compiled import compiled
from geometry.mesh import middles_of
from geometry.rays import RayScene, are_blocked

_DIRECTIONS = 24
_ENOUGH = 4
"""Free directions that make a place exposed: gaps between leads, of which a nozzle sees a sliver at best, are not."""
_FACING = 1e-3
_WIDEST = np.radians(60.0)
_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
_LIFT_MM = 2e-3
"""Rays begin this far off their facet."""
_SIDEWAYS = 0.1
"""A bare surface whose normal is flatter than this belongs to the rim and looks at both sides."""
_SMALL_MM2 = 0.05
"""Facets below this are judged at their middle alone."""
_CORNERS = np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6.0
"""Three places inside a triangle, barycentric: their mean integrates squares exactly."""


def open_share(board: Board, scene: RayScene) -> Scalars:
    """(m,) share of each face that sees enough sky of its own side: 0, 1/3, 2/3 or 1.

    A place sees sky if four of 24 directions within 60 degrees of the side's normal lead away from its facet and hit
    nothing. The side is that of the body's component, or beyond the other surface of the board the other one; bare
    board and fixtures look where their facets look, and to both sides from a rim.
    """
    middles = middles_of(scene.triangles)
    small = scene.areas_mm2 < _SMALL_MM2
    seen = np.zeros((len(small), 3), dtype=np.bool_)
    up, down = _looks(board, scene)
    for sign, looks in ((1.0, up), (-1.0, down)):
        for corner in range(3):
            which = np.flatnonzero(looks & ~seen[:, corner] & ~(small & (corner > 0)))
            inside = np.tensordot(scene.triangles[which], _CORNERS[corner], axes=(1, 0))
            places = np.where(small[which, None], middles[which], inside)
            seen[which, corner] = _sees(scene, places, scene.normals[which], _sky(board, sign))
    seen[small, 1:] = seen[small, :1]
    return np.count_nonzero(seen, axis=1) / 3.0


def _looks(board: Board, scene: RayScene) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(m,) whether a face looks for the sky above, and for that below."""
    sides = {component.name: component.side for component in board.components}
    side = np.array([{"top": 1, "bottom": -1}.get(sides.get(body.name, ""), 0) for body in board.bodies])[scene.body]
    middle = scene.triangles[:, :, 2].mean(axis=1)
    through_down = middle < board.bottom_z_mm - _LIFT_MM
    through_up = middle > board.top_z_mm + _LIFT_MM
    slope = scene.normals[:, 2]
    up = np.where(side == 0, slope > -_SIDEWAYS, ((side > 0) & ~through_down) | ((side < 0) & through_up))
    down = np.where(side == 0, slope < _SIDEWAYS, ((side < 0) & ~through_up) | ((side > 0) & through_down))
    return up, down


def _sky(board: Board, sign: float) -> Directions:
    """(24, 3) directions within 60 degrees of a side's normal, the steepest first; they turn with the board."""
    count = np.arange(_DIRECTIONS)
    upward = 1.0 - (1.0 - np.cos(_WIDEST)) * count / (_DIRECTIONS - 1)
    azimuth = 2 * np.pi * _GOLDEN * count + np.arctan2(board.axis[1], board.axis[0])
    sine = np.sqrt(1.0 - upward**2)
    return np.column_stack([sine * np.cos(azimuth), sine * np.sin(azimuth), sign * upward])


def _sees(scene: RayScene, places: Points, normals: Directions, sky: Directions) -> NDArray[np.bool_]:
    """(n,) whether enough directions of the sky are free.

    Places that have seen enough are skipped, and those that no longer can.
    """
    free, left = np.zeros(len(places), dtype=np.int8), np.empty(len(places), dtype=np.int8)
    starts = np.empty((len(places), 3), dtype=np.float32)
    _count_facing(normals, sky, left)
    active = np.flatnonzero(left >= _ENOUGH)
    for direction in sky:
        which, active = _look_along(direction, (places, normals, scene.origin), (active, free, left), starts)
        rays = np.ascontiguousarray(np.broadcast_to(direction.astype(np.float32), (len(which), 3)))
        blocked = are_blocked(scene, starts[: len(which)], rays)
        free[which] += ~blocked
        left[which] -= blocked
    return free >= _ENOUGH


@compiled
def _count_facing(normals: Directions, sky: Directions, count: NDArray[np.int8]) -> None:
    """Fill how many directions of the sky lie before each of (n,) facets."""
    for place in range(len(normals)):
        count[place] = 0
        for k in range(len(sky)):
            along = normals[place, 0] * sky[k, 0] + normals[place, 1] * sky[k, 1] + normals[place, 2] * sky[k, 2]
            count[place] += along > _FACING


@compiled
def _look_along(
    direction: NDArray[np.float64],
    facets: tuple[Points, Directions, NDArray[np.float64]],
    looking: tuple[Indices, NDArray[np.int8], NDArray[np.int8]],
    starts: NDArray[np.float32],
) -> tuple[Indices, Indices]:
    """Lay rays in one direction from the places that may still see enough and have not yet.

    Args:
        direction: (3,) of the sky.
        facets: (n, 3) places, (n, 3) normals, and (3,) origin from which the rays are counted.
        looking: (k,) places to look from, and of all (n,) how many directions were free, and how many were so or may
            still be.
        starts: (n, 3) what is filled.

    Returns:
        (r,) place of each ray, and (l,) the places that are not done.
    """
    (places, normals, origin), (active, free, left) = facets, looking
    rays, kept = np.empty(len(active), dtype=np.int64), np.empty(len(active), dtype=np.int64)
    count, keep = 0, 0
    for place in active:
        if free[place] >= _ENOUGH or left[place] < _ENOUGH:
            continue
        kept[keep] = place
        keep += 1
        along = 0.0
        for axis in range(3):
            along += normals[place, axis] * direction[axis]
            starts[count, axis] = places[place, axis] - origin[axis] + _LIFT_MM * normals[place, axis]
        if along > _FACING:
            rays[count] = place
            count += 1
    return rays[:count], kept[:keep]
