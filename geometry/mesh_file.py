"""Triangles out of the bytes of STL, OBJ and PLY files; trimesh decodes them, and is kept from every other file.

A binary STL is an array after its header: most robots' meshes are, and it is read without trimesh, which loads slowly.
"""

import logging
import re
import warnings
from collections.abc import Generator
from contextlib import contextmanager
from io import BytesIO
from typing import Any

import numpy as np

from geometry.arrays import Points, Triangles

_PLY_ELEMENT = re.compile(rb"^element[ \t]+\S+[ \t]+(\S+)[ \t\r]*$", re.MULTILINE)
_PLY_COUNT = re.compile(rb"\d{1,12}")
HEADER_BYTES = 65_536
"""Of a PLY file, in which its header ends."""
_STL_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_ONLY_NAME = "geometry_0"
"""As trimesh names what has no name."""


def read_mesh_file(content: bytes, kind: str) -> list[tuple[str, Triangles]]:
    """Read the objects, groups or solids of a mesh file, in file order, each with its name.

    Args:
        content: The whole file.
        kind: ``"stl"``, ``"obj"`` or ``"ply"``.

    Returns:
        Names and (n, 3, 3) triangles in the file's own unit, those without a triangle left out.

    Raises:
        ValueError: It is damaged, cut short, not of its kind, or too large; the message is a sentence's end.
    """
    if kind == "stl" and len(content) >= 84 and len(content) == 84 + 50 * int.from_bytes(content[80:84], "little"):
        with np.errstate(invalid="ignore"):  # of signalling NaN; what is no number is refused later, by name
            corners = np.frombuffer(content, dtype=_STL_FACET, offset=84)["corners"].astype(np.float64)
        return [(_ONLY_NAME, corners)] if len(corners) else []

    options = _options(content, kind)
    with _decoding(kind, "a number is missing or is none, a face names a vertex that is not there, or it is cut short"):
        geometry = _load(content, kind, options)
        found = [(name, mesh) for name, mesh in geometry.items() if hasattr(mesh, "faces")]
        if kind == "obj":  # trimesh hands the groups of an OBJ back last first
            found.reverse()
        return [_triangles(name, mesh) for name, mesh in found if len(mesh.faces)]


def holds_points(content: bytes) -> bool:
    """Whether the first bytes of a PLY file announce a cloud of points: vertices without a face."""
    header = content[:HEADER_BYTES].partition(b"end_header")[0]
    return header.startswith(b"ply") and not re.search(rb"^element[ \t]+face[ \t]+0*[1-9]", header, re.MULTILINE)


def read_points_file(content: bytes) -> Points:
    """Read the vertices (n, 3) of a PLY file, in its own unit.

    Raises:
        ValueError: It is damaged, cut short, or too large; the message is a sentence's end.
    """
    options = _options(content, "ply")
    with _decoding("ply", "a number is missing, or it is cut short"):
        found = [np.asarray(each.vertices, dtype=np.float64) for each in _load(content, "ply", options).values()]
        return np.concatenate([np.zeros((0, 3)), *found]).reshape(-1, 3)


@contextmanager
def _decoding(kind: str, damage: str) -> Generator[None]:
    """Turn whatever trimesh's parsers stumble over into one sentence.

    Raises:
        ValueError: The file is damaged, or too large.
    """
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    except MemoryError:
        raise ValueError("is too large for this machine's memory. Export it more coarsely.") from None
    except Exception:
        raise ValueError(f"cannot be read as {kind.upper()}: {damage}. Export it again.") from None


def _load(content: bytes, kind: str, options: dict[str, Any]) -> dict[str, Any]:
    """Let trimesh read a file; its objects by name. Bytes have no folder: textures that a file names are not found."""
    import trimesh  # takes half a second

    logging.getLogger("trimesh").setLevel(logging.CRITICAL)  # it logs tracebacks of what it survives
    loaded = trimesh.load_scene(BytesIO(content), file_type=kind, process=False, **options)
    return {str(name): each for name, each in loaded.geometry.items()}


def _triangles(name: str, mesh: Any) -> tuple[str, Triangles]:
    vertices = np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3)
    faces = np.asarray(mesh.faces, dtype=np.int64).reshape(-1, 3)
    if faces.min() < 0:
        raise IndexError("a negative index would count from the end")
    return name, vertices[faces]


def _options(content: bytes, kind: str) -> dict[str, Any]:
    """Check what trimesh does not, and give its options: an OBJ is split by object if it has any, else by group.

    An STL that is cut short is refused: trimesh would take it for text, or for an empty file. A PLY that announces
    more than it has would fill the memory.
    """
    match kind:
        case "stl":
            if content[:5].lower() == b"solid" and b"facet" in content[:1024]:
                whole = b"endsolid" in content[-1024:].lower()
            else:
                whole = len(content) >= 84 and len(content) >= 84 + 50 * int.from_bytes(content[80:84], "little")
            if not whole:
                raise ValueError("is not an STL file, or it is cut short. Export or copy it again.")
            return {}
        case "ply":
            counts = _PLY_ELEMENT.findall(content[:HEADER_BYTES].partition(b"end_header")[0])
            if not all(map(_PLY_COUNT.fullmatch, counts)) or sum(map(int, counts)) > len(content):
                raise ValueError("announces more than the file holds: it is cut short. Export or copy it again.")
            return {"skip_materials": True}
        case _:
            if re.search(rb"^f[^\n#]*[ \t]-\d", content, re.MULTILINE):
                raise ValueError(
                    "counts vertices backwards (negative numbers in 'f' lines). Export it with absolute numbers."
                )
            objects = re.search(rb"^o ", content, re.MULTILINE) is not None
            return {
                "skip_materials": True,
                "group_material": False,
                "split_objects": objects,
                "split_groups": not objects and re.search(rb"^g ", content, re.MULTILINE) is not None,
            }
