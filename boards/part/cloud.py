"""A cloud of points, as scanners write it: a surface is laid through it before it is a part like any other."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np

from boards.bounds import FARTHEST_MM, beyond, number_within
from boards.errors import MAX_BYTES, BoardError, Line, read_bytes
from geometry.arrays import Points, Triangles
from geometry.mesh_file import HEADER_BYTES, holds_points, read_points_file
from geometry.solids.point_surface import PointSurface, surface_of_points
from specs.finding import Finding
from specs.finding_rules import CLOUD_OPEN, CLOUD_POINTS_LEFT_OUT, CLOUD_ROUGH, CLOUD_SURFACE
from specs.input_file import InputFile

MOST_POINTS = 20_000_000
_ROUGH = 0.15
"""Of a cell: points that lie farther off the surface, on the whole, are not described by it."""
_SMALL_RIM_CELLS = 8.0
"""Rims shorter than this are chance gaps between points."""
_LEAST_FACE_CELLS = 40.0
"""Area of the least face, in cells: the rounding of a sharp edge is two cells wide."""
_COUNT_LINE = re.compile(rb"[ \t]*\d+[ \t\r]*\n")


@dataclass(frozen=True, slots=True, eq=False)
class PartMesh:
    """The triangles of a file, or of the surface of its points."""

    patches: Triangles
    """(n, 3, 3) mm"""
    least_face_mm2: float
    """What is smaller is no face but a sharp edge that was rounded; 0 where edges are sharp."""
    findings: tuple[Finding, ...]


def is_cloud(path: Path) -> bool:
    """Whether a file of a suffix of clouds holds points alone: of them, a PLY may have faces."""
    if path.suffix.lower() != ".ply":
        return True
    InputFile(path, BoardError, "part file", MAX_BYTES).check()
    return holds_points(InputFile(path).head(HEADER_BYTES))


def read_cloud(path: Path, mm_per_unit: float, cell_mm: float | None) -> PartMesh:
    """Read the points of a file and lay a surface through them.

    Args:
        path: ``.xyz`` or ``.txt``, one point a line, further numbers of a line being left out; or ``.ply``.
        mm_per_unit: Of the file.
        cell_mm: Size of the smallest shapes to be kept; left out, as the points allow.

    Returns:
        The surface, and how it came about.

    Raises:
        BoardError: the file is damaged, or its points are no surface.
    """
    content = read_bytes(path)
    try:
        points = read_points_file(content) if path.suffix.lower() == ".ply" else _read_text(content, path)
        with np.errstate(over="ignore"):  # what is beyond all numbers is refused next
            points = points * mm_per_unit
        if beyond(points, FARTHEST_MM):
            raise ValueError("has a point that is no number or beyond 10 m. Correct it, and check the unit.")
        if len(points) > MOST_POINTS:
            raise ValueError(f"holds {len(points):,} points; at most {MOST_POINTS:,} are read. Thin it out.")
        surface = surface_of_points(points, cell_mm)
    except ValueError as reason:
        raise BoardError(f"the cloud {reason}", file=path) from None
    least = _LEAST_FACE_CELLS * surface.cell**2
    return PartMesh(surface.patches, least, tuple(_findings(len(points), surface)))


def _read_text(content: bytes, path: Path) -> Points:
    """(n, 3) first three numbers of each line; blanks, commas or semicolons stand between them."""
    counted = _COUNT_LINE.match(content)  # as some scanners begin their files
    text = content[counted.end() :] if counted else content
    text = text.translate(bytes.maketrans(b",;", b"  "))
    if not text.strip():
        return np.zeros((0, 3))
    try:
        return np.loadtxt(BytesIO(text), usecols=(0, 1, 2), comments=["#", "//"], ndmin=2)
    except (ValueError, IndexError):
        pass
    for number, line in enumerate(content.splitlines(), start=1):
        words = line.partition(b"#")[0].partition(b"//")[0].replace(b",", b" ").replace(b";", b" ").split()
        values = [number_within(word.decode("latin-1"), math.inf) for word in words[:3]]
        if words and not (counted and number == 1) and (len(values) < 3 or any(map(math.isnan, values))):
            message = "holds no three numbers. Each line of a cloud is a point, x y z; begin other lines with #."
            raise Line(path, number).error(message)
    raise ValueError("has lines that cannot be read. Each line is a point, x y z.")


def _findings(count: int, surface: PointSurface) -> Iterator[Finding]:
    text = (
        f"a surface of {len(surface.patches):,} triangles was laid through {count:,} points, in cells of "
        f"{surface.cell:.3g} mm: they lie {surface.noise:.2g} mm (rms) off it. Smaller shapes are rounded."
    )
    yield Finding(CLOUD_SURFACE, text)
    if surface.left_out:
        text = f"{surface.left_out:,} of {count:,} points lie beside the surface and were left out."
        yield Finding(CLOUD_POINTS_LEFT_OUT, text)
    if surface.noise > _ROUGH * surface.cell:
        text = (
            f"the points lie {surface.noise:.2g} mm (rms) off the surface, of cells of {surface.cell:.3g} mm: walls "
            "thinner than two cells or much noise. State a smaller cell_mm in a part file, or scan it more densely."
        )
        yield Finding(CLOUD_ROUGH, text)
    rims = [length for length in surface.openings if length > _SMALL_RIM_CELLS * surface.cell]
    if rims:
        listed = ", ".join(f"{length:.0f}" for length in rims[:5]) + (" and more" if len(rims) > 5 else "")
        places = "1 rim" if len(rims) == 1 else f"{len(rims)} rims"
        text = f"the surface ends at {places}, {listed} mm long. What was not scanned is not sprayed."
        yield Finding(CLOUD_OPEN, text)
