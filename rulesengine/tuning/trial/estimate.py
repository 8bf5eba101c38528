"""Estimate of how long a tuning will still take; it is shown and decides nothing."""

import time
from collections.abc import Callable
from math import ceil, log

_TYPICAL_SHORTENING = 8
"""Analyses that shortening took on the sample boards, most of them."""
_LEAST_RATE = 0.1
"""Of the logarithm of the shortfall by an analysis."""
_BASE = 0.1
"""Shortfall of one requirement that is nearly met."""


class Estimate:
    """How many analyses are expected, and how long one takes with the plans before it."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin.

        Args:
            clock: Gives seconds.
        """
        self._clock, self._mark = clock, clock()
        self._spent, self._made = 0.0, 0
        self.expected: int | None = None
        """Analyses that are still to be made, as far as it can be known."""

    def made(self, *, restored: bool) -> None:
        """Count one analysis; one that was only read again takes no time."""
        now = self._clock()
        if not restored:
            self._spent += now - self._mark
            self._made += 1
        self._mark = now

    def improving(self, shortfalls: tuple[float, float], used: int, left: int) -> None:
        """Expect the shortfall to fall on as it did, and the recipe to be shortened then.

        Args:
            shortfalls: The first one, and that of now.
            used: Analyses so far.
            left: Analyses that the stage may still make.
        """
        first, now = shortfalls
        rate = max(log(max(first, _BASE) / max(now, _BASE)) / max(used, 1), _LEAST_RATE)
        self.expected = min(left, ceil(log(max(now, _BASE) / _BASE) / rate)) + _TYPICAL_SHORTENING

    def shortening(self, done: int) -> None:
        """Expect what is left of a shortening that has made so many analyses."""
        self.expected = max(1, _TYPICAL_SHORTENING - done)

    def describe(self, left: int) -> str:
        """Name the analyses and the time that are still expected, such as ``"about 7 more, 1:10"``; empty at first."""
        if self.expected is None or not left:
            return ""
        more = min(self.expected, left)
        if not self._made:
            return f"about {more} more"
        seconds = round(more * self._spent / self._made)
        return f"about {more} more, {seconds // 60}:{seconds % 60:02d}"

    def share(self, used: int, left: int) -> float:
        """Share of the tuning that is done, as far as it can be known."""
        more = left if self.expected is None else min(self.expected, left)
        return used / max(used + more, 1)
