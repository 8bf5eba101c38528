"""Which of many discs in the plane reach a place: the discs by the squares of a grid that they touch."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Points2, Scalars
from geometry.compiled import compiled

_SHARE = 0.5
"""Edge of a square over the mean radius: finer grids take more memory, coarser ones give more discs to a place."""
_MOST_SQUARES = 64
"""Along the longer side of the grid."""
_SLACK = 1e-6
"""Of lengths, and mm: what touches a square but for rounding belongs to it."""


@dataclass(frozen=True, slots=True, eq=False)
class DiscGrid:
    """Discs by squares. mm."""

    low: tuple[float, float]
    """Lower left corner of the grid."""
    edge_mm: float
    """Of a square."""
    across: int
    """Squares along x,"""
    up: int
    """and along y."""
    start: Indices
    """(squares + 1,) where the discs of each square begin, row after row."""
    disc: NDArray[np.int32]
    """Numbers of the discs, ascending in each square."""

    def near(self, x: float, y: float) -> NDArray[np.int32]:
        """Give the numbers of all discs that reach a place within the grid, and of some that do not; ascending."""
        column = min(max(int((x - self.low[0]) / self.edge_mm), 0), self.across - 1)
        row = min(max(int((y - self.low[1]) / self.edge_mm), 0), self.up - 1)
        square = row * self.across + column
        return self.disc[self.start[square] : self.start[square + 1]]


def build_disc_grid(centres: Points2, radii: Scalars, places: Points2) -> DiscGrid:
    """Sort discs into squares.

    Args:
        centres: (n, 2) of the discs; those of infinite radius may be anywhere.
        radii: (n,) of the discs; infinite where one reaches every place, negative where it reaches none.
        places: (m, 2) that are going to be looked up; at least one. The grid spans them.
    """
    low, high = places.min(axis=0), places.max(axis=0)
    longest = max(float((high - low).max()), _SLACK)
    radii = np.where(radii < 0.0, -1.0, radii * (1.0 + _SLACK) + _SLACK)
    reaching = np.minimum(radii[radii >= 0.0], longest)
    typical = float(reaching.mean()) if len(reaching) else longest
    edge = max(_SHARE * typical, longest / _MOST_SQUARES)
    across, up = (np.floor((high - low) / edge).astype(np.int64) + 1).tolist()
    everywhere = np.isinf(radii)
    middle = (low + high) / 2
    centres = np.where(everywhere[:, None], middle, centres)
    # About the middle of the grid this radius reaches all of it.
    radii = np.where(everywhere, 2.0 * (longest + edge), radii)
    grid = (float(low[0]), float(low[1]), edge)
    counts = np.zeros(across * up + 1, dtype=np.int64)
    _sort_discs(centres, radii, grid, (across, up), counts, np.empty(0, dtype=np.int32))
    start = np.cumsum(counts)
    disc = np.empty(int(start[-1]), dtype=np.int32)
    _sort_discs(centres, radii, grid, (across, up), start.copy(), disc)
    return DiscGrid((grid[0], grid[1]), edge, across, up, start, disc)


@compiled
def _sort_discs(
    centres: Points2,
    radii: Scalars,
    grid: tuple[float, float, float],
    size: tuple[int, int],
    next_of: Indices,
    disc: NDArray[np.int32],
) -> None:
    """Count the discs of each square into ``next_of[square + 1]``; with room for them, put them where that points.

    A counting sort in two passes: when the numbers are put in place ``next_of[square]`` is the next free entry.
    """
    low_x, low_y, edge = grid
    across, up = size
    for number in range(len(radii)):
        x, y, radius = centres[number, 0] - low_x, centres[number, 1] - low_y, radii[number]
        if radius < 0.0:
            continue
        first, last = max(int(np.floor((x - radius) / edge)), 0), min(int(np.floor((x + radius) / edge)), across - 1)
        under, over = max(int(np.floor((y - radius) / edge)), 0), min(int(np.floor((y + radius) / edge)), up - 1)
        for row in range(under, over + 1):
            aside_y = max(max(row * edge - y, y - (row + 1) * edge), 0.0)
            for column in range(first, last + 1):
                aside_x = max(max(column * edge - x, x - (column + 1) * edge), 0.0)
                if aside_x * aside_x + aside_y * aside_y > radius * radius:
                    continue
                square = row * across + column
                if len(disc):
                    disc[next_of[square]] = number
                    next_of[square] += 1
                else:
                    next_of[square + 1] += 1
