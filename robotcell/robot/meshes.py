"""Triangles of bodies, from mesh files and from shapes that coal has no own name for."""

from pathlib import Path

import numpy as np

from geometry.arrays import Triangles
from geometry.mesh_file import read_mesh_file
from robotcell.errors import CellError
from specs.read_file import read_file

_ENDINGS = (".stl", ".obj", ".ply")
_LARGEST_FILE = 50_000_000
_MOST_TRIANGLES = 200_000
_FARTHEST = 1e6
"""Of a corner, in the file's unit."""

_SIDES = 32


def read_mesh(file: Path) -> Triangles:
    """Read the (n, 3, 3) triangles of a STL, OBJ or PLY file, in the file's own unit.

    Raises:
        CellError: it is missing, of another kind, broken, empty or too large.
    """
    if file.suffix.lower() not in _ENDINGS:
        raise CellError(f"a mesh is read from {', '.join(_ENDINGS)}; convert it", file=file)
    content = read_file(file, CellError, "mesh", _LARGEST_FILE)
    try:
        found = read_mesh_file(content, file.suffix.lower().removeprefix("."))
    except ValueError as reason:
        raise CellError(str(reason), file=file) from None
    triangles = np.concatenate([each for _, each in found]) if found else np.empty((0, 3, 3))
    if len(triangles) == 0 or not (np.abs(triangles) < _FARTHEST).all():
        raise CellError("holds no triangles, or one with a corner that is no number, or absurdly far", file=file)
    if len(triangles) > _MOST_TRIANGLES:
        raise CellError(f"{len(triangles):,} triangles are too many; simplify to {_MOST_TRIANGLES:,}", file=file)
    return triangles


def cylinder_triangles(radius: float, length: float) -> Triangles:
    """Give a prism (n, 3, 3) that just holds a cylinder along z, centred."""
    turn = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    outer = radius / np.cos(np.pi / _SIDES) * np.column_stack([np.cos(turn), np.sin(turn)])
    low, high = (np.column_stack([outer, np.full(_SIDES, z)]) for z in (-length / 2, length / 2))
    low2, high2 = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
    below, above = (np.tile([0.0, 0.0, z], (_SIDES, 1)) for z in (-length / 2, length / 2))
    sides = [(low, low2, high2), (low, high2, high), (below, low2, low), (above, high, high2)]
    return np.concatenate([np.stack(corners, axis=1) for corners in sides])
