"""How far liquid has got into a gap: the front it makes on its way in, from any side and around any joint.

The pressure summed over time, w, obeys one elliptic problem with an obstacle instead of a moving boundary (Baiocchi;
Elliott and Janovsky 1981 for Hele-Shaw flow): div(h^3 / (12 mu) grad w) = h where it is wet, w = 0 where it is dry, and
w >= 0. On the rim w is the pressure, capillary pressure included, times how long it acted.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from cleaning.errors import CleaningError
from cleaning.gap.grid import Grid
from cleaning.gap.hele_shaw import Held, Rim, assemble, link, pad
from cleaning.require import require_not_negative, require_positive

MOST_STEPS = 400


@dataclass(frozen=True, slots=True, eq=False)
class Filling:
    """What is wet."""

    wet: NDArray[np.float64]
    """(rows, columns) share of each cell's liquid space that is filled, 0 to 1."""
    impulse_pa_s: NDArray[np.float64]
    """(rows, columns) pressure summed over time."""
    steps: int
    """Of the active set until nothing changed."""


def fill(grid: Grid, rim: Rim, depth_m: ArrayLike, viscosity_pa_s: float, held: Held | None = None) -> Filling:
    """Find what is wet after the rim's impulses (pressure times time, Pa s, not negative) have acted.

    A cell on the front is wet by the share that makes the volume balance close: what entered is what is wet.

    Args:
        grid: the gap.
        rim: impulse on each side; ``None`` where it is closed.
        depth_m: open volume per area of a cell: a number or (rows, columns).
        viscosity_pa_s: of the liquid.
        held: impulses inside, such as at holes that fill; not counted as wet themselves.

    Raises:
        CleaningError: an impulse is negative: liquid that runs out again is no filling; or a depth or the viscosity
            is no number that it can be.
    """
    require_not_negative(depth_m=depth_m)
    require_positive(viscosity_pa_s=viscosity_pa_s)
    padded = pad(grid, rim, held)
    links = link(grid, rim, None if held is None else held.level)
    if len(padded) > 1:
        raise CleaningError("a gap fills by one set of impulses at a time; sum them over time")
    if (padded < 0).any():
        raise CleaningError("a gap fills by pressures that are not negative; give the positive part")
    matrix, loads = assemble(links, padded)
    room = np.broadcast_to(np.asarray(depth_m, dtype=np.float64), grid.shape)[links.free]
    impulse, wet, steps = _obstacle(matrix, loads[:, 0], room * (viscosity_pa_s * grid.dx_m * grid.dy_m))
    everywhere, summed = np.zeros(grid.shape), np.zeros(grid.shape)
    everywhere[links.free], summed[links.free] = wet, impulse
    return Filling(everywhere, summed, steps)


def front_m(impulse_pa_s: float, height_m: float, viscosity_pa_s: float) -> float:
    """How far a straight front gets between plates: L^2 = h^2 w / (6 mu), which is Washburn's law for capillarity."""
    require_not_negative(impulse_pa_s=impulse_pa_s)
    require_positive(height_m=height_m, viscosity_pa_s=viscosity_pa_s)
    return float(np.sqrt(height_m**2 * impulse_pa_s / (6.0 * viscosity_pa_s)))


def _obstacle(
    matrix: sparse.csc_array, loads: NDArray[np.float64], room: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Solve A w + room * wet = loads with w >= 0, 0 <= wet <= 1, and wet = 1 where w > 0.

    Primal-dual active set (Hintermueller, Ito and Kunisch 2003): each step solves where it is wet, dries what came out
    negative and wets what would overflow.
    """
    wet = np.ones(len(loads), dtype=np.bool_)
    for step in range(1, MOST_STEPS + 1):
        impulse = np.zeros(len(loads))
        if wet.any():
            inside = np.flatnonzero(wet)
            factors = splu(
                matrix[inside][:, inside].tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}
            )
            impulse[inside] = factors.solve((loads - room)[inside])
        share = np.divide(loads - matrix @ impulse, room, out=np.zeros_like(room), where=room > 0)
        after = np.where(wet, impulse > 0, share > 1.0 + 1e-9)
        if (after == wet).all():
            return impulse, np.where(wet, 1.0, np.clip(share, 0.0, 1.0)), step
        wet = after
    raise CleaningError(f"the front in a gap was not found in {MOST_STEPS} steps; use fewer cells")
