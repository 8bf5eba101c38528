"""A board as large as a real one: 150 components in 80 groups, some 140,000 triangles; and one of many more parts."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from sample_boards.assemble import Place, Sample, assemble
from sample_boards.shapes import rectangle

from boards.formats.tri.tri import write_tri

COLUMNS, ROWS = 10, 8
PITCH_MM = (15.5, 11.2)
"""Groups stand so far apart that the recipe goes around each of them."""
COMPANIONS = 70
_PACKAGES = (
    "TSSOP-20_4.4x6.5mm_P0.65mm",
    "SOIC-14_3.9x8.7mm_P1.27mm",
    "TSSOP-16_4.4x5mm_P0.65mm",
    "SOIC-8_3.9x4.9mm_P1.27mm",
    "QFN-48-1EP_7x7mm_P0.5mm",
)


def write_large_board(file: Path) -> Path:
    """Write it as a board file."""
    file.write_text(write_tri([finer(body) for body in assemble(_sample(COLUMNS, ROWS, COMPANIONS))]))
    return file


def write_crowded_board(file: Path, groups: tuple[int, int]) -> Path:
    """Write a board of so many groups to the right and to the back, of two parts each."""
    file.write_text(write_tri(assemble(_sample(*groups, groups[0] * groups[1]))))
    return file


def _sample(columns: int, rows: int, companions: int) -> Sample:
    size = (columns * PITCH_MM[0] + 5.0, rows * PITCH_MM[1] + 5.0)
    outline = rectangle(size, (size[0] / 2, size[1] / 2))
    return Sample("large", outline, holes=(), bottom=-1.6, top=0.0, places=_places(columns, rows, companions))


def _places(columns: int, rows: int, most: int) -> tuple[Place, ...]:
    chips: list[Place] = []
    companions: list[Place] = []
    for number in range(columns * rows):
        x = 2.5 + PITCH_MM[0] * (number % columns + 0.5)
        y = 2.5 + PITCH_MM[1] * (number // columns + 0.5)
        chips.append(Place(f"U{number + 1}", _PACKAGES[number % len(_PACKAGES)], x - 1.5, y))
        companions.append(Place(f"C{number + 1}", "C_0603_1608Metric", x + 4.2, y, 90.0))
    return (*chips, *companions[:most])


def finer(body):
    """Divide each patch into four of the same shape."""
    a, b, c = np.moveaxis(body.patches, 1, 0)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    patches = np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3, 3)
    surfaces = tuple(replace(surface, patches=4 * surface.patches) for surface in body.surfaces)
    return replace(body, patches=patches, normals=np.repeat(body.normals, 4, axis=0), surfaces=surfaces)
