"""STL, OBJ and PLY: loose triangles, with names where the file has some."""

import re
import warnings
from pathlib import Path
from typing import Any, cast

import numpy as np

from boards.errors import BoardError
from boards.formats.names import cause
from boards.formats.tree import Node


def read_mesh(path: Path) -> Node:
    """Read a mesh file; each object, group or solid becomes a child, in file order and file units.

    Raises:
        BoardError: damaged, or not of the kind of its suffix.
    """
    import trimesh

    kind = path.suffix.lower()[1:]
    options = _options(path, kind)
    try:
        with path.open("rb") as stream, warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            loaded = trimesh.load_scene(stream, file_type=kind, process=False, **options)
        found = [(str(name), cast(Any, mesh)) for name, mesh in loaded.geometry.items() if hasattr(mesh, "faces")]
        children = tuple(
            Node(name, "", (np.asarray(mesh.vertices, dtype=np.float64)[np.asarray(mesh.faces, dtype=np.int64)],))
            for name, mesh in found
            if len(mesh.faces)
        )
    except Exception as reason:  # trimesh's parsers raise whatever they stumble over
        damage = f"the file is damaged or cut short ({cause(reason)})"
        raise BoardError(f"cannot be read as {kind.upper()}, {damage}. Export it again.", file=path) from reason
    # trimesh hands the groups of an OBJ back last first.
    return Node("", "", (), children[::-1] if kind == "obj" else children)


def _options(path: Path, kind: str) -> dict[str, Any]:
    """Options of trimesh: an OBJ is split by object if it has any, else by group; materials are of no interest.

    An STL that is cut short is refused: trimesh would take it for text, or for an empty file.
    """
    text = path.read_bytes() if kind in ("obj", "stl") else b""
    if kind == "stl":
        if text[:5].lower() == b"solid" and b"facet" in text[:1024]:
            whole = b"endsolid" in text[-1024:].lower()
        else:
            whole = len(text) >= 84 and len(text) >= 84 + 50 * int.from_bytes(text[80:84], "little")
        if not whole:
            raise BoardError("is not an STL file, or it is cut short. Export or copy it again.", file=path)
    if kind != "obj":
        return {}
    if re.search(rb"^f[^\n#]*[ \t]-\d", text, re.MULTILINE):
        message = "counts vertices backwards (negative numbers in 'f' lines). Export it with absolute numbers."
        raise BoardError(message, file=path)
    objects = re.search(rb"^o ", text, re.MULTILINE) is not None
    return {
        "skip_materials": True,
        "group_material": False,
        "split_objects": objects,
        "split_groups": not objects and re.search(rb"^g ", text, re.MULTILINE) is not None,
    }
