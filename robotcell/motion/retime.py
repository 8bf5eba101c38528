"""Retiming: the program's own timing where the joints keep to their limits, else the fastest within these.

The path parameter is the program's own clock c, in s; the robot's clock runs no faster: x = (dc/dt)^2 <= 1. With p the
joints' change for a second of c between two samples and d the change of p at a sample,

    x p^2 <= speed^2        |p u + d x| <= acceleration,    u = d(dc/dt)/dt

where x grows by 2 u for each second of c. At a rest p is 0, so that x is free there.

Of runs whose own timing exceeds a limit the fastest clock is found stage by stage, each with rows -1 <= a u + b x <= 1.
After Pham and Pham, "A new approach to time-optimal path parameterization based on reachability
analysis" (2018): backwards the greatest x from which what follows can be kept, then forwards the greatest u. In two
unknowns neither takes a solver of linear programs: of a given x the rows bound u from below and from above, and the
two bounds meet where x is greatest. That standing still is always allowed makes 0 the least x everywhere.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from geometry.compiled import compiled, inner
from programs.program import MoveTo, TimedProgram
from robotcell.motion.sampled_path import Flags, runs_of
from robotcell.robot.robot import Joints, Robot

_LEAST_S = 1e-6
"""A motion that is programmed in less time counts as programmed in this."""
_ROUNDING = 1.02
"""By how much a program's own timing may seem to exceed a limit: its positions are rounded to a micrometre."""
_TURN_S = 0.02
"""s of the program for which a joint that turns back, or begins to move, hardly moves."""
_TIGHTENED = 12
"""How often a run is timed anew at most."""
_TOLERATED = 1.05
"""By how much a timing may exceed a limit between its stages before a run is timed anew; less is stretched."""
_STRETCHED_TO = 0.9995
"""Of a limit that a stretched run keeps to,"""
_LIMIT_USED = 0.9999
"""and that no run exceeds: times of programs are rounded to a nanosecond."""
_BY_RUN = 12
"""How often runs are stretched each by itself; after that all runs between two cuts together."""
_SPARE = 1e-8
"""What a rate is below its greatest: what rounding adds must not leave the sets that the way back found,"""
_SPARE_SHARE = 0.9999
"""but not below this share of it."""


@dataclass(frozen=True, slots=True, eq=False)
class Rates:
    """Joints, speeds and accelerations at the k moments at which a program states a pose."""

    times: Scalars
    """(k,) ascending"""
    q: Joints
    """(k, dof)"""
    speed: NDArray[np.float64]
    """(k - 1, dof) mean of each interval."""
    acceleration: NDArray[np.float64]
    """(k, dof) change of the mean speeds before and after; from rest and to rest at the ends."""


def rates_of(program: TimedProgram, joints: Joints) -> Rates:
    """Give the rates of joints (moves, dof), one row for each move of the program; at least one move."""
    times = np.array([item.time_s for item in program.instructions if isinstance(item, MoveTo)], dtype=np.float64)
    kept = np.concatenate(([True], np.diff(times) > _LEAST_S))
    times, q = times[kept], joints[kept]
    return Rates(times, q, *differences(np.diff(times), q))


def differences(lasting: Scalars, q: Joints) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Give speeds and accelerations of rows of joints (k + 1, dof) that are ``lasting`` (k,) seconds apart.

    Returns:
        (k, dof) mean speeds of the intervals, and (k + 1, dof) their changes at the rows: from rest at the first and to
        rest at the last, over half of the time to each side.
    """
    seconds = lasting[:, None]
    speed = np.diff(q, axis=0) / seconds
    still, none = np.zeros((1, q.shape[1])), np.ones((1, 1))
    before, after = np.concatenate((none, seconds)), np.concatenate((seconds, none))
    before[0], after[-1] = after[0], before[-1]
    return speed, np.diff(np.concatenate((still, speed, still)), axis=0) / (0.5 * (before + after))


@dataclass(frozen=True, slots=True, eq=False)
class Retiming:
    """The time that the robot takes from sample to sample."""

    lasting: Scalars
    """(n - 1,) s"""
    share: Scalars
    """(n - 1,) of the programmed speed that is reached, 0 to 1; 1 where nothing moves."""
    joint: Indices
    """(n - 1,) the joint that limits it, where the share is below 1."""
    by_speed: Flags
    """(n - 1,) whether it is that joint's greatest speed; else its acceleration."""


def retime(robot: Robot, times: Scalars, q: Joints, cuts: Flags) -> Retiming:
    """Find the fastest timing that keeps to the joints' limits and is nowhere faster than the program.

    Args:
        robot: Whose limits.
        times: (n,) the program's clock.
        q: (n, dof)
        cuts: (n - 1,) intervals that are not tracked: the robot stands still before and after.
    """
    moving = (np.abs(np.diff(q, axis=0)).max(axis=1) > 1e-9) & ~cuts
    lasting = np.diff(times)
    if np.any(lasting[moving] < _LEAST_S):
        lasting = np.where(moving, np.maximum(lasting, _LEAST_S), lasting)
        times = times[0] + np.concatenate(([0.0], np.cumsum(lasting)))
    changed = lasting.copy()
    # A stage takes its changes of rate as if the clock ran evenly about a sample. Where it slows down within one sample
    # the same change happens in less time: there the clock is held back until the joints' own differences are right.
    for run in runs_of(moving):
        a, b = run
        if _exceeds(times, q, cuts, run, robot):
            changed[a:b] = _retime_run(_stages(times, q, cuts, run, robot), q[a : b + 1], robot)
    changed = stretch_runs(changed, q, cuts, runs_of(moving), robot)
    share = np.where(moving, lasting / np.maximum(changed, _LEAST_S), 1.0)
    rates, changes = differences(np.maximum(changed, _LEAST_S), q)
    changes = np.abs(changes) / robot.acceleration
    hard, fast = np.maximum(changes[:-1], changes[1:]), np.abs(rates) / robot.speed
    row = np.arange(len(lasting))
    hardest, fastest = np.argmax(hard, axis=1), np.argmax(fast, axis=1)
    by_speed = fast[row, fastest] >= hard[row, hardest]
    return Retiming(changed, np.minimum(share, 1.0), np.where(by_speed, fastest, hardest), by_speed)


def _exceeds(times: Scalars, q: Joints, cuts: Flags, run: tuple[int, int], robot: Robot) -> bool:
    """Whether the program's own timing of a run exceeds a joint's limits."""
    a, b = run
    rates, changes = differences(np.diff(times[a : b + 1]), q[a : b + 1])
    fast, hard = np.abs(rates) > robot.speed * _ROUNDING, np.abs(changes) > robot.acceleration * _ROUNDING
    return bool(fast.any() or hard.any() or any(_brakes(cuts, run, rates)))


def stretch_runs(lasting: Scalars, q: Joints, cuts: Flags, runs: list[tuple[int, int]], robot: Robot) -> Scalars:
    """Slow down every run that exceeds a limit, evenly, until none does: what is left by stages and by rounding.

    Evenly because a change of rate inside the run would be an acceleration of its own. Speeds fall with the factor,
    accelerations with its square, but for those at rests, whose duration stays: at least with the factor. Two runs
    that meet may take turns in exceeding a limit; slowed down by the same factor, its square where that counts, they
    do not. So this ends.
    """
    lasting, moving = lasting.copy(), np.zeros(len(lasting), dtype=np.bool_)
    for a, b in runs:
        moving[a:b] = True
    pieces = runs_of(~cuts)
    for number in itertools.count():
        excess = _excess(lasting, q, cuts, robot)
        slower, power = _slowed(runs, excess) if number < _BY_RUN else [], 1
        if not slower:  # a motion of no duration belongs to the interval that follows, which no run need have
            slower, power = _slowed(pieces, excess), 1 if number < _BY_RUN else 2
        if not slower:
            break
        for (a, b), factor in slower:
            lasting[a:b] *= np.where(moving[a:b], (factor / _STRETCHED_TO) ** power, 1.0)
    return lasting


def _slowed(spans: list[tuple[int, int]], excess: Scalars) -> list[tuple[tuple[int, int], float]]:
    """Give the spans that exceed a limit, and the factor for each."""
    factors = [(span, float(excess[span[0] : span[1] + 1].max())) for span in spans]
    return [(span, factor) for span, factor in factors if factor > _LIMIT_USED]


def _excess(lasting: Scalars, q: Joints, cuts: Flags, robot: Robot) -> Scalars:
    """Give the factor (n,) in time by which the motion at each sample would have to be slower to keep to all limits.

    As a reader of the program finds it: rows within a microsecond are one, and nothing moves before and after a cut.
    """
    excess = np.zeros(len(q))
    for a, b in runs_of(~cuts):
        rows = a + np.concatenate(([0], 1 + np.flatnonzero(lasting[a:b] > _LEAST_S)))
        if len(rows) < 2:
            continue
        speed, change = differences(np.add.reduceat(lasting[a : rows[-1]], rows[:-1] - a), q[rows])
        change[0] *= 2.0  # another motion may end or begin there: each reaches rest within its own half
        change[-1] *= 2.0
        fast = (np.abs(speed) / robot.speed).max(axis=1)
        excess[rows] = np.sqrt((np.abs(change) / robot.acceleration).max(axis=1))
        excess[rows[:-1]] = np.maximum(excess[rows[:-1]], fast)
        excess[rows[1:]] = np.maximum(excess[rows[1:]], fast)
    return excess


def _brakes(cuts: Flags, run: tuple[int, int], rates: NDArray[np.float64]) -> tuple[bool, bool]:
    """Whether a run begins and whether it ends in motion at a cut, where the program itself may not rest."""
    (a, b), moves = run, np.abs(rates[[0, -1]]).max(axis=1) >= 1e-6
    return bool(a > 0 and cuts[a - 1] and moves[0]), bool(b < len(cuts) and cuts[b] and moves[1])


def _retime_run(stages: "_Stages", q: Joints, robot: Robot) -> Scalars:
    """Give the seconds of the stages of a run with joints (k + 1, dof)."""
    ceiling, seconds = stages.highest, stages.length
    for _ in range(_TIGHTENED):
        x = fastest_clock(stages.length, stages.of_u, stages.of_x, ceiling)
        root = np.sqrt(x)
        seconds = 2.0 * stages.length / np.maximum(root[:-1] + root[1:], 1e-9)
        _, changes = differences(seconds, q)
        changes[[0, -1]] *= 2.0
        excess = np.max(np.abs(changes) / robot.acceleration, axis=1)
        if excess.max() <= _TOLERATED:
            break
        worst = np.maximum(excess, np.maximum(np.append(excess[1:], 0.0), np.append(0.0, excess[:-1])))
        lower = x / np.maximum(worst, 1.0)
        ceiling = np.where(worst > _TOLERATED, np.minimum(ceiling, lower), ceiling)
    return seconds


@dataclass(frozen=True, slots=True, eq=False)
class _Stages:
    """Stages of a run, k of them."""

    length: Scalars
    """(k,) s of the program"""
    of_u: NDArray[np.float64]
    """(k, 2 dof) and"""
    of_x: NDArray[np.float64]
    """(k, 2 dof) of rows ``-1 <= a u + b x <= 1``, which hold at both ends of each stage."""
    highest: Scalars
    """(k + 1,) greatest x at the samples."""


def _stages(times: Scalars, q: Joints, cuts: Flags, run: tuple[int, int], robot: Robot) -> _Stages:
    """Give the stages of a run."""
    a, b = run
    lasting = np.diff(times[a : b + 1])
    rates, changes = differences(lasting, q[a : b + 1])
    pull, change = rates / robot.acceleration, changes / robot.acceleration
    begin, end = change[:-1], change[1:]
    late = pull + 2.0 * lasting[:, None] * end
    # Where a joint hardly moves, u cannot help it: d x <= acceleration. Without that such a place may be begun too fast
    # and then has to be crept through: Pham, "A general, fast, and robust implementation of the time-optimal path
    # parameterization algorithm" (2014), on zero-inertia points.
    around = np.minimum(np.abs(np.concatenate((rates[:1], rates))), np.abs(np.concatenate((rates, rates[-1:]))))
    with np.errstate(divide="ignore"):
        cap = np.minimum(1.0, ((robot.speed / np.abs(rates)) ** 2).min(axis=1))
        still = np.where(around <= _TURN_S * np.abs(changes), robot.acceleration / np.abs(changes), np.inf)
    highest = np.minimum(np.concatenate((cap[:1], cap)), np.concatenate((cap, cap[-1:])))
    highest = np.minimum(highest, still.min(axis=1))
    highest[[0, -1]] = np.where(_brakes(cuts, run, rates), 0.0, highest[[0, -1]])
    return _Stages(lasting, np.hstack((pull, late)), np.hstack((begin, end)), highest)


@compiled
def fastest_clock(length: Scalars, of_u: NDArray[np.float64], of_x: NDArray[np.float64], highest: Scalars) -> Scalars:
    """Give the squared rates (k + 1,) at the samples of a run that may begin and end at any rate.

    Args:
        length: (k,) of the stages, s of the path.
        of_u: (k, rows) a of the rows.
        of_x: (k, rows) b.
        highest: (k + 1,) greatest squared rates at the samples.
    """
    count = len(length)
    reach = np.empty(count + 1)
    reach[count] = highest[count]
    for at in range(count - 1, -1, -1):
        reach[at] = _greatest(length[at], of_u[at], of_x[at], highest[at], reach[at + 1])
    squared = np.empty(count + 1)
    squared[0] = _spared(reach[0])
    for at in range(count):
        _, _, change, _ = _bounds(length[at], of_u[at], of_x[at], squared[at], reach[at + 1])
        following = _spared(squared[at] + 2.0 * length[at] * change)
        squared[at + 1] = min(reach[at + 1], max(0.0, following))
    return squared


@inner
def _spared(squared: float) -> float:
    return max(squared - _SPARE, _SPARE_SHARE * squared)


@inner
def _greatest(length: float, of_u: Scalars, of_x: Scalars, highest: float, following: float) -> float:
    """Give the greatest x up to ``highest`` from which the next is at most ``following``.

    By how much the lower bound of u exceeds the upper one is convex in x: steps to where the rows that cross now meet
    come down to the answer, and end there.
    """
    x = highest
    for row in range(len(of_u)):
        if of_u[row] == 0.0 and abs(of_x[row]) * x > 1.0:
            x = 1.0 / abs(of_x[row])
    while x > 0.0:
        low, low_slope, high, high_slope = _bounds(length, of_u, of_x, x, following)
        if low <= high:
            break
        lower = x - (low - high) / (low_slope - high_slope)
        if not lower < x:  # rounding alone keeps the bounds apart
            break
        x = max(lower, 0.0)
    return x


@inner
def _bounds(
    length: float, of_u: Scalars, of_x: Scalars, x: float, following: float
) -> tuple[float, float, float, float]:
    """Give the bounds of u at an x, the lower with its slope over x, and the upper with its."""
    low, low_slope = -0.5 * x / length, -0.5 / length
    high, high_slope = 0.5 * (following - x) / length, -0.5 / length
    for row in range(len(of_u)):
        a, b = of_u[row], of_x[row]
        if a == 0.0:
            continue
        slope = -b / a
        size, middle = 1.0 / abs(a), slope * x
        if middle - size > low:
            low, low_slope = middle - size, slope
        if middle + size < high:
            high, high_slope = middle + size, slope
    return low, low_slope, high, high_slope
