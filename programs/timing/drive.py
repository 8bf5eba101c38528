"""Drives the lines of a program one after the other, as a controller with limits and a look-ahead does."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
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


_LENGTH = 1e-9


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
        ramp, length = self.lane.ramp, self.lane.length
        up_s, down_s = ramp.duration(self.peak - self.begin), ramp.duration(self.end - self.peak)
        up, down = ramp.length(self.begin, self.peak), ramp.length(self.peak, self.end)
        even_s = max(length - up - down, 0.0) / self.peak if self.peak > 0.0 else 0.0
        return (
            (0.0, 0.0, self.begin),
            (up_s, min(up, length), self.peak),
            (up_s + even_s, max(length - down, min(up, length)), self.peak),
            (up_s + even_s + down_s, length, self.end),
        )


def drive(lanes: Sequence[Lane], look_ahead: int) -> list[Drive]:
    """Drive lines one after the other, from rest to rest.

    Args:
        lanes: In order.
        look_ahead: Lines after the one that runs within which it must be able to stop.
    """
    speeds = _limit_nodes(lanes, look_ahead)
    for at in range(len(lanes) - 1, -1, -1):
        speeds[at] = min(speeds[at], lanes[at].ramp.reach(speeds[at + 1], lanes[at].length))
    for at, lane in enumerate(lanes):
        speeds[at + 1] = min(speeds[at + 1], lane.ramp.reach(speeds[at], lane.length))
    return [
        Drive(lane, speeds[at], lane.ramp.peak(speeds[at], speeds[at + 1], lane.length, lane.top), speeds[at + 1])
        for at, lane in enumerate(lanes)
    ]


def _limit_nodes(lanes: Sequence[Lane], look_ahead: int) -> list[float]:
    """Greatest speeds at the ends of lines: corners, plateaus, and what can be stopped within the look-ahead."""
    way = [0.0, *accumulate(lane.length for lane in lanes)]
    speeds = [0.0] * (len(lanes) + 1)
    for at in range(1, len(lanes)):
        before, after = lanes[at - 1], lanes[at]
        if before.turns != after.turns or before.rest_s > 0.0:
            continue
        seen = way[min(at + look_ahead, len(lanes))] - way[at]
        speeds[at] = min(before.leave, before.top, after.top, after.ramp.reach(0.0, seen))
    return speeds


def _time_in_phase(way: float, begin: float, end: float, lasts_s: float) -> float:
    """Time at a way into a phase of even acceleration."""
    if way <= _LENGTH or begin + end <= 0.0:
        return 0.0
    whole = 0.5 * (begin + end) * lasts_s
    share = min(way / whole, 1.0) if whole > 0.0 else 1.0
    speed = sqrt(max(begin**2 + (end**2 - begin**2) * share, 0.0))
    return min(2.0 * way / (begin + speed), lasts_s) if begin + speed > 0.0 else lasts_s
