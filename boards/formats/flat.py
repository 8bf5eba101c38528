"""How flat a heap of patches is, the turn that lays a board flat, and the unit a file without units is in."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Triangles
from geometry.mesh import areas_and_normals

_SAME_WAY = 0.999
_THICKNESS_TO_SIDE = 0.35
_NO_AREA = 1e-30
_SMALLEST_TURN_RAD = 1e-4

UNITS_MM = {"mm": 1.0, "inches": 25.4, "metres": 1000.0, "micrometres": 0.001}
"""Units a board file may be in, the most likely first."""


@dataclass(frozen=True, slots=True, eq=False)
class Flatness:
    """The direction in which most of a body's surface looks, and its size along and across it (units of the file)."""

    normal: NDArray[np.float64]
    """(3,) unit vector; its largest coordinate is positive."""
    area: float
    """Area of one side."""
    thickness: float
    length: float
    """Diameter of the circle about the middle that holds it, across the normal."""

    @property
    def is_plate(self) -> bool:
        """Much wider than thick, and not just a face."""
        return 0.0 < self.thickness < _THICKNESS_TO_SIDE * self.area**0.5


def measure_flatness(patches: Triangles) -> Flatness:
    """Find the direction most of the surface looks in. Does not depend on how the body lies in the frame."""
    areas, unit = areas_and_normals(patches)
    if not areas.sum() > _NO_AREA:
        return Flatness(np.array([0.0, 0.0, 1.0]), 0.0, 0.0, 0.0)
    steps = np.rint(unit * 500.0).astype(np.int64)  # neighbouring directions share a cell
    key = (steps[:, 2] * 2048 + steps[:, 1]) * 2048 + steps[:, 0]
    flip = np.where(key < 0, -1.0, 1.0)
    _, cell = np.unique(np.abs(key), return_inverse=True)
    best = int(np.argmax(np.round(np.bincount(cell, weights=areas) / areas.sum(), 9)))
    chosen = cell == best
    normal = (unit[chosen] * (flip * areas)[chosen, None]).sum(axis=0)
    normal /= np.linalg.norm(normal)
    if normal[int(np.argmax(np.round(np.abs(normal), 6)))] < 0.0:
        normal = -normal
    along = patches.reshape(-1, 3) @ normal
    flat = patches.reshape(-1, 3) - along[:, None] * normal
    middle = (flat.max(axis=0) + flat.min(axis=0)) / 2.0
    area = float(areas[np.abs(unit @ normal) > _SAME_WAY].sum()) / 2.0
    length = 2.0 * float(np.linalg.norm(flat - middle, axis=1).max())
    return Flatness(normal, area, float(np.ptp(along)), length)


def turn_flat(normal: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the smallest rotation that takes ``normal`` to z (Rodrigues), or ``None`` if it is there already."""
    axis = np.eye(3)[int(np.argmax(np.abs(normal)))]
    towards = axis if np.linalg.norm(normal - axis) < _SMALLEST_TURN_RAD else normal
    x, y, z = towards
    if z == 1.0:
        return None
    cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
    return np.eye(3) + cross + cross @ cross / (1.0 + z)


def guess_unit(board: Flatness, likely: Sequence[str]) -> str | None:
    """Return the first unit in which the board has the size of a board, ``None`` if there is none.

    Length and thickness decide together: 4 x 0.063 is a board in inches, 0.1 x 0.0016 one in metres.
    """
    for unit in likely:
        scale = UNITS_MM[unit]
        if 3.0 <= board.length * scale <= 1500.0 and 0.1 <= board.thickness * scale <= 12.0:
            return unit
    return None
