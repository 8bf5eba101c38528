"""Which product each part of a STEP assembly is: read from the file's own text, laid upon the triangulated tree."""

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

from boards.formats.tree import Node, refdes_of

_ENTITY = re.compile(
    rb"#(\d+)\s*=\s*(NEXT_ASSEMBLY_USAGE_OCCURRENCE|PRODUCT(?:_DEFINITION(?:_FORMATION(?:_WITH_SPECIFIED_SOURCE)?"
    rb"|_WITH_ASSOCIATED_DOCUMENTS)?)?)\s*\(((?:[^';]|'[^']*')*)\)\s*;"
)
_ARGUMENT = re.compile(r"'(?:[^']|'')*'|#\d+|[$*]")
_WIDE = re.compile(r"\\X2\\((?:[0-9A-F]{4})*)\\X0\\")
_SIZE_CODE = re.compile(r"[A-Z]{1,4}(?:0\d{3,4}|1005|1206|1210|1608|1812|2010|2012|2512|3216|3225)")
"""Names of packages that are spelt like a reference designator, where a product's name may be either."""


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
