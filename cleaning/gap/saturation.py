"""How far liquid has loaded itself with what it dissolves on its way through a gap."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from cleaning.gap.hele_shaw import Flow
from cleaning.require import require_not_negative, require_positive

STILL = 1e-12
"""Share of the strongest flow below which a face lets nothing through: rounding makes circles otherwise."""
_NOTHING = 1e-300


def saturation(
    dissolving_m_s: ArrayLike, path_m: ArrayLike, u_m_s: ArrayLike, height_m: ArrayLike
) -> NDArray[np.float64]:
    """Share of saturation at the end of a way through a gap of even height: 1 - exp(-k L / (u h)).

    ``dissolving_m_s`` is the mass transfer coefficient of the soiled wall. What stands still is saturated. All
    arguments broadcast.
    """
    require_not_negative(dissolving_m_s=dissolving_m_s, path_m=path_m, u_m_s=u_m_s)
    require_positive(height_m=height_m)
    ways = np.asarray(dissolving_m_s, dtype=np.float64) * np.asarray(path_m, dtype=np.float64)
    flow = np.asarray(u_m_s, dtype=np.float64) * np.asarray(height_m, dtype=np.float64)
    return -np.expm1(-ways / np.maximum(flow, _NOTHING))


def saturation_in(
    flow: Flow, soiled_m2: ArrayLike, dissolving_m_s: float, viscosity_pa_s: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Follow fresh liquid from the rim through every cell: what it carries when it leaves the cell, and the gap.

    Liquids that meet in a cell mix, then run along its soiled area as along a way: exact where they do not meet.
    Where nothing flows, liquid is saturated.

    Args:
        flow: k steady flows.
        soiled_m2: wall area of each cell that dissolves: a number or (rows, columns).
        dissolving_m_s: mass transfer coefficient.
        viscosity_pa_s: of the liquid.

    Returns:
        (k, rows, columns) and (k,) shares of saturation; the second is the mean of what leaves through the rim.
    """
    require_not_negative(soiled_m2=soiled_m2, dissolving_m_s=dissolving_m_s)
    require_positive(viscosity_pa_s=viscosity_pa_s)
    shape = flow.pressure.shape[1:]
    area = np.broadcast_to(np.asarray(soiled_m2, dtype=np.float64), shape).ravel()
    cells, ends = np.ones(flow.pressure.shape), np.ones(len(flow.pressure))
    for index in range(len(flow.pressure)):
        fresh, leaving = _freshness(flow.along[index], flow.across[index], area * dissolving_m_s * viscosity_pa_s)
        cells[index] = 1.0 - fresh.reshape(shape)
        if leaving.sum() > 0:
            ends[index] = 1.0 - float(leaving @ fresh) / float(leaving.sum())
    return cells, ends


def _freshness(
    along: NDArray[np.float64], across: NDArray[np.float64], uptake: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What is left to saturation where liquid leaves each cell, and how much leaves it through the rim: (cells,)."""
    rows, columns = across.shape[0] - 1, along.shape[1] - 1
    still = STILL * max(float(np.abs(along).max(initial=0.0)), float(np.abs(across).max(initial=0.0)))
    along, across = (np.where(np.abs(faces) > still, faces, 0.0) for faces in (along, across))
    number = np.arange(rows * columns).reshape(rows, columns)
    beside = (number[:, :-1].ravel(), number[:, 1:].ravel(), along[:, 1:-1].ravel())
    above = (number[:-1].ravel(), number[1:].ravel(), across[1:-1].ravel())
    lower, upper, passed = (np.concatenate(pair) for pair in zip(beside, above, strict=True))
    source, target = np.where(passed > 0, lower, upper), np.where(passed > 0, upper, lower)
    entering, leaving = np.zeros((rows, columns)), np.zeros((rows, columns))
    for side, faces in ((np.s_[:, 0], along[:, 0]), (np.s_[:, -1], -along[:, -1])):
        entering[side] += np.maximum(faces, 0.0)
        leaving[side] += np.maximum(-faces, 0.0)
    for side, faces in ((np.s_[0], across[0]), (np.s_[-1], -across[-1])):
        entering[side] += np.maximum(faces, 0.0)
        leaving[side] += np.maximum(-faces, 0.0)
    through = entering.ravel() + np.bincount(target, np.abs(passed), rows * columns)
    moving = through > 0
    kept = np.where(moving, np.exp(-uptake / np.where(moving, through, 1.0)), 0.0)
    carried = sparse.coo_array((kept[target] * np.abs(passed), (target, source)), shape=(rows * columns,) * 2)
    balance = sparse.diags_array(np.where(moving, through, 1.0)) - carried
    fresh = splu(balance.tocsc()).solve(kept * entering.ravel())
    return fresh, leaving.ravel()
