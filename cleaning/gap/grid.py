"""A thin gap cut into rectangular cells, each joined to its four neighbours by what it lets through."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cleaning.errors import CleaningError

Field2 = NDArray[np.float64]
"""(rows along y, columns along x)"""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Cells of a gap and the conductance of each half cell: volume flow times viscosity per pascal, m3.

    The half towards each side runs from the middle of the cell to its face; two halves in series join two neighbours.
    A half that lets nothing through is 0. Index [row, column], rows along y.
    """

    dx_m: float
    dy_m: float
    left: Field2
    right: Field2
    front: Field2
    """Towards -y."""
    back: Field2
    """Towards +y."""

    @property
    def shape(self) -> tuple[int, int]:
        """Rows along y, columns along x."""
        rows, columns = self.left.shape
        return rows, columns

    @property
    def centres(self) -> tuple[Field2, Field2]:
        """The x and y of the middles of all cells, m; the origin is in the middle of the grid."""
        rows, columns = self.shape
        x = (np.arange(columns, dtype=np.float64) - 0.5 * (columns - 1)) * self.dx_m
        y = (np.arange(rows, dtype=np.float64) - 0.5 * (rows - 1)) * self.dy_m
        return np.tile(x, (rows, 1)), np.repeat(y[:, None], columns, axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Apertures:
    """Which share of each half cell is open to flow towards each side: 0 closed, 1 open. (rows, columns) each."""

    left: Field2
    right: Field2
    front: Field2
    back: Field2


def mobility_of(height_m: float) -> float:
    """Volume flow per width times viscosity per pressure gradient between parallel plates: h^3 / 12, m3.

    Reynolds' lubrication equation.
    """
    return height_m**3 / 12.0


def plain_grid(mobility: ArrayLike, dx_m: float, dy_m: float) -> Grid:
    """Join cells of the given mobilities (rows, columns), in m3; 0 where nothing flows."""
    cells = np.atleast_2d(np.asarray(mobility, dtype=np.float64))
    everywhere = np.ones_like(cells)
    return narrowed_grid(cells, dx_m, dy_m, Apertures(everywhere, everywhere, everywhere, everywhere))


def narrowed_grid(mobility: Field2, dx_m: float, dy_m: float, apertures: Apertures) -> Grid:
    """Join cells whose halves are partly closed by walls."""
    if not (dx_m > 0 and dy_m > 0 and np.isfinite(dx_m * dy_m)):
        raise CleaningError(f"cells of {dx_m:g} x {dy_m:g} m cannot be: give both a positive size")
    if not (np.isfinite(mobility).all() and (mobility >= 0).all()):
        raise CleaningError("the mobility of a gap must be finite and not negative in every cell")
    along, across = 2.0 * mobility * (dy_m / dx_m), 2.0 * mobility * (dx_m / dy_m)
    return Grid(
        dx_m,
        dy_m,
        along * apertures.left,
        along * apertures.right,
        across * apertures.front,
        across * apertures.back,
    )


def in_series(first: Field2, second: Field2) -> Field2:
    """Conductance of two conductances one behind the other; 0 if either is."""
    both = first + second
    return np.divide(first * second, both, out=np.zeros_like(both), where=both > 0)
