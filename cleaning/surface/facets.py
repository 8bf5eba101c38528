"""The board's surface, fine enough to say where it is wet."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from cleaning.surface.cells import cells_of
from cleaning.surface.ray_scene import Scene
from cleaning.surface.sky_view import open_share
from geometry.arrays import Directions, Indices, Points, Scalars, Triangles


@dataclass(frozen=True, slots=True, eq=False)
class Facets:
    """Triangles of all bodies, none longer than asked, and the cells into which small ones are gathered.

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


def build_facets(board: Board, scene: Scene, cell_mm: float = 1.5) -> Facets:
    """Gather the faces of a scene in cells, and find which are exposed.

    Args:
        board: The scene's board.
        scene: ``build_scene`` of it, which also says how long edges may be; facet i is its face i.
        cell_mm: About how large a cell is.
    """
    share = open_share(board, scene)
    cell = cells_of(board, scene, cell_mm)
    count = int(cell.max()) + 1
    areas = scene.areas_mm2
    whole = np.bincount(cell, areas, count)
    exposed = np.bincount(cell, areas * share, count)
    weights = np.where(exposed[cell] > 0, areas * share, areas)
    total = np.where(exposed > 0, exposed, whole)
    centres = _means(scene.triangles.mean(axis=1), weights, cell, total)
    normals = _means(scene.normals, weights, cell, total)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    component = _components(board)[scene.body]
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


def _components(board: Board) -> Indices:
    """(bodies,) index into the board's components, or -1."""
    known = {component.name: index for index, component in enumerate(board.components)}
    return np.array([known.get(body.name, -1) for body in board.bodies], dtype=np.int64)


def _means(values: Points, weights: Scalars, cell: Indices, total: Scalars) -> Points:
    """(c, 3) weighted means of (m, 3) values."""
    return np.column_stack([np.bincount(cell, values[:, i] * weights, len(total)) / total for i in range(3)])
