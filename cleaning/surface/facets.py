"""The board's surface in facets, gathered in cells large enough to be hit by enough rays; which see the open sky."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from geometry.arrays import Directions, Indices, Points, Scalars, Triangles
from geometry.compiled import compiled
from geometry.mesh import boxes_of, middles_of
from geometry.rays import RayScene, are_blocked, build_ray_scene

_TIE = 1e-6
"""Coordinates are rounded to this share of a cell: no facet changes its cell for the last bits of a float."""
_ASIDE = 1.7e-4
"""Borders of cells are moved by this share, so that what is regular does not lie on them."""
_COSINE = 1e-3
_AT_ONCE = 1 << 18
"""Faces that are worked on together."""


@dataclass(frozen=True, slots=True, eq=False)
class Facets:
    """Triangles of all bodies, none longer than ``longest_mm``, and the cells into which small ones are gathered.

    Results are per cell: what one body shows to one of six directions within about a millimetre, large enough to be hit
    by enough rays. Board frame, mm.
    """

    triangles: Triangles
    """(m, 3, 3), wound so that the normal follows the right-hand rule."""
    normals: Directions
    """(m, 3) outward."""
    areas_mm2: Scalars
    """(m,)"""
    body: Indices
    """(m,) index into the board's bodies."""
    cell: Indices
    """(m,) cell of each facet."""
    cell_areas_mm2: Scalars
    """(c,) area that is not hidden; all of it where the whole cell is hidden."""
    cell_centres: Points
    """(c, 3) of the exposed area."""
    cell_normals: Directions
    """(c, 3) mean."""
    cell_component: Indices
    """(c,) index into the board's components; -1 for the bare board and fixtures."""
    exposed: NDArray[np.bool_]
    """(m,) whether a facet sees enough open sky over its own side to be sprayed at all; undersides do not."""
    cell_exposed: NDArray[np.bool_]
    """(c,) whether any facet of a cell is exposed."""


def build_scene(board: Board, longest_mm: float = 2.0) -> RayScene:
    """Make all bodies of a board ready for rays; no edge of a triangle stays longer. Board frame, mm."""
    body = np.repeat(np.arange(len(board.bodies)), [len(each.patches) for each in board.bodies])
    patches = np.concatenate([each.patches for each in board.bodies])
    normals = np.concatenate([each.normals for each in board.bodies])
    return build_ray_scene(patches, normals, body, longest_mm)


def build_facets(board: Board, scene: RayScene, cell_mm: float = 1.5) -> Facets:
    """Gather the faces of a scene in cells, and find which are exposed.

    Args:
        board: The scene's board.
        scene: ``build_scene`` of it, which also bounds the edges; facet i is its face i.
        cell_mm: About how large a cell is.
    """
    share = open_share(board, scene)
    cell = number_cells(board, scene, cell_mm)
    count = int(cell.max()) + 1
    areas = scene.areas_mm2
    whole = np.bincount(cell, areas, count)
    exposed = np.bincount(cell, areas * share, count)
    weights = np.where(exposed[cell] > 0, areas * share, areas)
    total = np.where(exposed > 0, exposed, whole)
    centres = _means(middles_of(scene.triangles), weights, cell, total)
    normals = _means(scene.normals, weights, cell, total)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    index = {component.name: row for row, component in enumerate(board.components)}
    component = np.array([index.get(body.name, -1) for body in board.bodies], dtype=np.int64)[scene.body]
    cell_component = np.empty(count, dtype=np.int64)
    cell_component[cell] = component
    return Facets(
        triangles=scene.triangles,
        normals=scene.normals,
        areas_mm2=areas,
        body=scene.body,
        cell=cell,
        cell_areas_mm2=total,
        cell_centres=centres,
        cell_normals=normals / np.where(lengths > 0, lengths, 1.0),
        cell_component=cell_component,
        exposed=share > 0,
        cell_exposed=exposed > 0,
    )


def number_cells(board: Board, scene: RayScene, cell_mm: float) -> Indices:
    """Number the cells: what one body shows to one of six directions in one block of about ``cell_mm``.

    Blocks divide the box of each body evenly, in a frame that turns with the board.

    Returns:
        (m,) cell of each face, numbered in the order of bodies, then by direction and block.
    """
    cosine, sine = board.axis
    turn = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    low, extent, counts = _block_counts(scene, turn, len(board.bodies), cell_mm)
    key, most = np.empty(len(scene.body), dtype=np.int64), counts.max(axis=0) + 1
    for some in _pieces(len(key)):
        body = scene.body[some]
        share = (middles_of(scene.triangles[some]) @ turn.T - low[body]) / np.maximum(extent[body], 1e-9) * counts[body]
        block = np.clip(np.floor(np.round(share / _TIE) * _TIE + _ASIDE).astype(np.int64), 0, counts[body] - 1)
        # The coordinate direction that each normal is nearest to; up and down come first where two are equal.
        rounded = np.round((scene.normals[some] @ turn.T)[:, (2, 0, 1)] / _COSINE).astype(np.int64)
        axes = np.argmax(np.abs(rounded), axis=1)
        number = body * 6 + axes * 2 + (np.take_along_axis(rounded, axes[:, None], axis=1)[:, 0] < 0)
        for axis in range(3):
            number = number * most[axis] + block[:, axis]
        key[some] = number
    return np.unique(key, return_inverse=True)[1].astype(np.int64)


def _block_counts(
    scene: RayScene, turn: NDArray[np.float64], bodies: int, cell_mm: float
) -> tuple[Points, Points, Indices]:
    """(bodies, 3) lowest corner and size of each body's box in the turned frame, and into how many it is divided."""
    low, high = np.full((bodies, 3), np.inf), np.full((bodies, 3), -np.inf)
    for some in _pieces(len(scene.body)):
        turned = (scene.triangles[some].reshape(-1, 3) @ turn.T).reshape(-1, 3, 3)
        starts = np.flatnonzero(np.diff(scene.body[some], prepend=-1))
        lowest, highest = boxes_of(turned)
        body = scene.body[some][starts]
        low[body] = np.minimum(low[body], np.minimum.reduceat(lowest, starts, axis=0))
        high[body] = np.maximum(high[body], np.maximum.reduceat(highest, starts, axis=0))
    extent = np.where(np.isfinite(high - low), high - low, 0.0)
    return low, extent, np.maximum(np.round(np.round(extent / cell_mm / _TIE) * _TIE), 1).astype(np.int64)


def _pieces(count: int) -> Iterator[slice]:
    """Cut faces into pieces: a large board has millions, and what is worked out of them is larger than they are."""
    return (slice(begin, begin + _AT_ONCE) for begin in range(0, count, _AT_ONCE))


def _means(values: Points, weights: Scalars, cell: Indices, total: Scalars) -> Points:
    """(c, 3) weighted means of (m, 3) values."""
    return np.column_stack([np.bincount(cell, values[:, i] * weights, len(total)) / total for i in range(3)])


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
    small = scene.areas_mm2 < _SMALL_MM2
    seen = np.zeros((len(small), 3), dtype=np.bool_)
    up, down = _looks(board, scene)
    for sign, looks in ((1.0, up), (-1.0, down)):
        for corner in range(3):
            which = np.flatnonzero(looks & ~seen[:, corner] & ~(small & (corner > 0)))
            for some in (which[piece] for piece in _pieces(len(which))):
                triangles = scene.triangles[some]
                inside = np.tensordot(triangles, _CORNERS[corner], axes=(1, 0))
                places = np.where(small[some, None], middles_of(triangles), inside)
                seen[some, corner] = _sees(scene, places, scene.normals[some], _sky(board, sign))
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
