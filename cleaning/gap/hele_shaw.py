"""Hele-Shaw flow in a thin gap between given pressures on its rim, by cell-centred finite volumes.

A gap is cut into rectangular cells, each joined to its four neighbours by what it lets through. Pressures stand in the
middle of cells, flows on faces; a pressure on the rim acts half a cell away from the middle. One factorisation serves
any number of pressures.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse import csgraph
from scipy.sparse.linalg import splu

from cleaning.errors import CleaningError

Field2: TypeAlias = NDArray[np.float64]
"""(rows along y, columns along x)"""
Fields: TypeAlias = NDArray[np.float64]
"""(k, rows, columns): one for each set of pressures"""
REFINEMENTS = 2
"""Corrections by the imbalance of cells: balances close to the last digits, also in cells long and narrow."""


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


def narrowed_grid(mobility: Field2, dx_m: float, dy_m: float, apertures: Apertures) -> Grid:
    """Join cells of the given mobilities, m3, 0 where nothing flows, whose halves are partly closed by walls."""
    if not (dx_m > 0 and dy_m > 0 and np.isfinite(dx_m * dy_m)):
        raise CleaningError(f"cells of {dx_m:g} x {dy_m:g} m cannot be: give both a positive size")
    if not (np.isfinite(mobility).all() and (mobility >= 0).all()):
        raise CleaningError("the mobility of a gap must be finite and not negative in every cell")
    along, across = 2.0 * mobility * (dy_m / dx_m), 2.0 * mobility * (dx_m / dy_m)
    left, right = along * apertures.left, along * apertures.right
    return Grid(dx_m, dy_m, left, right, across * apertures.front, across * apertures.back)


@dataclass(frozen=True, slots=True, eq=False)
class Rim:
    """Pressure on each side, Pa: a number, one per face (n,), or k sets of them (k, n). ``None`` closes a side."""

    left: ArrayLike | None = None
    right: ArrayLike | None = None
    front: ArrayLike | None = None
    """The side at -y."""
    back: ArrayLike | None = None
    """The side at +y."""


@dataclass(frozen=True, eq=False)
class Flow:
    """Pressures and flows for k sets of pressures."""

    pressure: Fields
    """(k, rows, columns) Pa; 0 in cells that no open face can reach."""
    along: Fields
    """(k, rows, columns + 1) volume flow times viscosity through faces across x, positive towards +x: Pa m3."""
    across: Fields
    """(k, rows + 1, columns) the same towards +y."""
    reached: NDArray[np.bool_]
    """(rows, columns) whether liquid can get there from the rim."""

    @cached_property
    def inflow(self) -> NDArray[np.float64]:
        """(k, 4) volume flow times viscosity that enters through the left, right, front and back."""
        sides = (self.along[:, :, 0], -self.along[:, :, -1], self.across[:, 0, :], -self.across[:, -1, :])
        return np.stack([side.sum(axis=1) for side in sides], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class _Links:
    """Conductances between cells and to the rim."""

    along: Field2
    """(rows, columns + 1)"""
    across: Field2
    """(rows + 1, columns)"""
    free: NDArray[np.bool_]
    """(rows, columns) cells whose pressure is to be found."""

    def flows(self, padded: Fields) -> tuple[Fields, Fields]:
        """Volume flow times viscosity through all faces, from differences of pressure, which lose no digits."""
        along = self.along * -np.diff(padded[:, 1:-1, :], axis=2)
        return along, self.across * -np.diff(padded[:, :, 1:-1], axis=1)

    def balance(self, padded: Fields) -> tuple[sparse.csc_array, NDArray[np.float64]]:
        """Balance the flows of every free cell: the matrix (n, n) and the loads (n, k).

        ``padded`` (k, rows + 2, columns + 2) holds the given pressures; those of free cells must be 0.
        """
        number = np.full(self.free.shape, -1)
        number[self.free] = np.arange(int(self.free.sum()))
        total = self.along[:, :-1] + self.along[:, 1:] + self.across[:-1] + self.across[1:]
        pairs = ((number[:, :-1], number[:, 1:], self.along[:, 1:-1]), (number[:-1], number[1:], self.across[1:-1]))
        rows, columns, values = [number[self.free]], [number[self.free]], [total[self.free]]
        for one, other, conductance in pairs:
            joined = (one >= 0) & (other >= 0) & (conductance > 0)
            rows += [one[joined], other[joined]]
            columns += [other[joined], one[joined]]
            values += [-conductance[joined]] * 2
        size = int(self.free.sum())
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        matrix = sparse.csc_array(entries, shape=(size, size))
        brought = (
            self.along[:, :-1] * padded[:, 1:-1, :-2]
            + self.along[:, 1:] * padded[:, 1:-1, 2:]
            + self.across[:-1] * padded[:, :-2, 1:-1]
            + self.across[1:] * padded[:, 2:, 1:-1]
        )
        return matrix, np.ascontiguousarray(brought[:, self.free].T)


def solve(grid: Grid, rim: Rim) -> Flow:
    """Solve the steady flow between the pressures on the rim.

    Cells that no open side can reach stand still. Raises CleaningError where shapes do not fit.
    """
    padded = _pad(grid, rim)
    links = _link(grid, rim)
    if links.free.any():
        matrix, loads = links.balance(padded)
        # MMD on A' + A keeps the factors of a symmetric matrix sparse
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        inside = padded[:, 1:-1, 1:-1]
        inside[:, links.free] = factors.solve(loads).T
        for _ in range(REFINEMENTS):
            along, across = links.flows(padded)
            missing = -(np.diff(along, axis=2) + np.diff(across, axis=1))[:, links.free]
            inside[:, links.free] += factors.solve(np.ascontiguousarray(missing.T)).T
    return Flow(padded[:, 1:-1, 1:-1], *links.flows(padded), links.free)


def _link(grid: Grid, rim: Rim) -> _Links:
    """Join the halves of neighbours, and those at the rim to the sides that are open."""
    rows, columns = grid.shape
    along, across = np.zeros((rows, columns + 1)), np.zeros((rows + 1, columns))
    along[:, 1:-1] = _in_series(grid.right[:, :-1], grid.left[:, 1:])
    across[1:-1] = _in_series(grid.back[:-1], grid.front[1:])
    # Free are the cells that are joined, through whatever others, to the rim.
    number = np.arange(rows * columns).reshape(rows, columns)
    touches = np.zeros((rows, columns), dtype=np.bool_)
    sides = (
        (rim.left, along[:, 0], grid.left[:, 0], touches[:, 0]),
        (rim.right, along[:, -1], grid.right[:, -1], touches[:, -1]),
        (rim.front, across[0], grid.front[0], touches[0]),
        (rim.back, across[-1], grid.back[-1], touches[-1]),
    )
    for pressure, faces, halves, cells in sides:
        if pressure is not None:
            faces[:] = halves
        cells |= faces > 0
    beside, above = along[:, 1:-1] > 0, across[1:-1] > 0
    first = np.concatenate([number[:, :-1][beside], number[:-1][above]])
    second = np.concatenate([number[:, 1:][beside], number[1:][above]])
    graph = sparse.coo_array((np.ones(len(first)), (first, second)), shape=(number.size, number.size))
    count, labels = cast("tuple[int, NDArray[np.int32]]", csgraph.connected_components(graph, directed=False))
    wet = np.zeros(count, dtype=np.bool_)
    wet[labels[touches.ravel()]] = True
    return _Links(along, across, wet[labels].reshape(rows, columns))


def _in_series(first: Field2, second: Field2) -> Field2:
    """Conductance of two conductances one behind the other; 0 if either is."""
    both = first + second
    return np.divide(first * second, both, out=np.zeros_like(both), where=both > 0)


def _pad(grid: Grid, rim: Rim) -> Fields:
    """Lay k sets of pressures of the rim around the cells: (k, rows + 2, columns + 2); 0 where none is given."""
    rows, columns = grid.shape
    given = ((rim.left, rows), (rim.right, rows), (rim.front, columns), (rim.back, columns))
    sides = [np.asarray(0.0 if side is None else side, dtype=np.float64) for side, _ in given]
    count = max((len(side) for side in sides if side.ndim == 2), default=1)
    padded = np.zeros((count, rows + 2, columns + 2))
    try:
        wide = [np.broadcast_to(side, (count, faces)) for side, (_, faces) in zip(sides, given, strict=True)]
    except ValueError as error:
        raise CleaningError(f"pressures do not fit a gap of {rows} rows and {columns} columns: {error}") from error
    if not all(np.isfinite(side).all() for side in wide):
        raise CleaningError("pressures in a gap must be finite")
    padded[:, 1:-1, 0], padded[:, 1:-1, -1], padded[:, 0, 1:-1], padded[:, -1, 1:-1] = wide
    return padded
