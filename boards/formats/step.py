"""STEP: cascadio (OpenCASCADE) triangulates, the file's own text says which product each part is."""

import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from math import exp
from pathlib import Path

from boards.errors import BoardError
from boards.formats.gltf import parse_gltf
from boards.formats.tree import Node, refdes_of
from geometry.finding import Finding

Progress = Callable[[str, float], None]

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
_ENTITY = re.compile(
    rb"#(\d+)\s*=\s*(NEXT_ASSEMBLY_USAGE_OCCURRENCE|PRODUCT(?:_DEFINITION(?:_FORMATION(?:_WITH_SPECIFIED_SOURCE)?"
    rb"|_WITH_ASSOCIATED_DOCUMENTS)?)?)\s*\(((?:[^';]|'[^']*')*)\)\s*;"
)
_ARGUMENT = re.compile(r"'(?:[^']|'')*'|#\d+")
_WIDE = re.compile(r"\\X2\\((?:[0-9A-F]{4})*)\\X0\\")
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_SKIPPED = re.compile(r"skipped node '([^']*)' without geometry")


def read_step(path: Path, progress: Progress) -> tuple[Node, tuple[Finding, ...]]:
    """Read a STEP assembly. The tree comes back in metres, z up, in the file's frame.

    Raises:
        BoardError: not a STEP file, cut short, damaged, or without surfaces.
    """
    data = path.read_bytes()
    _check_envelope(data, path)
    glb, log = _convert(path, len(data), progress)
    damage = re.search(r"\*\*\* ERR ([^\n*]*)", log)
    if damage:
        reason = " ".join(damage[1].split())
        raise BoardError(f"is damaged, parts of it would be missing ({reason}). Export it again.", file=path)
    if not glb:
        message = "holds nothing that can be triangulated. Export solids or surfaces, not only curves (wireframe)."
        raise BoardError(message, file=path)
    tree = _name_products(parse_gltf(glb, path), read_products(data))
    return tree, _skipped_finding(_SKIPPED.findall(log))


def read_products(data: bytes) -> dict[str, str]:
    """Map the name of every placed part to the name of the product it places.

    An instance (``NEXT_ASSEMBLY_USAGE_OCCURRENCE``) names a product definition, that its formation, that its product
    (ISO 10303-41). A name used for several products is left out.
    """
    entities: dict[str, tuple[bytes, list[str]]] = {}
    for number, kind, text in _ENTITY.findall(data):
        plain = text.replace(b"\r", b"").replace(b"\n", b"").decode("latin-1")
        entities[f"#{number.decode()}"] = (kind, _ARGUMENT.findall(plain))
    products: dict[str, set[str]] = {}
    for kind, arguments in entities.values():
        if kind != b"NEXT_ASSEMBLY_USAGE_OCCURRENCE" or len(arguments) < 5:
            continue
        _, definition = entities.get(arguments[4], (b"", []))
        _, formation = entities.get(_reference(definition), (b"", []))
        _, product = entities.get(_reference(formation), (b"", []))
        if len(product) > 1:
            # PRODUCT(id, name, …): the name is often empty and the id then holds it.
            products.setdefault(_unquote(arguments[1]), set()).add(_unquote(product[1]) or _unquote(product[0]))
    return {name: next(iter(found)) for name, found in products.items() if len(found) == 1}


def _reference(arguments: list[str]) -> str:
    return next((argument for argument in arguments if argument.startswith("#")), "")


def _unquote(text: str) -> str:
    plain = text[1:-1].replace("''", "'")
    return _WIDE.sub(lambda found: bytes.fromhex(found[1]).decode("utf-16-be", "replace"), plain)


def _check_envelope(data: bytes, path: Path) -> None:
    if b"ISO-10303-21" not in data[:4096]:
        raise BoardError("is not a STEP file: it does not begin with ISO-10303-21. Export it as STEP.", file=path)
    if b"END-ISO-10303-21" not in data[-4096:]:
        raise BoardError("is cut short: END-ISO-10303-21 is missing at its end. Export or copy it again.", file=path)


def _convert(path: Path, size: int, progress: Progress) -> tuple[bytes, str]:
    """Run the conversion in a process of its own; returns the GLB and what the library said.

    OpenCASCADE writes to the terminal as it likes, holds the interpreter and may crash on a damaged file; a process
    keeps all three away from the caller.
    """
    expected_s = 1.0 + _SECONDS_PER_BYTE * size
    with tempfile.TemporaryDirectory(prefix="washboard-") as folder:
        out, log = Path(folder) / "board.glb", Path(folder) / "log.txt"
        command = [sys.executable, "-P", "-c", _CONVERT, str(path.resolve()), str(out)]
        started = time.monotonic()
        with log.open("wb") as sink, subprocess.Popen(command, stdout=sink, stderr=subprocess.STDOUT) as process:
            try:
                while process.poll() is None:
                    elapsed = time.monotonic() - started
                    progress("triangulating STEP", 0.95 * (1.0 - exp(-1.5 * elapsed / expected_s)))
                    _wait(process, 0.1)
            finally:
                process.kill()
        said = _COLOUR.sub("", log.read_text(encoding="utf-8", errors="replace"))
        if process.returncode != 0:
            last = said.strip().splitlines()[-1:] or [f"it ended with {process.returncode}"]
            message = f"the STEP library failed on it ({last[0].strip()}). Export it again, as AP214 or AP242."
            raise BoardError(message, file=path)
        return out.read_bytes(), said


def _wait(process: subprocess.Popen[bytes], seconds: float) -> None:
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        return


def _name_products(node: Node, products: dict[str, str]) -> Node:
    """Give each node that places a part the product's name; the mesh's own name stays where there is none."""
    children = tuple(_name_products(child, products) for child in node.children)
    return Node(node.name, products.get(node.name, node.product), node.patches, children)


def _skipped_finding(names: list[str]) -> tuple[Finding, ...]:
    if not names:
        return ()
    parts = sorted({name for name in names if name}, key=lambda name: (refdes_of(name) is None, name))
    listed = ", ".join(parts[:20]) + (" …" if len(parts) > 20 else "")
    message = f"{len(names)} parts have no geometry and are not there: {listed}. Give them a 3-D model if they matter."
    return (Finding("part-without-geometry", "warning", message),)
