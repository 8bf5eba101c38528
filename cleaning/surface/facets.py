"""The board's surface in facets, gathered in cells that are large enough to be hit by enough rays."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from cleaning.surface.sky_view import open_share
from geometry.arrays import Directions, Indices, Points, Scalars, Triangles
from geometry.mesh import boxes_of, middles_of
from geometry.rays import RayScene, build_ray_scene

_TIE = 1e-6
"""Coordinates are rounded to this share of a cell: no facet changes its cell for the last bits of a float."""
_ASIDE = 1.7e-4
"""Borders of cells are moved by this share, so that what is regular does not lie on them."""
_COSINE = 1e-3


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
    component: Indices
    """(m,) index into the board's components; -1 for the bare board and fixtures."""
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
        component=component,
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
    places = middles_of(scene.triangles) @ turn.T
    turned = (scene.triangles.reshape(-1, 3) @ turn.T).reshape(-1, 3, 3)
    block, counts = _blocks(places, turned, scene.body, len(board.bodies), cell_mm)
    # The coordinate direction that each normal is nearest to; up and down come first where two are equal.
    rounded = np.round((scene.normals @ turn.T)[:, (2, 0, 1)] / _COSINE).astype(np.int64)
    axes = np.argmax(np.abs(rounded), axis=1)
    key = scene.body * 6 + axes * 2 + (np.take_along_axis(rounded, axes[:, None], axis=1)[:, 0] < 0)
    for axis in range(3):
        key = key * (counts[:, axis].max() + 1) + block[:, axis]
    return np.unique(key, return_inverse=True)[1].astype(np.int64)


def _blocks(places: Points, triangles: Points, body: Indices, bodies: int, cell_mm: float) -> tuple[Indices, Indices]:
    """(m, 3) block of each face within its body, and (bodies, 3) how many there are."""
    low, high = np.full((bodies, 3), np.inf), np.full((bodies, 3), -np.inf)
    starts = np.flatnonzero(np.diff(body, prepend=-1))
    lowest, highest = boxes_of(triangles)
    low[body[starts]] = np.minimum.reduceat(lowest, starts, axis=0)
    high[body[starts]] = np.maximum.reduceat(highest, starts, axis=0)
    extent = np.where(np.isfinite(high - low), high - low, 0.0)
    counts = np.maximum(np.round(np.round(extent / cell_mm / _TIE) * _TIE), 1).astype(np.int64)
    share = (places - low[body]) / np.maximum(extent[body], 1e-9) * counts[body]
    block = np.floor(np.round(share / _TIE) * _TIE + _ASIDE).astype(np.int64)
    return np.clip(block, 0, counts[body] - 1), counts


def _means(values: Points, weights: Scalars, cell: Indices, total: Scalars) -> Points:
    """(c, 3) weighted means of (m, 3) values."""
    return np.column_stack([np.bincount(cell, values[:, i] * weights, len(total)) / total for i in range(3)])
