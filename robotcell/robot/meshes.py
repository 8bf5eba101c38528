"""Triangles of bodies, from mesh files and from shapes that coal has no own name for."""

from pathlib import Path

import numpy as np

from geometry.arrays import Triangles
from robotcell.errors import CellError

_ENDINGS = (".stl", ".obj", ".ply")
_LARGEST_FILE = 50_000_000
_MOST_TRIANGLES = 200_000
_SIDES = 32


def read_mesh(file: Path) -> Triangles:
    """Read the (n, 3, 3) triangles of a STL, OBJ or PLY file, in the file's own unit.

    Raises:
        CellError: it is missing, of another kind, broken, empty or too large.
    """
    if file.suffix.lower() not in _ENDINGS:
        raise CellError(f"a mesh is read from {', '.join(_ENDINGS)}; convert it", file=file)
    try:
        size = file.stat().st_size
        content = file.open("rb") if size <= _LARGEST_FILE and file.is_file() else None
    except FileNotFoundError:
        raise CellError("no such mesh file", file=file) from None
    except (OSError, ValueError) as error:
        raise CellError(f"cannot be read: {getattr(error, 'strerror', None) or error}", file=file) from None
    if content is None:
        raise CellError(f"not a mesh file of at most {_LARGEST_FILE:,} bytes", file=file)
    import trimesh

    with content:
        try:
            loaded = trimesh.load_mesh(content, file_type=file.suffix.lower().removeprefix("."), process=False)
            triangles = np.array(loaded.triangles, dtype=np.float64)
        except Exception as error:  # whatever a reader of broken meshes may raise
            raise CellError(f"cannot be read as a mesh: {error}", file=file) from None
    if len(triangles) == 0 or not np.isfinite(triangles).all():
        raise CellError("holds no triangles, or one with a corner that is no number", file=file)
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
