"""The tree of named parts that a CAD or mesh file brings, and which of its nodes are components."""

import re
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from boards.errors import BoardError, read_bytes
from boards.formats.table import Format, find_format
from geometry.arrays import Triangles
from geometry.mesh_file import read_mesh_file
from specs.finding import Finding
from specs.progress import Progress

DEEPEST = 200
"""Levels below the root; a deeper tree is damaged rather than detailed."""

_REFDES = re.compile(r"([A-Z]{1,4}\d{1,5}[A-Z]?)(?:(?: ?[(\[]|[:;,_.-]| - ).*)?", re.DOTALL)
# Names of packages and of pieces that are spelt like a reference designator.
_NOT_REFDES = re.compile(
    r"(SO|SOT|SOD|SOP|TO|DO|DIP|SOIC|QFN|QFP|LQFP|TQFP|BGA|FBGA|LGA|DFN|SON|WSON|MSOP|SMA|SMB|SMC|PIN|PAD|LEAD|BODY|PART|"
    r"MESH|NODE|FACE|CUBE|ROOT|NAUO|PCB|PCBA|REV)\d+[A-Z]?"
)
_NOBODY = re.compile(
    r"|=>.*|NAUO\d*|\d+|open cascade.*"
    r"|(solid|compound|compsolid|shell|shape|mesh|node|body|part|object|geometry|extruded|cylinder|sphere)[ _.:-]?\d*",
    re.IGNORECASE | re.DOTALL,
)
_BOARD = re.compile(r"(?:^|[^a-z])(?:pcb|board|substrate|leiterplatte|platine)(?:$|[^a-z])", re.IGNORECASE)


T = TypeVar("T")


def without_file_order(items: Iterable[T], key: Callable[[T], Any], exact: Callable[[T], Any]) -> list[T]:
    """Sort objects by a key, and those that tie by an exact one, which may be dear."""
    keyed: list[tuple[Hashable, T]] = [(key(item), item) for item in items]
    counts = Counter(own for own, _ in keyed)
    return [item for _, item in sorted(keyed, key=lambda pair: (pair[0], exact(pair[1]) if counts[pair[0]] > 1 else 0))]


def corner_key(patches: Triangles, step: float) -> tuple[int, ...]:
    """Coordinates of all corners in steps, in an order of their own: equal for equal shapes in one place alone."""
    steps = np.rint(patches.reshape(-1, 3) / step + 0.31).astype(np.int64)
    return tuple(steps[np.lexsort(steps.T[::-1])].ravel().tolist())


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """One node of the file's tree: its own patches in the root's frame (file units) and what hangs below it."""

    name: str
    product: str
    """Name of the part or mesh that the node places; empty where the file gives none."""
    patches: tuple[Triangles, ...]
    children: tuple["Node", ...] = ()

    def walk(self) -> Iterator["Node"]:
        """Yield the node and everything below it, in tree order."""
        yield self
        for child in self.children:
            yield from child.walk()

    def geometry(self) -> tuple[Triangles, ...]:
        """Return the patches of the node and of everything below it, one array for each geometry of the file."""
        return tuple(patches for node in self.walk() for patches in node.patches)


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """What becomes one body: a name (empty if the file gives none) and its geometry."""

    name: str
    package: str | None
    geometry: tuple[Triangles, ...]
    is_named: bool
    """The name is a reference designator."""

    def patches(self) -> Triangles:
        """All patches, (n, 3, 3)."""
        return np.concatenate(self.geometry)


def refdes_of(name: str) -> str | None:
    """Return the reference designator in a node's name: ``U12``, also from ``U12:1`` and ``U12_SOIC-8``."""
    found = _REFDES.fullmatch(name)
    if found is None or _NOT_REFDES.fullmatch(found[1]):
        return None
    return found[1]


def label_of(node: Node) -> str:
    """Return the name a person gave to a node or to what it places; empty where programs made them up."""
    return next((name for name in (node.name, node.product) if not _NOBODY.fullmatch(name)), "")


def package_of(node: Node) -> str | None:
    """Return the product's name at a component's node or, as long as there is one node only, below it."""
    names = [node.product]
    below = node.children
    while len(below) == 1:
        names += [below[0].product, below[0].name]
        below = below[0].children
    return next((name for name in names if not _NOBODY.fullmatch(name) and name != node.name), None)


def is_called_board(node: Node, stem: str) -> bool:
    """Whether a node (not the root) is named like a bare board, or like the file."""
    names = (node.name, node.product)
    return any(is_board_name(name) or name == stem for name in names) and refdes_of(node.name) is None


def is_board_name(name: str) -> bool:
    """Whether a name is one that bare boards have."""
    return _BOARD.search(name) is not None


def has_refdes(node: Node) -> bool:
    """Whether any node of the subtree is named like a reference designator."""
    return any(refdes_of(below.name) for below in node.walk())


def split_parts(tree: Node, board: Node) -> list[Part]:
    """Cut the tree into parts, in tree order, the board's node left out.

    A component is called by its reference designator alone (``U12`` for ``U12:1``) unless two nodes share it.
    """
    parts = _cut(tree, board)
    spelt: dict[str | None, set[str]] = {}
    for part in parts:
        spelt.setdefault(refdes_of(part.name), set()).add(part.name)
    short = {name: refdes for refdes, names in spelt.items() for name in names if refdes and len(names) == 1}
    return [replace(part, name=short.get(part.name, part.name)) for part in parts]


def _cut(node: Node, board: Node) -> list[Part]:
    """Cut below one node.

    The topmost node with a reference designator is a component with all that hangs below it; a node that holds the
    board or components is a wrapper; anything else is one part under its own name.
    """
    if node is board:
        return []
    is_component = refdes_of(node.name) is not None
    holds_board = any(below is board for below in node.walk())
    if not holds_board and (is_component or not has_refdes(node) or _is_one_part(node)):
        geometry = node.geometry()
        name = node.name if is_component else label_of(node)
        return [Part(name, package_of(node), geometry, is_component)] if geometry else []
    own = [Part(label_of(node), None, node.patches, False)] if node.patches else []
    return own + [part for child in node.children for part in _cut(child, board)]


def _is_one_part(node: Node) -> bool:
    """Whether a node with a name of its own holds one name like a designator among other solids: a part's product."""
    named = [below for below in node.walk() if refdes_of(below.name) is not None]
    solids = sum(1 for below in node.walk() if below.patches)
    return bool(label_of(node)) and len(named) == 1 and solids > sum(1 for below in named[0].walk() if below.patches)


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
