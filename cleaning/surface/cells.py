"""Gathering facets into cells that are large enough to be hit by enough rays."""

import numpy as np

from boards.board import Board
from cleaning.surface.ray_scene import Scene
from geometry.arrays import Indices, Points

_TIE = 1e-6
"""Coordinates are rounded to this share of a cell: no facet changes its cell for the last bits of a float."""
_ASIDE = 1.7e-4
"""Borders of cells are moved by this share, so that what is regular does not lie on them."""
_COSINE = 1e-3


def cells_of(board: Board, scene: Scene, cell_mm: float) -> Indices:
    """Number the cells: what one body shows to one of six directions in one block of about ``cell_mm``.

    Blocks divide the box of each body evenly, in a frame that turns with the board.

    Returns:
        (m,) cell of each face, numbered in the order of bodies, then by direction and block.
    """
    cosine, sine = board.axis
    turn = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    places = scene.triangles.mean(axis=1) @ turn.T
    block, counts = _blocks(places, scene.triangles @ turn.T, scene.body, len(board.bodies), cell_mm)
    key = scene.body * 6 + _six_ways(scene.normals @ turn.T)
    for axis in range(3):
        key = key * (counts[:, axis].max() + 1) + block[:, axis]
    return np.unique(key, return_inverse=True)[1].astype(np.int64)


def _blocks(places: Points, triangles: Points, body: Indices, bodies: int, cell_mm: float) -> tuple[Indices, Indices]:
    """(m, 3) block of each face within its body, and (bodies, 3) how many there are."""
    low, high = np.full((bodies, 3), np.inf), np.full((bodies, 3), -np.inf)
    starts = np.flatnonzero(np.diff(body, prepend=-1))
    low[body[starts]] = np.minimum.reduceat(triangles.min(axis=1), starts, axis=0)
    high[body[starts]] = np.maximum.reduceat(triangles.max(axis=1), starts, axis=0)
    extent = np.where(np.isfinite(high - low), high - low, 0.0)
    counts = np.maximum(np.round(np.round(extent / cell_mm / _TIE) * _TIE), 1).astype(np.int64)
    share = (places - low[body]) / np.maximum(extent[body], 1e-9) * counts[body]
    block = np.floor(np.round(share / _TIE) * _TIE + _ASIDE).astype(np.int64)
    return np.clip(block, 0, counts[body] - 1), counts


def _six_ways(normals: Points) -> Indices:
    """(m,) the coordinate direction that each normal is nearest to; up and down come first where two are equal."""
    rounded = np.round(normals[:, (2, 0, 1)] / _COSINE).astype(np.int64)
    axis = np.argmax(np.abs(rounded), axis=1)
    return axis * 2 + (np.take_along_axis(rounded, axis[:, None], axis=1)[:, 0] < 0)
