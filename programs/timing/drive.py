"""Drives the lines of a program one after the other, as a controller with limits and a look-ahead does."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from geometry.compiled import compiled

_HALVINGS = 40


@compiled
def _duration(change: float, acceleration: float, rise_s: float) -> float:
    size = abs(change)
    if size == 0.0:
        return 0.0
    if size >= acceleration * rise_s:
        return size / acceleration + rise_s
    return 2.0 * sqrt(size * rise_s / acceleration)


@compiled
def _length(begin: float, end: float, acceleration: float, rise_s: float) -> float:
    return 0.5 * (begin + end) * _duration(end - begin, acceleration, rise_s)


@compiled
def _reach(begin: float, length: float, acceleration: float, rise_s: float) -> float:
    if acceleration == inf:
        return inf
    low, high = begin, sqrt(begin * begin + 2.0 * acceleration * length)
    if rise_s == 0.0 or _length(begin, high, acceleration, rise_s) <= length:
        return high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if _length(begin, middle, acceleration, rise_s) <= length:
            low = middle
        else:
            high = middle
    return low


@compiled
def _peak(begin: float, end: float, length: float, top: float, ramp: tuple[float, float]) -> float:
    acceleration, rise_s = ramp
    if _length(begin, top, acceleration, rise_s) + _length(top, end, acceleration, rise_s) <= length:
        return top
    if rise_s == 0.0:
        return min(top, sqrt(0.5 * (begin * begin + end * end) + acceleration * length))
    low, high = max(begin, end), top
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if _length(begin, middle, acceleration, rise_s) + _length(middle, end, acceleration, rise_s) <= length:
            low = middle
        else:
            high = middle
    return low


@dataclass(frozen=True, slots=True)
class Ramp:
    """How a speed may change."""

    acceleration: float
    rise_s: float = 0.0
    """In which the acceleration builds up; 0 where the jerk has no limit."""

    def duration(self, change: float) -> float:
        """Seconds that a change of speed takes."""
        return _duration(change, self.acceleration, self.rise_s)

    def length(self, begin: float, end: float) -> float:
        """Way that a change of speed takes."""
        return _length(begin, end, self.acceleration, self.rise_s)

    def reach(self, begin: float, length: float) -> float:
        """Greatest speed that is reached from another one within a way; the same downwards, seen from the end."""
        return _reach(begin, length, self.acceleration, self.rise_s)

    def peak(self, begin: float, end: float, length: float, top: float) -> float:
        """Greatest speed between two others on a way, at most ``top``; their ramps fit the way."""
        return _peak(begin, end, length, top, (self.acceleration, self.rise_s))


_NEAR = 1e-9


@dataclass(frozen=True, slots=True)
class Lane:
    """One line as it may be driven. mm, or degrees where the tool turns on the spot."""

    length: float
    turns: bool
    """Whether the tool turns on the spot: no speed is carried over to a line that goes somewhere."""
    top: float
    """Greatest speed."""
    ramp: Ramp
    leave: float
    """Greatest speed at its end; 0 if it stops there."""
    rest_s: float = 0.0
    """Pause at its end."""


@dataclass(frozen=True)
class Drive:
    """One line as it is driven: speeds at its begin, on its plateau and at its end."""

    lane: Lane
    begin: float
    peak: float
    end: float

    @property
    def moving_s(self) -> float:
        """Seconds of motion."""
        return self._phases[-1][0]

    @property
    def duration_s(self) -> float:
        """Seconds that it takes, the pause at its end too."""
        return self.moving_s + self.lane.rest_s

    @property
    def borders(self) -> tuple[float, ...]:
        """Shares of its length at its ends and in its ramps, between which its speed hardly changes."""
        (_, _, _), (_, up, _), (_, down, _), (_, length, _) = self._phases
        ways = (0.0, 0.1 * up, 0.4 * up, up, down, down + 0.6 * (length - down), down + 0.9 * (length - down), length)
        return tuple(way / length for way in ways)

    def second_at(self, share: float) -> float:
        """Time at which this share of its length is done."""
        way = min(max(share, 0.0), 1.0) * self.lane.length
        for (t0, s0, v0), (t1, s1, v1) in pairwise(self._phases):
            if way <= s1 or s1 >= self.lane.length:
                return t0 + _time_in_phase(way - s0, v0, v1, t1 - t0)
        return self.moving_s

    def way_at(self, seconds: float) -> float:
        """Way that is done by then."""
        for (t0, s0, v0), (t1, s1, v1) in pairwise(self._phases):
            if seconds <= t1 and t1 > t0:
                done = min(max(seconds - t0, 0.0), t1 - t0)
                way = s0 + v0 * done + 0.5 * (v1 - v0) * done**2 / (t1 - t0)
                return min(way, s1)
        return self.lane.length

    @cached_property
    def _phases(self) -> tuple[tuple[float, float, float], ...]:
        """Time, way and speed at the ends of the three phases."""
        ramp = self.lane.ramp.acceleration, self.lane.ramp.rise_s
        return _phases(self.lane.length, self.begin, self.peak, self.end, ramp)


@compiled
def _phases(
    length: float, begin: float, peak: float, end: float, ramp: tuple[float, float]
) -> tuple[tuple[float, float, float], ...]:
    up_s, down_s = _duration(peak - begin, *ramp), _duration(end - peak, *ramp)
    up, down = _length(begin, peak, *ramp), _length(peak, end, *ramp)
    even_s = max(length - up - down, 0.0) / peak if peak > 0.0 else 0.0
    return (
        (0.0, 0.0, begin),
        (up_s, min(up, length), peak),
        (up_s + even_s, max(length - down, min(up, length)), peak),
        (up_s + even_s + down_s, length, end),
    )


def drive(lanes: Sequence[Lane], look_ahead: int) -> list[Drive]:
    """Drive lines one after the other, from rest to rest.

    Args:
        lanes: In order.
        look_ahead: Lines after the one that runs within which it must be able to stop.
    """
    rows = [
        (each.length, each.turns, each.top, each.ramp.acceleration, each.ramp.rise_s, each.leave, each.rest_s)
        for each in lanes
    ]
    driven = _speeds(np.array(rows, dtype=np.float64).reshape(-1, 7), look_ahead).tolist()
    return [Drive(lane, begin, peak, end) for lane, (begin, peak, end) in zip(lanes, driven, strict=True)]


@compiled
def _speeds(lanes: NDArray[np.float64], look_ahead: int) -> NDArray[np.float64]:
    """Speeds (n, 3) at the begin, on the plateau and at the end of lanes (n, 7), the attributes in their order."""
    count = len(lanes)
    way, speeds, driven = np.zeros(count + 1), np.zeros(count + 1), np.empty((count, 3))
    for at in range(count):
        way[at + 1] = way[at] + lanes[at, 0]
    for at in range(1, count):  # corners, plateaus, and what can be stopped within the look-ahead
        before, after = lanes[at - 1], lanes[at]
        if before[1] == after[1] and before[6] <= 0.0:
            seen = way[min(at + look_ahead, count)] - way[at]
            speeds[at] = min(before[5], before[2], after[2], _reach(0.0, seen, after[3], after[4]))
    for at in range(count - 1, -1, -1):
        speeds[at] = min(speeds[at], _reach(speeds[at + 1], lanes[at, 0], lanes[at, 3], lanes[at, 4]))
    for at in range(count):
        speeds[at + 1] = min(speeds[at + 1], _reach(speeds[at], lanes[at, 0], lanes[at, 3], lanes[at, 4]))
    for at in range(count):
        ramp = (lanes[at, 3], lanes[at, 4])
        driven[at] = (speeds[at], _peak(speeds[at], speeds[at + 1], lanes[at, 0], lanes[at, 2], ramp), speeds[at + 1])
    return driven


def _time_in_phase(way: float, begin: float, end: float, lasts_s: float) -> float:
    """Time at a way into a phase of even acceleration."""
    if way <= _NEAR or begin + end <= 0.0:
        return 0.0
    whole = 0.5 * (begin + end) * lasts_s
    share = min(way / whole, 1.0) if whole > 0.0 else 1.0
    speed = sqrt(max(begin**2 + (end**2 - begin**2) * share, 0.0))
    return min(2.0 * way / (begin + speed), lasts_s) if begin + speed > 0.0 else lasts_s
