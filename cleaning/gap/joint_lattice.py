"""How much of the cells of a gap, and of the ways between them, solder joints take."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from boards.undersides.underside import Joint, joint_polygon
from cleaning.gap.hele_shaw import Apertures, Field2
from geometry.arrays import Scalars

LINES = 4
"""Lines across each half cell along which its opening is measured."""
LEAST_OPENING = 1e-3
"""Share of a half cell's width below which it is closed: what is less comes from rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Outlines:
    """Rectangles and discs in the frame of the underside, m; all (j,)."""

    x: Scalars
    y: Scalars
    half_length: Scalars
    half_width: Scalars
    along: Scalars
    """Cosine of the turn: the x of the direction of the length."""
    across: Scalars
    """Sine of the turn."""
    round: NDArray[np.bool_]

    @property
    def mirrored(self) -> "Outlines":
        """The same with x and y swapped."""
        return Outlines(self.y, self.x, self.half_length, self.half_width, self.across, self.along, self.round)


@dataclass(frozen=True, slots=True)
class Lattice:
    """Where the cells of a rectangle are that has its middle in the origin. m."""

    length_m: float
    width_m: float
    rows: int
    columns: int

    @property
    def shape(self) -> tuple[int, int]:
        """Rows along y, columns along x."""
        return self.rows, self.columns

    @property
    def dx_m(self) -> float:
        """Cell size along x."""
        return self.length_m / self.columns

    @property
    def dy_m(self) -> float:
        """Cell size along y."""
        return self.width_m / self.rows


def quantised(joint: Joint) -> Joint:
    """Round to a nanometre: far below what any file means, it hides the last bits of a board that was turned."""
    x, y, length, width = (round(value, 6) + 0.0 for value in (joint.x_mm, joint.y_mm, joint.length_mm, joint.width_mm))
    return Joint(x, y, length, width, joint.round, round(joint.turn_rad, 9) + 0.0)


def outlines_of(joints: Sequence[Joint], round_skin_m: float = 0.0, straight_skin_m: float = 0.0) -> Outlines:
    """Take the outlines of joints, each moved outwards by the skin of its kind."""
    table = np.array([[j.x_mm, j.y_mm, j.length_mm, j.width_mm] for j in joints]).reshape(-1, 4) * 1e-3
    disc = np.array([joint.round for joint in joints], dtype=np.bool_)
    turn = np.array([joint.turn_rad for joint in joints], dtype=np.float64)
    skin = np.where(disc, round_skin_m, straight_skin_m)
    half_width = np.where(disc, table[:, 2], table[:, 3]) / 2 + skin
    return Outlines(table[:, 0], table[:, 1], table[:, 2] / 2 + skin, half_width, np.cos(turn), np.sin(turn), disc)


def apertures(walls: Outlines, lattice: Lattice) -> Apertures:
    """Measure how far walls close each half cell towards its neighbour.

    Along lines across the way, what is open is exact; behind one another, the lines resist in series. This narrows ways
    between leads much finer than a cell by what the leads take, and lets no liquid through a thin, long wall.
    """
    left, right = _halves(walls.mirrored, lattice.width_m, lattice.length_m, lattice.rows, lattice.columns)
    front, back = _halves(walls, lattice.length_m, lattice.width_m, lattice.columns, lattice.rows)
    return Apertures(left.T, right.T, front, back)


def cover(walls: Outlines, lattice: Lattice) -> Field2:
    """Share of each cell (rows, columns) that walls take; where they overlap it counts once."""
    flat = _along_lines(walls, lattice.length_m, lattice.width_m, lattice.columns, lattice.rows)
    upright = _along_lines(walls.mirrored, lattice.width_m, lattice.length_m, lattice.rows, lattice.columns)
    return 0.5 * (flat.mean(axis=(1, 2)) + upright.mean(axis=(1, 2)).T)


def covered_share(joints: Sequence[Joint], lattice: Lattice) -> float:
    """Share of the whole rectangle that joints take; where they overlap it counts once."""
    across, along = 500.0 * lattice.length_m, 500.0 * lattice.width_m  # halves, mm
    taken = shapely.disjoint_subset_union_all([joint_polygon(joint) for joint in joints])
    return min(taken.intersection(shapely.box(-across, -along, across, along)).area / (4.0 * across * along), 1.0)


def _halves(walls: Outlines, length_m: float, width_m: float, columns: int, rows: int) -> tuple[Field2, Field2]:
    """Openings of the lower and the upper half of each cell, for flow along y: (rows, columns) both."""
    opening = 1.0 - _along_lines(walls, length_m, width_m, columns, rows)
    opening[opening < LEAST_OPENING] = 0.0
    closed = (opening == 0.0).any(axis=2)
    resistance = (1.0 / np.where(opening == 0.0, 1.0, opening)).mean(axis=2)
    open_share = np.where(closed, 0.0, 1.0 / resistance)
    return open_share[:, 0], open_share[:, 1]


def _along_lines(walls: Outlines, length_m: float, width_m: float, columns: int, rows: int) -> NDArray[np.float64]:
    """Share that walls take of each cell's stretch of lines along x: (rows, 2 halves, LINES, columns)."""
    count = rows * 2 * LINES
    lines = ((np.arange(count) + 0.5) / count - 0.5) * width_m
    edges = (np.arange(columns + 1) / columns - 0.5) * length_m
    begin, end = _chords(walls, lines)
    taken = np.zeros((count, columns))
    if begin.shape[1]:
        order = np.argsort(begin, axis=1, kind="stable")
        begin, end = np.take_along_axis(begin, order, axis=1), np.take_along_axis(end, order, axis=1)
        # of overlapping chords, each counts from where all before it have ended
        ended = np.maximum.accumulate(end, axis=1)
        begin[:, 1:] = np.maximum(begin[:, 1:], ended[:, :-1])
        for column in range(columns):
            inside = np.minimum(end, edges[column + 1]) - np.maximum(begin, edges[column])
            taken[:, column] = np.maximum(inside, 0.0).sum(axis=1)
    return np.minimum(taken * (columns / length_m), 1.0).reshape(rows, 2, LINES, columns)


def _chords(walls: Outlines, lines: Scalars) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where each line along x enters and leaves each outline: (lines, j) both; an empty chord ends where it begins."""
    up = lines[:, None] - walls.y
    reach = np.sqrt(np.maximum(walls.half_length**2 - up**2, 0.0))
    begin, end = -reach, reach
    # a rectangle is where two slabs cross; |x along + up across| <= half length, |up along - x across| <= half width
    first = _slab(walls.along, up * walls.across, walls.half_length)
    second = _slab(-walls.across, up * walls.along, walls.half_width)
    begin = np.where(walls.round, begin, np.maximum(first[0], second[0]))
    end = np.where(walls.round, end, np.minimum(first[1], second[1]))
    end = np.maximum(begin, end)
    return begin + walls.x, end + walls.x


def _slab(
    slope: Scalars, offset: NDArray[np.float64], half: Scalars
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stretch of x in which ``|slope x + offset| <= half``; without slope all or nothing, as a finite stretch."""
    far = 1e3
    flat = np.abs(slope) < 1e-9
    safe = np.where(flat, 1.0, slope)
    one, other = (-half - offset) / safe, (half - offset) / safe
    within = np.abs(offset) < half - 1e-12
    begin = np.where(flat, np.where(within, -far, far), np.minimum(one, other))
    end = np.where(flat, np.where(within, far, far), np.maximum(one, other))
    return begin, end
