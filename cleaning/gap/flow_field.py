"""Flow in the gap of one package class, per pascal on each edge segment."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from boards.undersides.underside import Joint
from cleaning.errors import CleaningError, require_not_negative, require_positive
from cleaning.gap.edge_segments import SEGMENTS
from cleaning.gap.hele_shaw import Flow, Grid, Rim, mobility_of, narrowed_grid, solve
from cleaning.gap.joint_lattice import Lattice, obstruct
from geometry.arrays import Indices, Points2

RESOLVED = 16
"""Cells per pitch from which an array of posts is drawn instead of replaced by its permeability."""
LEAST_OPEN = 0.05
"""Share of a cell that must be open for it to be listed."""
LEAST_POCKET = 0.5
"""The same of cells that liquid does not reach: less is the rest of a cell that a wall cuts off from its neighbour."""


@dataclass(frozen=True, slots=True, eq=False)
class GapField:
    """Depth-averaged flow in a gap whose height is ``height_m`` everywhere, linear in the eight edge pressures. SI.

    The mean velocity of a liquid of viscosity mu is ``einsum("sd,sck->dck", p, velocity) / mu`` for pressures p (8, d);
    the wall shear is ``6 |velocity| / height`` of the same sum, whatever the viscosity.
    """

    height_m: float
    length_m: float
    """Along x."""
    width_m: float
    shape: tuple[int, int]
    """(rows along y, columns along x) of the grid."""
    cells: Indices
    """(c,) flat indices, row by row, of the cells in which liquid can flow."""
    centres: Points2
    """(c, 2) in the frame of the underside."""
    pressure: NDArray[np.float32]
    """(8, c) pressure for one pascal on each segment (`edges.SEGMENTS`), none on the others."""
    velocity: NDArray[np.float32]
    """(8, c, 2) mean velocity times viscosity, for the same."""
    path_m: float
    """Mean length of the ways through the gap, each way counted by what flows on it: a rectangle's length if it is open
    at both ends only, l w (l + w) / (l^2 + w^2) if it is open all around, so the side of a square. Volume flow over
    volume is the mean speed over this."""
    open_share: float
    """Share of the underside that no joint takes."""
    coverage: float
    """Share of the underside that joints take."""
    open_cells: NDArray[np.float32] = field(default_factory=lambda: np.empty(0, dtype=np.float32))
    """(c,) share of each cell that no joint takes; empty: all of every cell."""

    @property
    def weights(self) -> NDArray[np.float32]:
        """(c,) weight of each cell in a mean over the gap, by its open area; their sum is 1."""
        share = self.open_cells if len(self.open_cells) else np.ones(len(self.cells), dtype=np.float32)
        return share / share.sum()


def solve_gap(length_m: float, width_m: float, height_m: float, joints: Sequence[Joint], cells: int = 20) -> GapField:
    """Find the flow under one component for a pascal on each of the eight edge segments.

    The longer side is cut into ``cells`` (made even), the shorter into cells of about the same size, but at least half
    as many. Joints that stand in an array finer than `RESOLVED` cells per pitch become a permeability,
    others narrow or close the ways between cells. All are thickened by the skin that slows the flow along them; what
    they cover is counted without it.

    Cells that are at least `LEAST_OPEN` open are listed. So are those, half open or more, to which no way leads: such
    a pocket has no pressure and no velocity. ``velocity`` is the mean over the open part of a cell.

    Args:
        length_m: along x, m.
        width_m: along y, m.
        height_m: of the gap, from board to component.
        joints: what stands in it, mm, in the frame of the underside.
        cells: along the longer side.

    Raises:
        CleaningError: a size is not positive, a joint is no outline, or there are fewer than two cells.
    """
    lattice = _lattice(length_m, width_m, height_m, cells)
    for joint in joints:
        if not np.isfinite((joint.x_mm, joint.y_mm, joint.turn_rad)).all():
            raise CleaningError(f"a joint needs a place, not ({joint.x_mm:g}, {joint.y_mm:g}) mm, {joint.turn_rad:g}")
        require_not_negative(length_mm=joint.length_mm, width_mm=joint.width_mm)
    obstruction = obstruct(joints, lattice, height_m, RESOLVED * min(lattice.dx_m, lattice.dy_m))
    mobility, share = mobility_of(height_m) * obstruction.factor, obstruction.open_share
    grid = narrowed_grid(mobility, lattice.dx_m, lattice.dy_m, obstruction.apertures)
    flow = solve(grid, _rim(lattice))
    listed = share >= np.where(flow.reached, LEAST_OPEN, LEAST_POCKET)
    if not listed.any():  # joints everywhere: nothing flows, but something is there to be judged
        listed, share = np.ones_like(listed), np.ones_like(share)
    along, across = _per_width(flow, grid)
    part = height_m * share[listed]
    speed = np.stack([along[:, listed] / part, across[:, listed] / part], axis=-1)
    x, y = grid.centres
    listed_at, centres = np.flatnonzero(listed).astype(np.int64), np.stack([x[listed], y[listed]], axis=1)
    found = (flow.pressure[:, listed].astype(np.float32), speed.astype(np.float32), _path(grid))
    taken = (1.0 - obstruction.coverage, obstruction.coverage, share[listed].astype(np.float32))
    return GapField(height_m, length_m, width_m, lattice.shape, listed_at, centres, *found, *taken)


def _lattice(length_m: float, width_m: float, height_m: float, cells: int) -> Lattice:
    require_positive(length_m=length_m, width_m=width_m, height_m=height_m)
    if cells < 2:
        raise CleaningError(f"a gap needs at least 2 cells along its longer side, not {cells}")
    longer = max(length_m, width_m)
    # even numbers: each half of a side has whole faces; the slack keeps usual ratios, such as a half, from the brink
    halves = (
        max(math.ceil(0.5 * cells * size / longer - 0.35), math.ceil(0.25 * cells)) for size in (length_m, width_m)
    )
    columns, rows = (2 * each for each in halves)
    return Lattice(length_m, width_m, rows, columns)


def _rim(lattice: Lattice) -> Rim:
    """A pascal on each segment alone."""
    rows, columns = lattice.shape
    lower, upper = np.arange(rows) < rows // 2, np.arange(rows) >= rows // 2
    west, east = np.arange(columns) < columns // 2, np.arange(columns) >= columns // 2
    sides = {"front": (0, west, 1, east), "right": (2, lower, 3, upper), "back": (4, east, 5, west)}
    sides["left"] = (6, upper, 7, lower)
    pressures: dict[str, NDArray[np.float64]] = {}
    for name, (one, first, other, second) in sides.items():
        pressures[name] = np.zeros((SEGMENTS, len(first)))
        pressures[name][one], pressures[name][other] = first, second
    return Rim(**pressures)


def _per_width(flow: Flow, grid: Grid) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Volume flow per width times viscosity in the middle of each cell, along x and along y: (k, rows, columns)."""
    along = 0.5 * (flow.along[:, :, :-1] + flow.along[:, :, 1:]) / grid.dy_m
    across = 0.5 * (flow.across[:, :-1] + flow.across[:, 1:]) / grid.dx_m
    return along, across


def _path(grid: Grid) -> float:
    """Mean length of the ways that liquid takes through the gap.

    Speed summed over the volume is flow times length of way. The same pressure drives liquid from left to right and,
    on its own, from front to back, the other two sides closed; each counts by what flows.
    """
    travelled = flowed = 0.0
    for rim in (Rim(left=1.0, right=0.0), Rim(front=1.0, back=0.0)):
        flow = solve(grid, rim)
        travelled += float(np.hypot(*_per_width(flow, grid)).sum()) * grid.dx_m * grid.dy_m
        flowed += float(np.maximum(flow.inflow, 0.0).sum())
    rows, columns = grid.shape
    return travelled / flowed if flowed > 0 else max(columns * grid.dx_m, rows * grid.dy_m)
