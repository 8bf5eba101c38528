"""The judge of arrays of posts in gaps: Stokes flow in three dimensions around one round post between two plates.

A periodic cell on a staggered grid, the lower half of the gap; pressure from conjugate gradients on what the velocities
that it drives fail to conserve (Uzawa). The sides of the post stand where they are, between the points of the grid,
and are the same in every layer, so the modes across the gap do not mix: each is a flow in two dimensions.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg, splu

Mask: TypeAlias = NDArray[np.bool_]
Numbers: TypeAlias = NDArray[np.int64]


def stokes_factor(solid: float, height: float, cells: int, layers: int) -> float:
    """Mean flow over that without a post, for a share of posts and a height in pitches."""
    size, rise = 1.0 / cells, 0.5 * height / layers
    edge, middle = np.arange(cells) * size - 0.5, (np.arange(cells) + 0.5) * size - 0.5
    radius = np.sqrt(solid / np.pi)
    levels = [np.hypot(x[:, None], y) - radius for x, y in ((edge, middle), (middle, edge), (middle, middle))]
    number = [numbered(level > 0) for level in levels]
    touched = (number[0] >= 0) | (np.roll(number[0], -1, 0) >= 0) | (number[1] >= 0) | (np.roll(number[1], -1, 1) >= 0)
    pressure = numbered(touched)
    flat, upright = wall_layers(layers) / rise**2, inner_layers(layers - 1) / rise**2
    drags = [friction(one, level, size) for one, level in zip(number, levels, strict=True)]
    solve = [solver_of(drag, across) for drag, across in zip(drags, (flat, flat, upright), strict=True)]
    steps = sparse.diags_array([-np.ones(layers - 1), np.ones(layers - 1)], offsets=[0, 1], shape=(layers - 1, layers))
    slopes = [
        sparse.kron(gradient(number[0], pressure, 0) / size, sparse.eye_array(layers)).tocsr(),
        sparse.kron(gradient(number[1], pressure, 1) / size, sparse.eye_array(layers)).tocsr(),
        sparse.kron(standing(number[2], pressure), steps / rise).tocsr(),
    ]
    force = np.ones(drags[0].shape[0] * layers)
    count = (int(pressure.max()) + 1) * layers

    def lack(field: NDArray[np.float64]) -> NDArray[np.float64]:
        return sum(slope.T @ speeds(slope @ field) for slope, speeds in zip(slopes, solve, strict=True))

    found, _ = cg(LinearOperator((count, count), matvec=lack), slopes[0].T @ solve[0](force), rtol=1e-6)
    speed = solve[0](force - slopes[0] @ found)
    without = np.linalg.solve(flat.toarray(), np.ones(layers)).mean()
    return float(speed.sum() * size**2 / layers / without)


def numbered(mask: Mask) -> Numbers:
    """Count through what is open; -1 elsewhere."""
    number = np.full(mask.shape, -1)
    number[mask] = np.arange(int(mask.sum()))
    return number


def friction(number: Numbers, level: NDArray[np.float64], size: float) -> sparse.csc_array:
    """Drag of neighbours in one layer; the post's side stands where the level is 0."""
    is_open = number >= 0
    diagonal = np.zeros(number.shape)
    entries: list[tuple[Numbers, Numbers, NDArray[np.float64]]] = []
    for axis, shift in ((0, 1), (0, -1), (1, 1), (1, -1)):
        other, beyond = np.roll(number, shift, axis), np.roll(level, shift, axis)
        joined = is_open & (other >= 0)
        entries.append((number[joined], other[joined], np.full(int(joined.sum()), -1.0 / size**2)))
        reach = np.where(joined, 1.0, np.maximum(level / np.where(level > beyond, level - beyond, 1.0), 1e-3))
        diagonal += 1.0 / (reach * size**2)
    entries.append((number[is_open], number[is_open], diagonal[is_open]))
    rows, columns, values = (np.concatenate([entry[k] for entry in entries]) for k in range(3))
    return sparse.csc_array((values, (rows, columns)))


def wall_layers(layers: int) -> sparse.csc_array:
    """Drag between layers: the plate half a layer below the first, the middle of the gap above the last."""
    middle = np.full(layers, 2.0)
    middle[0], middle[-1] = 3.0, 1.0
    return sparse.diags_array([-np.ones(layers - 1), middle, -np.ones(layers - 1)], offsets=[-1, 0, 1]).tocsc()


def inner_layers(layers: int) -> sparse.csc_array:
    """The same of what rises, which stands between layers and is nothing at the plate and in the middle."""
    beside = -np.ones(layers - 1)
    return sparse.diags_array([beside, np.full(layers, 2.0), beside], offsets=[-1, 0, 1]).tocsc()


def solver_of(drag: sparse.csc_array, across: sparse.csc_array) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """Solve for speeds under the drag within layers and between them, mode by mode across the gap."""
    rates, modes = np.linalg.eigh(across.toarray())
    unit = sparse.eye_array(drag.shape[0], format="csc")
    each_mode = [
        splu((drag + rate * unit).tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        for rate in rates
    ]

    def speeds(force: NDArray[np.float64]) -> NDArray[np.float64]:
        by_mode = force.reshape(-1, len(rates)) @ modes
        found = np.stack([one.solve(by_mode[:, column]) for column, one in enumerate(each_mode)], axis=1)
        return (found @ modes.T).ravel()

    return speeds


def gradient(number: Numbers, pressure: Numbers, axis: int) -> sparse.csc_array:
    """Difference of pressure across each open face."""
    is_open = number >= 0
    rate = np.ones(int(is_open.sum()))
    columns = np.concatenate([pressure[is_open], np.roll(pressure, 1, axis)[is_open]])
    rows = np.tile(number[is_open], 2)
    return sparse.csc_array(
        (np.concatenate([rate, -rate]), (rows, columns)), shape=(len(rate), int(pressure.max()) + 1)
    )


def standing(number: Numbers, pressure: Numbers) -> sparse.csc_array:
    """Pick the pressure below and above what rises."""
    is_open = number >= 0
    entries = (np.ones(int(is_open.sum())), (number[is_open], pressure[is_open]))
    return sparse.csc_array(entries, shape=(int(is_open.sum()), int(pressure.max()) + 1))
