"""The bare board: which of its faces are top and bottom, and whether its size can be true."""

from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from boards.board import Body
from boards.errors import BoardError
from geometry.arrays import Scalars, Triangles
from geometry.mesh import areas_and_normals

_FLAT_COSINE = 0.9998  # about 1°
_SAME_PLANE = 3e-5  # of the board's diagonal: 5 µm on a common board
_LEVEL = 1e-3  # of the diagonal: 0.06°
_MAIN_FACE = 0.25
"""A plane with less of the largest plane's area is a burr, a via or a pocket, not a face of the board."""

_WRITTEN_IN = ((1000.0, "metres", "m"), (25.4, "inches", "in"), (1.0 / 25.4, "millimetres read as inches", "mm"),
               (1.0 / 1000.0, "millimetres read as metres", "mm"))  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Slab:
    """The two faces of the bare board. Board frame, millimetres."""

    top_z_mm: float
    bottom_z_mm: float
    face: Triangles
    """(n, 3, 3) the patches of the top face."""


def find_slab(board: Body) -> Slab:
    """Find the top and the bottom face of a board by the area of its level patches.

    Raises:
        BoardError: The board is not flat on z, has no thickness, or its size indicates wrong units.
    """
    areas, normals = areas_and_normals(board.patches)
    level = np.abs(normals) > _FLAT_COSINE
    shares = np.array([areas[level[:, axis]].sum() for axis in range(3)]) / areas.sum()
    if shares[2] < 0.2 or shares[2] < 0.8 * max(shares[0], shares[1]):
        _refuse_direction(board.name, shares)
    flat = np.flatnonzero(level[:, 2])
    heights = board.patches[flat, :, 2].mean(axis=1)
    diagonal = float(np.hypot(*np.ptp(board.patches[:, :, :2].reshape(-1, 2), axis=0)))
    order = np.argsort(heights, kind="stable")
    planes = np.concatenate(([0], np.cumsum(np.diff(heights[order]) > _SAME_PLANE * diagonal)))
    sizes = np.bincount(planes, weights=areas[flat[order]])
    faces = np.flatnonzero(sizes >= _MAIN_FACE * sizes.max())
    bottom, top = (np.sort(flat[order[planes == face]]) for face in (faces[0], faces[-1]))
    face = board.patches[top]
    if np.ptp(face[:, :, 2]) > _LEVEL * diagonal or sizes.max() < 0.05 * sizes.sum():
        _refuse_direction(board.name, np.zeros(3))
    top_z, bottom_z = float(face[0, 0, 2]), float(board.patches[bottom[0], 0, 2])
    _check_size(board.name, diagonal, top_z - bottom_z)
    return Slab(top_z, bottom_z, face)


def _refuse_direction(name: str, shares: Scalars) -> NoReturn:
    axis = int(np.argmax(shares))
    if axis < 2 and shares[axis] > 0.3:
        message = f"the board {name} lies flat along {'xy'[axis]}, not z. Turn it so that z points out of its top side."
    else:
        message = (
            f"the board {name} has no flat level face: it is tilted or bent. Turn it so that its top is level on z."
        )
    raise BoardError(message)


def _check_size(name: str, diagonal: float, thickness: float) -> None:
    if thickness <= _SAME_PLANE * diagonal:
        message = f"the board {name} has no thickness: only one level face was found. Export it as a solid."
        raise BoardError(message)
    fits = 3.0 <= diagonal <= 2500.0
    if fits and 0.08 <= thickness <= 20.0:
        return
    size = f"the board {name} is {diagonal:.4g} mm across and {thickness:.3g} mm thick"
    for factor, unit, word in _WRITTEN_IN:
        if 0.1 <= thickness * factor <= 8.0 and 5.0 <= diagonal * factor <= 700.0:
            raise BoardError(f"{size}: that looks like {unit}. Write 'units {word}', or export in the right units.")
    if not (fits and 0.02 <= thickness <= 20.0):  # a thin flexible board is no mistake
        raise BoardError(f"{size}: that is no circuit board. Check the units and which object has role=board.")
