"""Changes of speed along a path: a limited acceleration that builds up within a time. mm and s, or degrees and s.

With the greatest acceleration a and the time r in which it builds up (the jerk is a/r) a change of speed takes
dv/a + r, or 2 sqrt(dv r/a) where a is not reached; it is symmetric, so its mean speed is that of its two ends.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, sqrt

_HALVINGS = 40


@dataclass(frozen=True, slots=True)
class Ramp:
    """How a speed may change."""

    acceleration: float
    rise_s: float = 0.0
    """In which the acceleration builds up; 0 where the jerk has no limit."""

    def duration(self, change: float) -> float:
        """Seconds that a change of speed takes."""
        size = abs(change)
        if size == 0.0:
            return 0.0
        if size >= self.acceleration * self.rise_s:
            return size / self.acceleration + self.rise_s
        return 2.0 * sqrt(size * self.rise_s / self.acceleration)

    def length(self, begin: float, end: float) -> float:
        """Way that a change of speed takes."""
        return 0.5 * (begin + end) * self.duration(end - begin)

    def reach(self, begin: float, length: float) -> float:
        """Greatest speed that is reached from another one within a way; the same downwards, seen from the end."""
        if self.acceleration == inf:
            return inf
        highest = sqrt(begin**2 + 2.0 * self.acceleration * length)
        if self.rise_s == 0.0:
            return highest
        return _halve(begin, highest, lambda speed: self.length(begin, speed) <= length)

    def peak(self, begin: float, end: float, length: float, top: float) -> float:
        """Greatest speed between two others on a way, at most ``top``; their ramps fit the way."""
        if self.length(begin, top) + self.length(top, end) <= length:
            return top
        if self.rise_s == 0.0:
            return min(top, sqrt(0.5 * (begin**2 + end**2) + self.acceleration * length))
        return _halve(max(begin, end), top, lambda v: self.length(begin, v) + self.length(v, end) <= length)


def _halve(low: float, high: float, fits: Callable[[float], bool]) -> float:
    """Give the greatest number between two that fits, where all smaller ones do."""
    if fits(high):
        return high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low
