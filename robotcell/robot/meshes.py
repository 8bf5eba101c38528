"""Triangles of bodies, from mesh and STEP files and from shapes that coal has no own name for."""

from pathlib import Path

import numpy as np

from boards.errors import BoardError
from geometry.arrays import Triangles
from geometry.mesh_file import read_mesh_file
from robotcell.errors import CellError
from specs.progress import no_progress
from specs.read_file import read_file

_ENDINGS = (".stl", ".obj", ".ply")
STEP_ENDINGS = (".step", ".stp")
"""Of files that state their unit."""
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
    _check(triangles, file)
    return triangles


def read_step_solids(file: Path) -> tuple[Triangles, ...]:
    """Read the surfaces (n, 3, 3) of a STEP file, one of each solid in it, metres.

    Raises:
        CellError: it is missing, no STEP, damaged, without surfaces or too large.
    """
    from boards.formats.step import read_step  # most cells name none

    read_file(file, CellError, "STEP file", _LARGEST_FILE)
    try:
        tree, _ = read_step(file, no_progress)
    except BoardError as error:
        raise CellError(str(error)) from None
    solids = tree.geometry()
    _check(np.concatenate(solids), file)
    return solids


def _check(triangles: Triangles, file: Path) -> None:
    if len(triangles) == 0 or not (np.abs(triangles) < _FARTHEST).all():
        raise CellError("holds no triangles, or one with a corner that is no number, or absurdly far", file=file)
    if len(triangles) > _MOST_TRIANGLES:
        raise CellError(f"{len(triangles):,} triangles are too many; simplify to {_MOST_TRIANGLES:,}", file=file)


def cylinder_triangles(radius: float, length: float) -> Triangles:
    """Give a prism (n, 3, 3) that just holds a cylinder along z, centred."""
    turn = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    outer = radius / np.cos(np.pi / _SIDES) * np.column_stack([np.cos(turn), np.sin(turn)])
    low, high = (np.column_stack([outer, np.full(_SIDES, z)]) for z in (-length / 2, length / 2))
    low2, high2 = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
    below, above = (np.tile([0.0, 0.0, z], (_SIDES, 1)) for z in (-length / 2, length / 2))
    sides = [(low, low2, high2), (low, high2, high), (below, low2, low), (above, high, high2)]
    return np.concatenate([np.stack(corners, axis=1) for corners in sides])
