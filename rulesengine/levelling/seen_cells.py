"""Places of a board's surface: what a nozzle above one of its sides can see, or all that is exposed."""

from dataclasses import dataclass

import numpy as np

from boards.board import Board, Side
from cleaning.surface.facets import build_facets, build_scene
from geometry.arrays import Directions, Indices, Points
from geometry.rays import RayScene, cast

_ABOVE_MM = 50.0
_LONGEST_MM, _CELL_MM = 2.0, 1.5
"""Edges of facets at most, and about the size of cells, as the cleaning model has them."""
_FLATTEST = 0.2
"""Least cosine between a face and the board for its places to count: walls are seen from aside."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenCells:
    """n places of a surface. Board frame, mm."""

    points: Points
    """(n, 3)"""
    normals: Directions
    """(n, 3) outward."""
    surface: Indices
    """(n,) index into the board's components; -1 for the bare board and fixtures."""


def cells_of_side(board: Board, side: Side, scene: RayScene, pitch_mm: float, shift: float) -> SeenCells:
    """Find the places that are seen straight from above a side, of the bare board and of what stands on it.

    Args:
        board: Whose outline bounds the grid, which turns with its longest edge.
        side: From which.
        scene: All bodies of the board.
        pitch_mm: Of the grid.
        shift: Share of the pitch by which the grid is shifted in both directions.
    """
    x_axis = np.array([*board.axis, 0.0])
    y_axis = np.array([-board.axis[1], board.axis[0], 0.0])
    corners = np.array(board.outline.exterior.coords)[:, :2]
    along, aside = corners @ x_axis[:2], corners @ y_axis[:2]
    u, v = (np.arange(each.min() + shift * pitch_mm, each.max(), pitch_mm) for each in (along, aside))
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    up = 1.0 if side == "top" else -1.0
    heights = scene.triangles[:, :, 2] * up
    origins = grid[:, :1] * x_axis + grid[:, 1:] * y_axis
    origins[:, 2] = up * (float(heights.max()) + _ABOVE_MM)
    faces, distances = cast(scene, origins, np.tile([0.0, 0.0, -up], (len(grid), 1)))
    normals = scene.normals[np.maximum(faces, 0)]
    seen = (faces >= 0) & np.isfinite(distances) & (normals[:, 2] * up >= _FLATTEST)
    points = origins[seen]
    points[:, 2] -= up * distances[seen]
    return SeenCells(points, normals[seen], np.full(len(points), -1, dtype=np.int64))


def exposed_cells(board: Board, finer: float) -> SeenCells:
    """Find the cells of the cleaning model that see the open sky, walls and all.

    Args:
        board: Whose bodies.
        finer: 1 for cells of the model's size, less for smaller ones.
    """
    facets = build_facets(board, build_scene(board, _LONGEST_MM * finer), _CELL_MM * finer)
    some = np.flatnonzero(facets.cell_exposed)
    return SeenCells(facets.cell_centres[some], facets.cell_normals[some], facets.cell_component[some])
