"""STEP: cascadio (OpenCASCADE) triangulates; the product of each part is read from the file's own text."""

import math
import os
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from boards.child import ChildError, Limits, in_child
from boards.errors import BoardError, read_bytes
from boards.formats.gltf import parse_gltf
from boards.formats.names import some
from boards.formats.step_child import triangulate
from boards.formats.tree import Node, refdes_of
from specs.finding import Finding
from specs.finding_rules import PART_WITHOUT_GEOMETRY
from specs.progress import Progress

_SECONDS_PER_BYTE = 0.28e-6  # measured: 10 s for 37.5 MB, 1.1 s for 5 MB
_FARTHEST = 1e7
"""No coordinate and no radius is larger, whatever the unit of the file."""

# A real number of eight digits or more before its point; of those, the ones of points and radii count.
_LARGE = re.compile(rb"[0-9]{8}\.|[0-9.]E\+?0*(?:[1-9][0-9]|[6-9])")
_SIZED = re.compile(
    rb"#(\d+)\s*=\s*(CARTESIAN_POINT|CIRCLE|ELLIPSE|(?:CYLINDRICAL|CONICAL|SPHERICAL|(?:DEGENERATE_)?TOROIDAL)_SURFACE)"
    rb"\s*\(([^;]*)\)\s*;"
)
_REAL = re.compile(rb"(?<![#\w.])[-+]?\d+\.?\d*(?:E[-+]?\d+)?")
_DOCUMENT = re.compile(rb"DOCUMENT_FILE", re.IGNORECASE)
_SLASH = re.compile(rb"(?<!\*)/(?!\*)" if os.sep == "/" else rb"(?<!\*)/(?!\*)|\\")
"""Not that of a comment."""
_SKIPPED = re.compile(r"skipped node '([^']*)' without geometry")
_ENTITY = re.compile(
    rb"#(\d+)\s*=\s*(NEXT_ASSEMBLY_USAGE_OCCURRENCE|PRODUCT(?:_DEFINITION(?:_FORMATION(?:_WITH_SPECIFIED_SOURCE)?"
    rb"|_WITH_ASSOCIATED_DOCUMENTS)?)?)\s*\(((?:[^';]|'[^']*')*)\)\s*;"
)
_ARGUMENT = re.compile(r"'(?:[^']|'')*'|#\d+|[$*]")
_WIDE = re.compile(r"\\X2\\((?:[0-9A-F]{4})*)\\X0\\")
_SIZE_CODE = re.compile(r"[A-Z]{1,4}(?:0\d{3,4}|1005|1206|1210|1608|1812|2010|2012|2512|3216|3225)")
"""Names of packages that are spelt like a reference designator, where a product's name may be either."""


def read_step(path: Path, progress: Progress) -> tuple[Node, tuple[Finding, ...]]:
    """Read a STEP assembly. The tree comes back in metres, z up, in the file's frame.

    Raises:
        BoardError: not a STEP file, cut short, damaged, or without surfaces.
    """
    data = detach(read_bytes(path))
    if b"ISO-10303-21" not in data[:4096]:
        raise BoardError("is not a STEP file: it does not begin with ISO-10303-21. Export it as STEP.", file=path)
    if b"END-ISO-10303-21" not in data[-4096:]:
        raise BoardError("is cut short: END-ISO-10303-21 is missing at its end. Export or copy it again.", file=path)
    _check_sizes(data, path)
    glb, log = _convert(data, path, progress)
    damage = re.search(r"\*\*\* ERR ([^\n*]*)", log)
    if damage:
        reason = " ".join(damage[1].split())
        raise BoardError(f"is damaged, parts of it would be missing ({reason}). Export it again.", file=path)
    if not glb:
        message = "holds nothing that can be triangulated. Export solids or surfaces, not only curves (wireframe)."
        raise BoardError(message, file=path)
    tree = name_products(parse_gltf(glb, path), read_structure(data))
    skipped = _SKIPPED.findall(log)
    names = sorted({name for name in skipped if name}, key=lambda name: (refdes_of(name) is None, name))
    text = (
        f"{len(skipped)} parts have no geometry and are not there: {some(names)}. Give them a 3-D model if they matter."
    )
    return tree, (Finding(PART_WITHOUT_GEOMETRY, text),) if skipped else ()


def detach(data: bytes) -> bytes:
    """Text of a STEP file in which no name leads to another folder.

    OpenCASCADE opens the files that a ``DOCUMENT_FILE`` names, anywhere; it runs in a folder where there are none.
    Strings and comments look alike in a piece of the text, so slashes are replaced everywhere.
    """
    return _SLASH.sub(b"_", data) if _DOCUMENT.search(data) else data


def _check_sizes(data: bytes, path: Path) -> None:
    """Refuse coordinates and radii that OpenCASCADE does not come back from."""
    if not _LARGE.search(data):
        return
    for entity in _SIZED.finditer(data):
        for word in _REAL.findall(re.sub(rb"'[^']*'", b"", entity[3])):
            if not abs(float(word)) <= _FARTHEST:
                kind = f"#{entity[1].decode()} ({entity[2].decode()})"
                message = f"{kind} has {word[:40].decode()}, beyond ±{_FARTHEST:g} of any unit. Repair it in CAD first."
                raise BoardError(message, file=path, line=data.count(b"\n", 0, entity.start()) + 1)


def limits_for(size: int) -> Limits:
    """Limits for a file of so many bytes: about fifteen times what boards of its size were measured to need.

    Of a small one what loading the library takes, several times over.
    """
    cpu_s = math.ceil(max(3.0, 15.0 * _SECONDS_PER_BYTE * size))
    return Limits(cpu_s, memory_bytes=1_500_000_000 + 150 * size, wall_s=60.0 + 10.0 * cpu_s)


def _convert(data: bytes, path: Path, progress: Progress) -> tuple[bytes, str]:
    """Triangulate in a process of its own; returns the GLB and the library's log."""
    expected_s = 1.0 + _SECONDS_PER_BYTE * len(data)

    def tick(elapsed_s: float) -> None:
        progress("triangulating STEP", 0.95 * (1.0 - math.exp(-1.5 * elapsed_s / expected_s)))

    try:
        return in_child(triangulate, data, limits_for(len(data)), tick)
    except ChildError as reason:
        message = f"the STEP library failed on it ({reason}). Export it again, as AP214 or AP242, with simpler models."
        raise BoardError(message, file=path) from None


@dataclass(frozen=True, slots=True)
class Structure:
    """The assembly as the file states it; definitions are called by their number, ``#12``."""

    products: dict[str, str]
    """Name of each definition's product."""
    uses: dict[str, tuple[tuple[str, str], ...]]
    """What each definition places: the name of the place (its number where it has none) and the definition in it."""
    nameless: frozenset[str]
    """Definitions that are placed once, by a place without a name or with its number for one."""

    def roots(self) -> list[str]:
        """Return the definitions that nothing places, in file order."""
        placed = {child for uses in self.uses.values() for _, child in uses}
        return [definition for definition in self.products if definition not in placed]


def read_structure(data: bytes) -> Structure:
    """Read the product structure of a STEP file.

    A place (``NEXT_ASSEMBLY_USAGE_OCCURRENCE``) names the definition it is in and the one it places, a definition its
    formation, that its product (ISO 10303-41).
    """
    entities: dict[str, tuple[bytes, list[str]]] = {}
    for number, kind, text in _ENTITY.findall(data):
        plain = text.replace(b"\r", b"").replace(b"\n", b"").decode("latin-1")
        entities[f"#{number.decode()}"] = (kind, _ARGUMENT.findall(plain))
    products: dict[str, str] = {}
    uses: dict[str, list[tuple[str, str]]] = {}
    nameless: set[str] = set()
    placed: Counter[str] = Counter()
    for number, (kind, arguments) in entities.items():
        if kind == b"NEXT_ASSEMBLY_USAGE_OCCURRENCE" and len(arguments) > 4:
            name = _unquote(arguments[1])
            uses.setdefault(arguments[3], []).append((name or _unquote(arguments[0]), arguments[4]))
            placed[arguments[4]] += 1
            nameless |= {arguments[4]} if name in ("", _unquote(arguments[0])) else set()
        elif kind in (b"PRODUCT_DEFINITION", b"PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS"):
            _, formation = entities.get(_reference(arguments), (b"", []))
            _, product = entities.get(_reference(formation), (b"", []))
            if len(product) > 1:
                # PRODUCT(id, name, …): the name is often empty and the id then holds it.
                products[number] = _unquote(product[1]) or _unquote(product[0])
    once = frozenset(definition for definition in nameless if placed[definition] == 1)
    return Structure(products, {number: tuple(found) for number, found in uses.items()}, once)


def _reference(arguments: list[str]) -> str:
    return next((argument for argument in arguments if argument.startswith("#")), "")


def _unquote(text: str) -> str:
    plain = text[1:-1].replace("''", "'") if text.startswith("'") else ""
    return _WIDE.sub(lambda found: bytes.fromhex(found[1]).decode("utf-16-be", "replace"), plain)


def name_products(tree: Node, structure: Structure) -> Node:
    """Give each node that places a part the name of the product; the mesh's own name stays where there is none.

    Some programs (Altium Designer among them) leave the places without names and call the product ``U12``: such a
    product's name becomes the node's.
    """
    anywhere = _unique([use for uses in structure.uses.values() for use in uses])
    roots = _unique([(structure.products[root], root) for root in structure.roots()])

    def rename(node: Node, definition: str) -> Node:
        here = _unique(structure.uses.get(definition, ()))
        children = tuple(rename(child, here.get(child.name, anywhere.get(child.name, ""))) for child in node.children)
        product = structure.products.get(definition, node.product)
        is_name = definition in structure.nameless and refdes_of(product) and not _SIZE_CODE.fullmatch(product)
        return Node(product if is_name else node.name, product, node.patches, children)

    return replace(tree, children=tuple(rename(child, roots.get(child.name, "")) for child in tree.children))


def _unique(uses: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Definition of each name; a name that stands for several is left out."""
    found: dict[str, set[str]] = {}
    for name, definition in uses:
        found.setdefault(name, set()).add(definition)
    return {name: next(iter(several)) for name, several in found.items() if len(several) == 1}
