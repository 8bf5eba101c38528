"""Stretches of a path with constant limits, the speeds along them, and the pace that a robot allows."""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars

_SAME = 1e-8
"""A stage shorter than this (mm, radians) is none."""
_ONE_PLACE = 1e-7
_NONE = np.zeros(0)


@dataclass(frozen=True, slots=True, eq=False)
class Stages:
    """Short stretches of the path with constant limits, in order; every array is (m,)."""

    start: Scalars
    """Path parameter, mm (radians on turns on the spot)."""
    length: Scalars
    run: Indices
    segment: Indices
    """Segment of the chain."""
    curvature: Scalars
    turn: Scalars
    """Highest rate of rotation, radians per path parameter."""
    turn_change: Scalars
    """Highest change of the vector of that rate per path parameter."""
    cap: Scalars
    """Highest squared speed on its own account,"""
    first: Scalars
    """where it begins,"""
    last: Scalars
    """and where it ends. It changes evenly between them, where a pace limits it; else both are the cap."""
    bounded: NDArray[np.bool_]
    """Whether a pace limits it."""
    push: Scalars
    """Highest tangential acceleration where nothing couples."""
    grip: Scalars
    """Highest acceleration of the orifice; infinite on turns on the spot, where it stays."""

    def pick(self, index: Indices) -> "Stages":
        """Take stages by index, also repeatedly."""
        return Stages(*(getattr(self, field.name)[index] for field in fields(self)))

    def cut(self, parent: Indices, start: Scalars, length: Scalars) -> "Stages":
        """Take parts of stages, each of one parent, from a path parameter on."""
        whole = self.pick(parent)
        slope = (whole.last - whole.first) / whole.length
        ends = [
            np.where(slope == 0.0, whole.first, whole.first + slope * (place - whole.start))
            for place in (start, start + length)
        ]
        return replace(whole, start=start, length=length, first=ends[0], last=ends[1])


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """Stages and the squared speeds (m,) at which each begins and ends."""

    stages: Stages
    begin: Scalars
    end: Scalars

    def pick(self, index: Indices) -> "Profile":
        """Take stages by index."""
        return Profile(self.stages.pick(index), self.begin[index], self.end[index])

    def accelerations(self) -> Scalars:
        """(m,) Tangential acceleration of each stage."""
        return 0.5 * (self.end - self.begin) / self.stages.length

    def durations(self) -> Scalars:
        """(m,) Seconds of each stage."""
        return 2.0 * self.stages.length / (np.sqrt(self.begin) + np.sqrt(self.end))


def envelope(stages: Stages) -> Profile:
    """Widest squared speed within caps and pushes: trapezoids and triangles, cut at their kinks.

    With e the energy the pushes could have given since the beginning, no x can be above another x plus the
    difference of their e; a running minimum of x - e finds that, and once more from the other end.
    """
    gain = 2.0 * stages.push * stages.length
    energy = np.concatenate(([0.0], np.cumsum(gain)))
    at = np.zeros(len(gain) + 1)
    at[1:-1] = np.where(stages.run[:-1] == stages.run[1:], highest_between(stages), 0.0)
    at = energy + np.minimum.accumulate(at - energy)
    at = np.minimum.accumulate((at + energy)[::-1])[::-1] - energy
    first, last = np.maximum(at[:-1], 0.0), np.maximum(at[1:], 0.0)
    # Under a pace that changes: no higher than its lower end, or straight from end to end.
    lower = np.minimum(np.minimum(stages.first, stages.last), stages.cap)
    ends = np.maximum(first, last)
    straight = (stages.first != stages.last) & (ends > lower)
    cap = np.where(straight, ends, np.where((ends <= lower) & (lower > 0.0), lower, stages.cap))
    peak = np.minimum(cap, 0.5 * (first + last + gain))
    peak = np.maximum(peak, ends)
    rise, fall = 0.5 * (peak - first) / stages.push, 0.5 * (peak - last) / stages.push
    rise = np.where(straight & (last > first), stages.length, rise)
    fall = np.where(straight & (first > last), stages.length, fall)
    lengths = np.stack((rise, np.maximum(stages.length - rise - fall, 0.0), fall), axis=1)
    lengths *= (stages.length / lengths.sum(axis=1))[:, None]
    begins = stages.start[:, None] + np.cumsum(lengths, axis=1) - lengths
    speeds = np.stack((first, peak, peak, last), axis=1)
    kept = lengths > np.minimum(_SAME, 1e-3 * stages.length)[:, None]
    parent = np.nonzero(kept)[0]
    parts = stages.cut(parent, begins[kept], lengths[kept])
    return Profile(parts, speeds[:, :3][kept], speeds[:, 1:][kept])


def highest_between(stages: Stages) -> Scalars:
    """Give the highest squared speed (m - 1,) from each stage to the next."""
    return np.minimum(np.minimum(stages.cap[:-1], stages.cap[1:]), np.minimum(stages.last[:-1], stages.first[1:]))


def cautious(stages: Stages, turn_acceleration: float) -> Profile:
    """Find a motion that keeps to the coupled limits whatever happens, by halving what the couples share."""
    with np.errstate(divide="ignore"):
        share = np.minimum(stages.grip * np.sqrt(0.5) / stages.curvature, 0.5 * turn_acceleration / stages.turn_change)
        push = np.where(stages.curvature > 0.0, stages.grip * np.sqrt(0.5), stages.push)
        push = np.where(stages.turn_change > 0.0, np.minimum(push, 0.5 * turn_acceleration / stages.turn), push)
    first, last = np.minimum(stages.first, share), np.minimum(stages.last, share)
    cap, push = np.minimum(stages.cap, share), np.minimum(stages.push, push)
    return envelope(replace(stages, cap=cap, first=first, last=last, push=push))


def join(one: Profile, other: Profile) -> Profile:
    """Put two profiles of different runs together, in the order of the path."""
    names = [field.name for field in fields(Stages)]
    both = Stages(*(np.concatenate((getattr(one.stages, name), getattr(other.stages, name))) for name in names))
    profile = Profile(both, np.concatenate((one.begin, other.begin)), np.concatenate((one.end, other.end)))
    return profile.pick(np.argsort(both.start, kind="stable"))


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
        share = np.clip((places - self.begin[which]) / (self.end - self.begin)[which], 0.0, 1.0)
        highest = self.first[which] + share * (self.last[which] - self.first[which])
        return limited, np.where(limited, highest, np.inf)

    def within(self, other: "Pace") -> "Pace":
        """Give the pace that is nowhere above the one or the other."""
        borders = np.unique(np.concatenate((self.begin, self.end, other.begin, other.end)))
        if len(borders) < 2:
            return FREE
        borders = borders[np.concatenate(([True], np.diff(borders) > _ONE_PLACE))]
        # Where one of two paces that limit the same stretch goes under the other.
        ones, others = self.between(borders), other.between(borders)
        both = np.flatnonzero(ones[0] & others[0])
        begin, end = ones[1][:, both] - others[1][:, both]
        crossed = begin * end < 0.0
        share = begin[crossed] / (begin - end)[crossed]
        at = borders[both[crossed]]
        borders = np.union1d(borders, at + share * (borders[both[crossed] + 1] - at))
        ones, others = self.between(borders), other.between(borders)
        limited = ones[0] | others[0]
        highest = np.minimum(ones[1], others[1])[:, limited]
        return Pace(borders[:-1][limited], borders[1:][limited], highest[0], highest[1])


FREE = Pace(_NONE, _NONE, _NONE, _NONE)
"""Only the recipe's limits hold."""
