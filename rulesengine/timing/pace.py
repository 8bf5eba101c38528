"""The greatest speed along a path that something besides the recipe allows: the robot that will follow it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars


@dataclass(frozen=True, eq=False)
class Pace:
    """Stretches (k,) of a path, ascending and apart, and the highest squared speed along each, even between its ends.

    In the path parameter of ``corner_blending.Path``: mm and s, or radians and s on turns on the spot.
    """

    begin: Scalars
    end: Scalars
    first: Scalars
    """Squared speed where the stretch begins,"""
    last: Scalars
    """and where it ends."""

    def between(self, borders: Scalars) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """Give which stages between m + 1 borders are limited (m,), and how at their begins and ends (2, m).

        No stage is in two stretches; infinite where nothing limits it.
        """
        middle = 0.5 * (borders[:-1] + borders[1:])
        if len(self.begin) == 0:
            return np.zeros(len(middle), dtype=np.bool_), np.full((2, len(middle)), np.inf)
        which = np.maximum(np.searchsorted(self.begin, middle, side="right") - 1, 0)
        limited = (self.begin[which] < middle) & (middle < self.end[which])
        places = np.stack((borders[:-1], borders[1:]))
        share = np.clip((places - self.begin[which]) / self._length[which], 0.0, 1.0)
        highest = self.first[which] + share * (self.last[which] - self.first[which])
        return limited, np.where(limited, highest, np.inf)

    def within(self, other: "Pace") -> "Pace":
        """Give the pace that is nowhere above the one or the other."""
        borders = np.unique(np.concatenate((self.begin, self.end, other.begin, other.end)))
        if len(borders) < 2:
            return FREE
        borders = borders[np.concatenate(([True], np.diff(borders) > _SAME))]
        borders = np.union1d(borders, self._crossings(other, borders))
        ones, others = self.between(borders), other.between(borders)
        limited = ones[0] | others[0]
        highest = np.minimum(ones[1], others[1])[:, limited]
        return Pace(borders[:-1][limited], borders[1:][limited], highest[0], highest[1])

    def _crossings(self, other: "Pace", borders: Scalars) -> Scalars:
        """Give where one of two paces that limit the same stretch goes under the other."""
        ones, others = self.between(borders), other.between(borders)
        both = np.flatnonzero(ones[0] & others[0])
        begin, end = ones[1][:, both] - others[1][:, both]
        crossed = begin * end < 0.0
        share = begin[crossed] / (begin - end)[crossed]
        at = borders[both[crossed]]
        return at + share * (borders[both[crossed] + 1] - at)

    @cached_property
    def _length(self) -> Scalars:
        return self.end - self.begin


_SAME = 1e-7
_NONE = np.zeros(0)
FREE = Pace(_NONE, _NONE, _NONE, _NONE)
"""Only the recipe's limits hold."""
