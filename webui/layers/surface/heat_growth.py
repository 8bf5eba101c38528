"""What has landed on a surface up to a moment of the program."""

import numpy as np

from cleaning.exposure.exposure import Growth
from geometry.arrays import Scalars


class Accumulation:
    """Adds up what lands on the cells; going on in time costs only what is new.

    Not for several threads at once.
    """

    def __init__(self, growth: Growth, cells: int) -> None:
        """Begin with nothing.

        Args:
            growth: What lands when.
            cells: How many there are.
        """
        self._growth, self._cells = growth, cells
        self._blocks = 0
        self._sum: Scalars = np.zeros(cells)

    def until(self, time_s: float) -> Scalars:
        """(c,) volume per area, mm, of all blocks that have ended at a moment of the program."""
        blocks = int(np.searchsorted(self._growth.until_s, time_s, side="right"))
        if blocks < self._blocks:
            self._blocks, self._sum = 0, np.zeros(self._cells)
        if blocks > self._blocks:
            new = slice(int(self._growth.start[self._blocks]), int(self._growth.start[blocks]))
            self._sum = self._sum + np.bincount(
                self._growth.cell[new], self._growth.volume_mm[new], minlength=self._cells
            )
            self._blocks = blocks
        return self._sum
