"""STEP: cascadio (OpenCASCADE) triangulates, the file's own text says which product each part is."""

import re
import subprocess
import sys
import tempfile
import time
from math import exp
from pathlib import Path

from boards.errors import BoardError
from boards.formats.gltf import parse_gltf
from boards.formats.step_products import name_products, read_structure
from boards.formats.tree import Node, refdes_of
from specs.finding import Finding
from specs.finding_rules import PART_WITHOUT_GEOMETRY
from specs.progress import Progress

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
    tree = name_products(parse_gltf(glb, path), read_structure(data))
    return tree, _skipped_finding(_SKIPPED.findall(log))


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


def _skipped_finding(names: list[str]) -> tuple[Finding, ...]:
    if not names:
        return ()
    parts = sorted({name for name in names if name}, key=lambda name: (refdes_of(name) is None, name))
    listed = ", ".join(parts[:20]) + (" …" if len(parts) > 20 else "")
    message = f"{len(names)} parts have no geometry and are not there: {listed}. Give them a 3-D model if they matter."
    return (Finding(PART_WITHOUT_GEOMETRY, message),)
