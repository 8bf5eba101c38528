"""The pace of a robot along a path: how fast its joints carry the nozzle where they are slower than the program."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from programs.program import MoveTo
from rulesengine.timing.corner_blending import Path
from rulesengine.timing.limit_intervals import Pace
from rulesengine.timing.time_plan import TimedPath

if TYPE_CHECKING:
    from robotcell.track import CellReport

_SLOW = 0.998
"""Below this share of the program's speed the robot is slower than the program."""
_SAME = 1e-6
"""Places of the path nearer than this (mm, radians), and moments nearer than this (s), are one."""


@dataclass(frozen=True, slots=True)
class RobotTiming:
    """A plan at the pace of a cell's robot, and what that costs. Seconds."""

    cell: str
    robot: str
    free_s: float
    """Within the recipe's limits alone."""
    planned_s: float
    robot_s: float
    """That the robot takes for the planned program, without its motions from home, back, and to other tools:"""
    added_s: float
    """these."""
    price_s: tuple[tuple[str, float], ...]
    """More than within the recipe's limits, by kind of motion."""
    obstacle: str = ""
    """What forbids the robot's motion all the same, such as a collision; empty where nothing does."""


@dataclass(frozen=True, slots=True, eq=False)
class RobotTimes:
    """Stretches (k,) of a path in order, and the seconds that program and robot take for each."""

    begin: Scalars
    """Path parameter."""
    end: Scalars
    program_s: Scalars
    robot_s: Scalars
    joined: NDArray[np.bool_]
    """(k,) whether the motion goes on from the stretch before without a rest."""


def robot_times(timed: TimedPath, path: Path, report: "CellReport") -> RobotTimes:
    """Compare the times of a program with those of a robot that carries it out, from move to move of the robot's."""
    program = np.array([item.time_s for item in timed.program.instructions if isinstance(item, MoveTo)])
    robot = np.array([item.time_s for item in report.program.instructions if isinstance(item, MoveTo)])
    own = np.isfinite(report.clock)
    clock, done = report.clock[own], robot[own]
    place = np.interp(clock, program, timed.at)
    moved = (np.diff(place) > _SAME) & (np.diff(clock) > _SAME)
    begin, end = place[:-1][moved], place[1:][moved]
    stops = path.knots[path.rest]
    nearest = stops[np.clip(np.searchsorted(stops, begin + _SAME, side="right") - 1, 0, len(stops) - 1)]
    joined = np.concatenate(([False], moved[:-1]))[moved] & (begin - nearest > 2.0 * _SAME)
    return RobotTimes(begin, end, np.diff(clock)[moved], np.diff(done)[moved], joined)


def seconds_by_kind(timed: TimedPath) -> dict[str, float]:
    """Give the seconds that a timed plan moves, by kind of motion."""
    path = timed.path
    kinds = ("turning on the spot", "on sprayed lines", "on transfers")
    if path is None:
        return dict.fromkeys(kinds, 0.0)
    times = np.array([item.time_s for item in timed.program.instructions if isinstance(item, MoveTo)])
    lasting = np.where(np.diff(timed.at) > _SAME, np.diff(times), 0.0)
    middle = 0.5 * (timed.at[:-1] + timed.at[1:])
    segment = np.clip(np.searchsorted(path.knots, middle, side="right") - 1, 0, len(path.knots) - 2)
    sprays = path.chain.spraying[segment]
    number = np.where(sprays, np.where(path.spin[segment], 0, 1), 2)
    return dict(zip(kinds, np.bincount(number, lasting, minlength=3).tolist(), strict=True))


def robot_pace(times: RobotTimes) -> Pace:
    """Give the pace of a robot on the stretches on which it is slower than the program.

    The speeds at the ends of stretches are those between which a run takes as long as the robot's.
    """
    times = _cut_long(times)
    mean = (times.end - times.begin) / times.robot_s
    first, last = _end_speeds(times, mean)
    limited = times.program_s < _SLOW * times.robot_s
    linked = times.joined[1:]
    limited[:-1] |= limited[1:] & linked
    limited[1:] |= limited[:-1] & linked
    alone = (first == 0.0) & (last == 0.0)  # from rest to rest: up to twice the mean speed, and back
    middle = np.where(alone, 0.5 * (times.begin + times.end), times.end)
    peak = np.where(alone, 2.0 * mean, last)
    begin, end = np.concatenate((times.begin, middle[alone])), np.concatenate((middle, times.end[alone]))
    squared = np.concatenate((first, peak[alone])) ** 2, np.concatenate((peak, last[alone])) ** 2
    chosen = np.flatnonzero(np.concatenate((limited, limited[alone])))
    chosen = chosen[np.argsort(begin[chosen], kind="stable")]
    return Pace(begin[chosen], end[chosen], squared[0][chosen], squared[1][chosen])


def _cut_long(times: RobotTimes) -> RobotTimes:
    """Cut parts as long as their neighbours off the ends of longer stretches, at the same speed.

    Else a short ramp would seem to end far within the stretch that follows.
    """
    lasting = times.robot_s
    before = np.where(times.joined, np.concatenate(([np.inf], lasting[:-1])), np.inf)
    after = np.append(np.where(times.joined[1:], lasting[1:], np.inf), np.inf)
    shares = np.stack([np.where(each < 0.25 * lasting, each / lasting, 0.0) for each in (before, after)])
    parts = np.stack((shares[0], 1.0 - shares.sum(axis=0), shares[1]), axis=1)
    row, part = np.nonzero(parts > 0.0)
    share = parts[row, part]
    through = (np.cumsum(parts, axis=1) - parts)[row, part]
    way = (times.end - times.begin)[row]
    begin = times.begin[row] + through * way
    first = np.concatenate(([True], np.diff(row) > 0))
    return RobotTimes(
        begin,
        np.where(np.append(first[1:], True), times.end[row], begin + share * way),
        share * times.program_s[row],
        share * lasting[row],
        np.where(first, times.joined[row], True),
    )


def _end_speeds(times: RobotTimes, mean: Scalars) -> tuple[Scalars, Scalars]:
    """Give speeds at the begin and at the end of each stretch: 0 at a rest, as between the mean speeds elsewhere."""
    lasting, linked = times.robot_s, times.joined[1:]
    between = (mean[:-1] * lasting[1:] + mean[1:] * lasting[:-1]) / (lasting[:-1] + lasting[1:])
    between = np.where(linked, between, 0.0)
    first, last = np.concatenate(([0.0], between)), np.concatenate((between, [0.0]))
    run = np.cumsum(~times.joined)
    sums = first + last
    takes = np.where(sums > 0.0, 2.0 * (times.end - times.begin) / np.where(sums > 0.0, sums, 1.0), lasting)
    factor = (np.bincount(run, takes) / np.maximum(np.bincount(run, lasting), _SAME))[run]
    return factor * first, factor * last
