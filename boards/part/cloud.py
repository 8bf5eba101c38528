"""A cloud of points, as scanners write it: a surface is laid through it before it is a part like any other."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from boards.bounds import FARTHEST_MM, beyond, number_within
from boards.errors import MAX_BYTES, BoardError, Line, read_bytes
from geometry.arrays import Points, Triangles
from geometry.mesh_file import HEADER_BYTES, holds_points, read_points_file
from geometry.solids.point_surface import PointSurface, surface_of_points
from specs.finding import Finding
from specs.finding_rules import CLOUD_DECIMAL_COMMAS, CLOUD_OPEN, CLOUD_POINTS_LEFT_OUT, CLOUD_ROUGH, CLOUD_SURFACE
from specs.input_file import InputFile

MOST_POINTS = 20_000_000
_ROUGH = 0.15
"""Of a cell: points that lie farther off the surface, on the whole, are not described by it."""
_SMALL_RIM_CELLS = 8.0
"""Rims shorter than this are chance gaps between points."""
_LEAST_FACE_CELLS = 40.0
"""Area of the least face, in cells: the rounding of a sharp edge is two cells wide."""
_LOOKED_AT = 4096
"""Bytes by which the way is found in which numbers are written."""
_DECIMAL_COMMAS = re.compile(
    rb"[ \t]*(?:[+-]?\d+(?:,\d+)?(?:[eE][+-]?\d+)?(?:[ \t]*;[ \t]*|[ \t]+|[ \t\r]*$)){3,}[^.]*$"
)
_NO_NUMBER = re.compile(rb"(?im)^[^#/\n]*?(?<![a-z])(?:nan|inf(?:inity)?)(?![a-z])")
_ANY_POINT = re.compile(rb"^[^\S\n]*(?!#|//)\S", re.MULTILINE)
"""A line that is no comment; numpy warns where there is none."""
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
    file = InputFile(path, BoardError, "part file", MAX_BYTES)
    file.check()
    return holds_points(file.head(HEADER_BYTES))


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
        points, noticed = (
            (read_points_file(content), []) if path.suffix.lower() == ".ply" else _read_text(content, path)
        )
        sound = np.asarray(np.isfinite(points).all(axis=1))
        noticed += _left_out(sound, content)
        with np.errstate(over="ignore"):  # what is beyond all numbers is refused next
            points = points[sound] * mm_per_unit
        if beyond(points, FARTHEST_MM):
            raise ValueError("has a point beyond 10 m. Correct it, and check the unit.")
        if len(points) > MOST_POINTS:
            raise ValueError(f"holds {len(points):,} points; at most {MOST_POINTS:,} are read. Thin it out.")
        surface = surface_of_points(points, cell_mm)
    except ValueError as reason:
        raise BoardError(f"the cloud {reason}", file=path) from None
    least = _LEAST_FACE_CELLS * surface.cell**2
    return PartMesh(surface.patches, least, (*noticed, *_findings(len(points), surface)))


def _read_text(content: bytes, path: Path) -> tuple[Points, list[Finding]]:
    """(n, 3) first three numbers of each line, with blanks, commas or semicolons between them, and what was noticed.

    Where each of them has a comma for its point, and none a point, they are read so.
    """
    counted = _COUNT_LINE.match(content)  # as some scanners begin their files
    text = content[counted.end() :] if counted else content
    noticed: list[Finding] = []
    separators = bytes.maketrans(b",;", b"  ")
    lines = [line for line in text[:_LOOKED_AT].split(b"\n") if line.strip() and not line.startswith((b"#", b"//"))]
    if any(b"," in line for line in lines) and all(map(_DECIMAL_COMMAS.match, lines[:-1] or lines)):
        separators = bytes.maketrans(b",;", b". ")
        example = lines[0].decode("latin-1").strip()[:40]
        noticed.append(
            Finding(CLOUD_DECIMAL_COMMAS, f"{example!r} was read with commas as decimal points, as all lines.")
        )
    text = text.translate(separators)
    if not _ANY_POINT.search(text):
        return np.zeros((0, 3)), noticed
    try:
        return np.loadtxt(BytesIO(text), usecols=(0, 1, 2), comments=["#", "//"], ndmin=2), noticed
    except (ValueError, IndexError):
        pass
    for number, line in enumerate(content.splitlines(), start=1):
        words = line.partition(b"#")[0].partition(b"//")[0].translate(separators).split()
        texts = [word.decode("latin-1") for word in words[:3] if not _NO_NUMBER.match(word)]
        lacks = len(words) < 3 or any(math.isnan(number_within(text, math.inf)) for text in texts)
        if words and not (counted and number == 1) and lacks:
            message = "holds no three numbers. Each line of a cloud is a point, x y z; begin other lines with #."
            raise Line(path, number).error(message)
    raise ValueError("has lines that cannot be read. Each line is a point, x y z.")


def _left_out(sound: NDArray[np.bool_], content: bytes) -> Iterator[Finding]:
    """Name the points that are none: scanners write NaN for rays that did not come back."""
    if count := int(np.count_nonzero(~sound)):
        first = f"point {int(np.argmin(sound)) + 1:,}"
        if not content.startswith(b"ply") and (found := _NO_NUMBER.search(content)):
            before = content.count(b"\n", 0, found.start())
            first = f"line {before + 1:,}"
        text = f"{count:,} of {len(sound):,} points are no numbers and were left out; the first is {first}."
        yield Finding(CLOUD_POINTS_LEFT_OUT, text)


def _findings(count: int, surface: PointSurface) -> Iterator[Finding]:
    text = (
        f"a surface of {len(surface.patches):,} triangles was laid through {count:,} points, in cells of "
        f"{surface.cell:.3g} mm: they lie {surface.noise:.2g} mm (rms) off it. Smaller shapes are rounded."
    )
    yield Finding(CLOUD_SURFACE, text)
    if surface.left_out:
        at = ", ".join(f"{each:z.1f}" for each in surface.farthest)
        many = f"{surface.left_out:,} of {count:,} points"
        text = f"{many} lie beside the surface and were left out, the farthest at {at} mm."
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
