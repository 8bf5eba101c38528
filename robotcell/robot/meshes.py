"""Triangles of bodies: from mesh and STEP files, of shapes that coal has no own name for, and to be drawn."""

from pathlib import Path

import numpy as np

from boards.errors import BoardError
from geometry.arrays import Triangles
from geometry.mesh_file import read_mesh_file
from robotcell.errors import CellError
from robotcell.robot.robot import Body, Box, Capsule
from specs.input_file import InputFile
from specs.progress import no_progress

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
    content = InputFile(file, CellError, "mesh", _LARGEST_FILE).read()
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

    InputFile(file, CellError, "STEP file", _LARGEST_FILE).read()
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


_RINGS = 8
_FACES = np.array([
    [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
    [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
])  # fmt: skip
"""Triangles of a box, counterclockwise seen from outside; corner k is at (k & 1, k & 2, k & 4)."""


def placed_triangles(body: Body) -> Triangles:
    """(n, 3, 3) surface of a body in the frame of its carrier, metres."""
    shape, place = body.shape, body.T_carrier_shape
    match shape:
        case Box():
            signs = np.array([[(k & 1) * 2 - 1, (k & 2) - 1, (k & 4) / 2 - 1] for k in range(8)])
            triangles = (signs * np.array(shape.size) / 2)[_FACES]
        case Capsule():
            triangles = _capsule_triangles(shape.radius, shape.length)
        case _:
            triangles = shape.triangles
    return triangles @ place[:3, :3].T + place[:3, 3]


def _capsule_triangles(radius: float, length: float) -> Triangles:
    """Two hemispheres and a cylinder: rings of corners from the lower pole to the upper one."""
    rise = np.linspace(-np.pi / 2, np.pi / 2, 2 * _RINGS)
    lift = np.where(rise < 0, -length / 2, length / 2)
    around = 2 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.stack([np.cos(around), np.sin(around)], axis=1)
    corners = np.concatenate(
        [
            np.broadcast_to(radius * np.cos(rise)[:, None, None] * ring, (len(rise), _SIDES, 2)),
            np.broadcast_to((radius * np.sin(rise) + lift)[:, None, None], (len(rise), _SIDES, 1)),
        ],
        axis=2,
    )
    low, high = corners[:-1], corners[1:]
    low_next, high_next = np.roll(low, -1, axis=1), np.roll(high, -1, axis=1)
    halves = [np.stack([low, low_next, high_next], axis=2), np.stack([low, high_next, high], axis=2)]
    return np.concatenate([half.reshape(-1, 3, 3) for half in halves])
