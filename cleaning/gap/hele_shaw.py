"""Pressure and flow in a gap between given pressures on its rim, and on places inside such as via holes.

Cell-centred finite volumes: pressures stand in the middle of cells, flows on faces; a pressure on the rim acts half a
cell away from the middle. One factorisation serves any number of pressures.
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
from cleaning.gap.grid import Grid, in_series

Fields: TypeAlias = NDArray[np.float64]  # (k, rows, columns): one for each set of pressures
NEAREST = 1e-3
"""Least distance, in cells, of a held outline from the middle of an open cell."""
REFINEMENTS = 2
"""Corrections by what the flows of cells lack: balances close to the last digits, also in cells long and narrow."""


@dataclass(frozen=True, slots=True, eq=False)
class Rim:
    """Pressure on each side, Pa: a number, one per face (n,), or k sets of them (k, n).

    ``None`` closes a side; NaN closes a face, in all sets.
    """

    left: ArrayLike | None = None
    right: ArrayLike | None = None
    front: ArrayLike | None = None
    """The side at -y."""
    back: ArrayLike | None = None
    """The side at +y."""


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """Places inside whose pressure is given, such as holes."""

    level: NDArray[np.float64]
    """(rows, columns) negative in cells that are held, positive in others; a signed distance to the outline puts the
    outline where it is (Gibou and others 2002), any other numbers of one size put it on faces."""
    pressure: ArrayLike
    """A number, (rows, columns) or (k, rows, columns), Pa."""


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
    """(rows, columns) whether liquid can get there from a given pressure."""
    held: NDArray[np.bool_]
    """(rows, columns) whether the pressure was given there."""

    @cached_property
    def inflow(self) -> NDArray[np.float64]:
        """(k, 4) volume flow times viscosity that enters through the left, right, front and back."""
        sides = (self.along[:, :, 0], -self.along[:, :, -1], self.across[:, 0, :], -self.across[:, -1, :])
        return np.stack([side.sum(axis=1) for side in sides], axis=1)

    @cached_property
    def sources(self) -> Fields:
        """(k, rows, columns) volume flow times viscosity that enters at each cell: 0 except where pressure is held."""
        return np.diff(self.along, axis=2) + np.diff(self.across, axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Links:
    """Conductances between cells and to the rim; all (rows, columns) or one less or more."""

    along: NDArray[np.float64]
    """(rows, columns + 1)"""
    across: NDArray[np.float64]
    """(rows + 1, columns)"""
    free: NDArray[np.bool_]
    """(rows, columns) cells whose pressure is to be found."""


def solve(grid: Grid, rim: Rim, held: Held | None = None) -> Flow:
    """Find the steady flow between the pressures that are given.

    Cells that no given pressure can reach stand still. Raises CleaningError where shapes do not fit.
    """
    padded = pad(grid, rim, held)
    links = link(grid, rim, None if held is None else held.level)
    if links.free.any():
        matrix, loads = assemble(links, padded)
        # MMD on A' + A keeps the factors of a symmetric matrix sparse
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        inside = padded[:, 1:-1, 1:-1]
        inside[:, links.free] = factors.solve(loads).T
        for _ in range(REFINEMENTS):
            along, across = _flows(links, padded)
            missing = -(np.diff(along, axis=2) + np.diff(across, axis=1))[:, links.free]
            inside[:, links.free] += factors.solve(np.ascontiguousarray(missing.T)).T
    along, across = _flows(links, padded)
    fixed = np.zeros(grid.shape, dtype=np.bool_) if held is None else held.level <= 0
    return Flow(padded[:, 1:-1, 1:-1], along, across, links.free | fixed, fixed)


def link(grid: Grid, rim: Rim, level: NDArray[np.float64] | None = None) -> Links:
    """Join the halves of neighbours, and those at the rim to the sides that are open."""
    rows, columns = grid.shape
    along, across = np.zeros((rows, columns + 1)), np.zeros((rows + 1, columns))
    along[:, 1:-1] = in_series(grid.right[:, :-1], grid.left[:, 1:])
    across[1:-1] = in_series(grid.back[:-1], grid.front[1:])
    along[:, 0] = np.where(_open_faces(rim.left, rows), grid.left[:, 0], 0.0)
    along[:, -1] = np.where(_open_faces(rim.right, rows), grid.right[:, -1], 0.0)
    across[0] = np.where(_open_faces(rim.front, columns), grid.front[0], 0.0)
    across[-1] = np.where(_open_faces(rim.back, columns), grid.back[-1], 0.0)
    if level is not None:
        along[:, 1:-1] = _to_outline(
            level[:, :-1], level[:, 1:], (grid.right[:, :-1], grid.left[:, 1:]), along[:, 1:-1]
        )
        across[1:-1] = _to_outline(level[:-1], level[1:], (grid.back[:-1], grid.front[1:]), across[1:-1])
    fixed = np.zeros(grid.shape, dtype=np.bool_) if level is None else level <= 0
    return Links(along, across, _reached(along, across, fixed) & ~fixed)


def assemble(links: Links, padded: Fields) -> tuple[sparse.csc_array, NDArray[np.float64]]:
    """Balance the flows of every free cell: the matrix (n, n) and the loads (n, k).

    ``padded`` (k, rows + 2, columns + 2) holds the given pressures; those of free cells must be 0.
    """
    free = links.free
    number = np.full(free.shape, -1)
    number[free] = np.arange(int(free.sum()))
    total = links.along[:, :-1] + links.along[:, 1:] + links.across[:-1] + links.across[1:]
    pairs = (
        (number[:, :-1], number[:, 1:], links.along[:, 1:-1]),
        (number[:-1], number[1:], links.across[1:-1]),
    )
    rows, columns, values = [number[free]], [number[free]], [total[free]]
    for one, other, conductance in pairs:
        joined = (one >= 0) & (other >= 0) & (conductance > 0)
        rows += [one[joined], other[joined]]
        columns += [other[joined], one[joined]]
        values += [-conductance[joined]] * 2
    size = int(free.sum())
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    matrix = sparse.csc_array(entries, shape=(size, size))
    brought = (
        links.along[:, :-1] * padded[:, 1:-1, :-2]
        + links.along[:, 1:] * padded[:, 1:-1, 2:]
        + links.across[:-1] * padded[:, :-2, 1:-1]
        + links.across[1:] * padded[:, 2:, 1:-1]
    )
    return matrix, np.ascontiguousarray(brought[:, free].T)


def pad(grid: Grid, rim: Rim, held: Held | None = None) -> Fields:
    """Lay the pressures of the rim around the cells: (k, rows + 2, columns + 2); 0 where none is given."""
    sides, inside = _pressures(grid, rim, held)
    padded = np.pad(inside, ((0, 0), (1, 1), (1, 1)))
    padded[:, 1:-1, 0], padded[:, 1:-1, -1], padded[:, 0, 1:-1], padded[:, -1, 1:-1] = sides
    return padded


def _flows(links: Links, padded: Fields) -> tuple[Fields, Fields]:
    """Volume flow times viscosity through all faces, from differences of pressure, which lose no digits."""
    along = links.along * -np.diff(padded[:, 1:-1, :], axis=2)
    return along, links.across * -np.diff(padded[:, :, 1:-1], axis=1)


def _to_outline(
    one: NDArray[np.float64],
    other: NDArray[np.float64],
    halves: tuple[NDArray[np.float64], NDArray[np.float64]],
    joined: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Put the given pressure onto the outline between an open and a held cell; held ones exchange nothing."""
    outer, inner = (one > 0) & (other <= 0), (one <= 0) & (other > 0)
    gap = np.abs(one) + np.abs(other)
    reach = np.maximum(np.maximum(one, other) / np.where(gap > 0, gap, 1.0), NEAREST)
    result = np.where(outer, halves[0] * 0.5 / reach, joined)
    result = np.where(inner, halves[1] * 0.5 / reach, result)
    return np.where((one <= 0) & (other <= 0), 0.0, result)


def _reached(along: NDArray[np.float64], across: NDArray[np.float64], fixed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Find the cells that are joined, through whatever others, to the rim or to a held cell."""
    rows, columns = fixed.shape
    number = np.arange(rows * columns).reshape(rows, columns)
    touches = fixed.copy()
    touches[:, 0] |= along[:, 0] > 0
    touches[:, -1] |= along[:, -1] > 0
    touches[0] |= across[0] > 0
    touches[-1] |= across[-1] > 0
    beside, above = along[:, 1:-1] > 0, across[1:-1] > 0
    first = np.concatenate([number[:, :-1][beside], number[:-1][above]])
    second = np.concatenate([number[:, 1:][beside], number[1:][above]])
    graph = sparse.coo_array((np.ones(len(first)), (first, second)), shape=(number.size, number.size))
    count, labels = cast("tuple[int, NDArray[np.int32]]", csgraph.connected_components(graph, directed=False))
    wet = np.zeros(count, dtype=np.bool_)
    wet[labels[touches.ravel()]] = True
    return wet[labels].reshape(rows, columns)


def _pressures(grid: Grid, rim: Rim, held: Held | None) -> tuple[list[NDArray[np.float64]], Fields]:
    """Bring all pressures to k sets: four sides (k, n), and inside (k, rows, columns)."""
    rows, columns = grid.shape
    given = [rim.left, rim.right, rim.front, rim.back]
    sides = [np.asarray(0.0 if side is None else side, dtype=np.float64) for side in given]
    sides = [np.where(np.isnan(side), 0.0, side) for side in sides]
    lengths = [(rows,), (rows,), (columns,), (columns,)]
    inside, place = np.zeros(grid.shape), grid.shape
    if held is not None:
        if held.level.shape != place:
            raise CleaningError(f"the level of held cells is {held.level.shape}, the grid {place}")
        inside = np.where(held.level <= 0, np.asarray(held.pressure, dtype=np.float64), 0.0)
    sets = [len(side) for side in sides if side.ndim == 2] + ([len(inside)] if inside.ndim == 3 else [])
    count = max(sets, default=1)
    try:
        wide = [np.broadcast_to(side, (count, *length)) for side, length in zip(sides, lengths, strict=True)]
        filled = np.broadcast_to(inside, (count, *place))
    except ValueError as error:
        raise CleaningError(f"pressures do not fit a gap of {rows} rows and {columns} columns: {error}") from error
    if not (np.isfinite(filled).all() and all(np.isfinite(side).all() for side in wide)):
        raise CleaningError("pressures in a gap must be finite")
    return wide, filled


def _open_faces(side: ArrayLike | None, faces: int) -> NDArray[np.bool_]:
    """Tell which faces of a side have a pressure, in every set."""
    if side is None:
        return np.zeros(faces, dtype=np.bool_)
    given = np.atleast_2d(np.asarray(side, dtype=np.float64))
    return np.broadcast_to(~np.isnan(given).any(axis=0), faces)
