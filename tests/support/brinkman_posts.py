"""A second opinion on arrays of posts: viscous flow between plates around round posts, in two dimensions.

Brinkman's equation, -grad p + mu lap u - 12 mu u / h^2 = 0, in one periodic cell on a staggered grid. It knows the drag
of the plates and of the posts' sides, but takes the profile across the gap to be a parabola everywhere.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

DIRECTIONS = ((0, 1), (0, -1), (1, 1), (1, -1))  # axis, shift


def brinkman_factor(solid: float, height: float, cells: int) -> float:
    """Mean flow over h^2 / 12, for a share of posts and a height in pitches."""
    size = 1.0 / cells
    edge, middle = np.arange(cells) * size - 0.5, (np.arange(cells) + 0.5) * size - 0.5
    radius = np.sqrt(solid / np.pi)
    along = np.hypot(edge[:, None], middle) - radius  # where u stands: on faces across x
    across = np.hypot(middle[:, None], edge) - radius
    first = numbered(along > 0, 0)
    second = numbered(across > 0, first.max() + 1)
    touched = (first >= 0) | (np.roll(first, -1, 0) >= 0) | (second >= 0) | (np.roll(second, -1, 1) >= 0)
    pressure = numbered(touched, second.max() + 1)
    entries = [
        *friction(first, along, size, 12.0 / height**2),
        *friction(second, across, size, 12.0 / height**2),
        *gradient(first, pressure, 0, size),
        *gradient(second, pressure, 1, size),
        (pressure[touched], pressure[touched], np.full(touched.sum(), 1e-11)),  # any level of pressure will do
    ]
    rows, columns, values = (np.concatenate([entry[k] for entry in entries]) for k in range(3))
    count = int(pressure.max()) + 1
    load = np.zeros(count)
    load[first[first >= 0]] = 1.0
    found = splu(sparse.csc_array((values, (rows, columns)), shape=(count, count))).solve(load)
    return float(found[first[first >= 0]].sum()) * size**2 / (height**2 / 12.0)


def numbered(mask: NDArray[np.bool_], begin: int) -> NDArray[np.int64]:
    """Count through what is open; -1 elsewhere."""
    number = np.full(mask.shape, -1)
    number[mask] = begin + np.arange(int(mask.sum()))
    return number


def friction(
    number: NDArray[np.int64], level: NDArray[np.float64], size: float, plates: float
) -> list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]]:
    """Drag of the plates and of neighbours; a post's side stands where the level is 0."""
    is_open = number >= 0
    diagonal = np.full(number.shape, plates)
    entries: list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]] = []
    for axis, shift in DIRECTIONS:
        other, beyond = np.roll(number, shift, axis), np.roll(level, shift, axis)
        joined = is_open & (other >= 0)
        entries.append((number[joined], other[joined], np.full(joined.sum(), -1.0 / size**2)))
        reach = np.where(joined, 1.0, np.maximum(level / np.where(level > beyond, level - beyond, 1.0), 1e-3))
        diagonal += 1.0 / (reach * size**2)
    return [*entries, (number[is_open], number[is_open], diagonal[is_open])]


def gradient(
    number: NDArray[np.int64], pressure: NDArray[np.int64], axis: int, size: float
) -> list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]]:
    """Pressure drives the flow, and what flows into a cell flows out of it: one matrix and its transpose."""
    is_open = number >= 0
    rate = np.full(int(is_open.sum()), 1.0 / size)
    ahead, behind = pressure[is_open], np.roll(pressure, 1, axis)[is_open]
    pairs = [(number[is_open], ahead, rate), (number[is_open], behind, -rate)]
    return [*pairs, *((column, row, value) for row, column, value in pairs)]
