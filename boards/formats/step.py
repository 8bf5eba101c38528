"""STEP: cascadio (OpenCASCADE) triangulates; the product of each part is read from the file's own text."""

import re
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from math import exp
from pathlib import Path

from boards.errors import BoardError, read_bytes
from boards.formats.gltf import parse_gltf
from boards.formats.names import some
from boards.formats.tree import Node, refdes_of
from specs.finding import Finding
from specs.finding_rules import PART_WITHOUT_GEOMETRY
from specs.progress import Progress
from specs.temporary import temporary_folder

# Sag of a chord below 0.02 mm; the angle bounds the number of chords of small arcs.
_TOL_LINEAR_MM = 0.02
_TOL_ANGULAR_RAD = 0.8
_SECONDS_PER_BYTE = 0.28e-6  # measured: 10 s for 37.5 MB, 1.1 s for 5 MB
# cascadio imports trimesh (0.6 s) for an extension that is not used here, and does without it.
_CONVERT = (
    "import sys, pathlib\n"
    "sys.modules['trimesh'] = None\n"
    "import cascadio\n"
    "data = pathlib.Path(sys.argv[1]).read_bytes()\n"
    f"glb = cascadio.load(data, tol_linear={_TOL_LINEAR_MM}, tol_angular={_TOL_ANGULAR_RAD}, use_parallel=False)\n"
    "pathlib.Path(sys.argv[2]).write_bytes(glb)\n"
)
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
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
    data = read_bytes(path)
    if b"ISO-10303-21" not in data[:4096]:
        raise BoardError("is not a STEP file: it does not begin with ISO-10303-21. Export it as STEP.", file=path)
    if b"END-ISO-10303-21" not in data[-4096:]:
        raise BoardError("is cut short: END-ISO-10303-21 is missing at its end. Export or copy it again.", file=path)
    glb, log = _convert(path, len(data), progress)
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


def _convert(path: Path, size: int, progress: Progress) -> tuple[bytes, str]:
    """Run the conversion in a process of its own; returns the GLB and the library's log.

    OpenCASCADE writes to the terminal as it likes, holds the interpreter and may crash on a damaged file; a process
    keeps all three away from the caller.
    """
    expected_s = 1.0 + _SECONDS_PER_BYTE * size
    with temporary_folder() as folder:
        out, log = folder / "board.glb", folder / "log.txt"
        command = [sys.executable, "-P", "-c", _CONVERT, str(path.resolve()), str(out)]
        started = time.monotonic()
        with log.open("wb") as sink, subprocess.Popen(command, stdout=sink, stderr=subprocess.STDOUT) as process:
            try:
                while process.poll() is None:
                    elapsed = time.monotonic() - started
                    progress("triangulating STEP", 0.95 * (1.0 - exp(-1.5 * elapsed / expected_s)))
                    with suppress(subprocess.TimeoutExpired):
                        process.wait(0.1)
            finally:
                process.kill()
        output = _COLOUR.sub("", log.read_text(encoding="utf-8", errors="replace"))
        if process.returncode != 0:
            last = output.strip().splitlines()[-1:] or [f"it ended with {process.returncode}"]
            message = f"the STEP library failed on it ({last[0].strip()}). Export it again, as AP214 or AP242."
            raise BoardError(message, file=path)
        return out.read_bytes(), output


@dataclass(frozen=True, slots=True)
class Structure:
    """The assembly as the file states it; definitions are called by their number, ``#12``."""

    products: dict[str, str]
    """Name of each definition's product."""
    uses: dict[str, tuple[tuple[str, str], ...]]
    """What each definition places: the name of the place (its number where it has none) and the definition in it."""
    nameless: frozenset[str]
    """Definitions that are placed once, by a place without a name."""

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
            nameless |= set() if name else {arguments[4]}
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
