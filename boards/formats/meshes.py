"""Trees of triangles from whatever file holds them; of STL, OBJ and PLY with names where they have some."""

from pathlib import Path

from boards.errors import BoardError, read_bytes
from boards.formats.table import Format, find_format
from boards.formats.tree import Node
from geometry.mesh_file import read_mesh_file
from specs.finding import Finding
from specs.progress import Progress


def read_tree(path: Path, progress: Progress) -> tuple[Node, Format, tuple[Finding, ...]]:
    """Read the tree of a file in its own frame and unit, its format, and what was noticed.

    Raises:
        BoardError: It cannot be read, is damaged, or not of the kind of its suffix.
    """
    try:
        form = find_format(path, "tree")
        tree, findings = form.function("tree")(path, progress)
    except OSError as reason:
        message = f"cannot be read ({reason.strerror}). Check the path and the permissions."
        raise BoardError(message, file=path) from reason
    return tree, form, findings


def read_mesh(path: Path, _: Progress) -> tuple[Node, tuple[()]]:
    """Read a mesh file; each object, group or solid becomes a child, in file order and file units.

    Raises:
        BoardError: damaged, or not of the kind of its suffix.
    """
    content = read_bytes(path)
    try:
        found = read_mesh_file(content, path.suffix.lower()[1:])
    except ValueError as reason:
        raise BoardError(str(reason), file=path) from None
    return Node("", "", (), tuple(Node(name, "", (patches,)) for name, patches in found)), ()
