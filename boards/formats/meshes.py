"""STL, OBJ and PLY: loose triangles, with names where the file has some."""

from pathlib import Path

from boards.errors import BoardError, read_bytes
from boards.formats.tree import Node
from geometry.mesh_file import read_mesh_file


def read_mesh(path: Path) -> Node:
    """Read a mesh file; each object, group or solid becomes a child, in file order and file units.

    Raises:
        BoardError: damaged, or not of the kind of its suffix.
    """
    content = read_bytes(path)
    try:
        found = read_mesh_file(content, path.suffix.lower()[1:])
    except ValueError as reason:
        raise BoardError(str(reason), file=path) from None
    return Node("", "", (), tuple(Node(name, "", (patches,)) for name, patches in found))
