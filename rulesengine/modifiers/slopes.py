"""The lowest profile with slopes of 45 degrees that clears all floors along a path."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Scalars
from rulesengine.strokes.safe_height import Span

_WIDER_MM = 1e-4  # a span that is only touched has a length too, and neighbours overlap
_FAR_MM = 1e9


@dataclass(frozen=True, slots=True, eq=False)
class Needed:
    """Least heights along a path: on each of k stretches the highest of a level, a fall and a rise of 45 degrees."""

    borders: Scalars
    """(k + 1,) ascending lengths between which the stretches lie, mm; the outer ones are far away."""
    level: Scalars
    """(k,) floor of each stretch; minus infinity where nothing is in the way."""
    fall: Scalars
    """(k,) height at length 0 of the line that falls from what lies before."""
    rise: Scalars
    """(k,) height at length 0 of the line that rises to what comes after."""

    def at(self, lengths: Scalars) -> Scalars:
        """Give the least heights at lengths along the path."""
        k = np.clip(np.searchsorted(self.borders, lengths, side="right") - 1, 0, len(self.level) - 1)
        return np.maximum(self.level[k], np.maximum(self.fall[k] - lengths, self.rise[k] + lengths))

    def bends(self, base_mm: float) -> Scalars:
        """Give all lengths at which the higher of the profile and a base height may change its slope, unsorted."""
        level = np.maximum(self.level, base_mm)
        with np.errstate(invalid="ignore"):  # where neither falls nor rises there is nothing to meet
            inside = [self.fall - level, level - self.rise, (self.fall - self.rise) / 2]
        kept = [marks[(marks > self.borders[:-1]) & (marks < self.borders[1:])] for marks in inside]
        return np.concatenate([self.borders[1:-1], *kept])


def needed_heights(spans: Sequence[Span], extra_mm: float) -> Needed:
    """Find the lowest profile over spans, in any order, that lies ``extra_mm`` above their floors; at least one."""
    columns: Scalars = np.array(spans, dtype=np.float64)
    start, end, floor = columns[:, 0] - _WIDER_MM, columns[:, 1] + _WIDER_MM, columns[:, 2] + extra_mm
    borders = np.unique(np.concatenate([[-_FAR_MM], start, end, [_FAR_MM]]))
    level = np.full(len(borders) - 1, -np.inf)
    first, last = np.searchsorted(borders, start), np.searchsorted(borders, end)
    for a, b, height in zip(first.tolist(), last.tolist(), floor.tolist(), strict=True):
        np.maximum(level[a:b], height, out=level[a:b])
    nothing = np.array([-np.inf])
    fall = np.concatenate([nothing, np.maximum.accumulate(level + borders[1:])[:-1]])
    rise = np.concatenate([np.maximum.accumulate((level - borders[:-1])[::-1])[::-1][1:], nothing])
    return Needed(borders, level, fall, rise)
