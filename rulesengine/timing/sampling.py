"""Sampling: the profile on the 0.1 ms grid of the program file.

The file rounds times to a tick and positions to a micrometre. Each run is therefore stretched to whole ticks, and
the exact profile is evaluated at whole ticks: a reader who takes differences sees the planned speeds and accelerations
and only the rounding of positions on top.
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Points, Quaternions, Scalars
from programs.program import MOST_MOVES
from recipes.errors import RecipeError
from rulesengine.timing.corner_blending import Chain, Path
from rulesengine.timing.limit_intervals import Profile

TICK_S = 1e-4
"""Times in the program file are multiples of this."""
_SPACING_TICKS = 80
"""Samples closer than this would only show the rounding of positions: 1 um in 8 ms, twice, is 31 mm/s2."""
_SHORTEST_RUN_TICKS = 80
_SPEED_SHARE = 0.02
"""How far the speed between two samples may be from their mean, as a share of the programmed speed."""
_DEVIATION_MM = 0.03
"""How far the orifice may be from the straight line between two samples at the same time."""
_DEVIATION_RAD = np.radians(0.05)
_UNEVENTFUL = 0.02
"""Stretches with fewer samples a second than this need only their end points."""
_ROUNDING_MM = 1.8e-3
"""What rounding the two ends of a segment to a micrometre can add to its length: sqrt(3) of them."""
_SPEED_MARGIN = 5e-4
"""Share of the programmed speed by which a segment of the file may seem faster for it."""
_SLACK = 0.01
"""Ticks more than needed between samples: each moves by a part of a tick to the nearest whole one."""
_TIE = 1e-5
"""Ticks by which a tie is rounded up, so that the last bits do not decide."""


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Poses at ticks: the first vertex, every stop, every change of the plan's item, and what lies between."""

    tick: Indices
    """Strictly increasing from 0; time in motion only, dwells left out."""
    item: Indices
    """Item of the plan that brought the nozzle here; the first sample has the first item that moves."""
    position: Points
    """Rounded to a micrometre."""
    quaternion: Quaternions
    """Rounded to 7 decimals."""
    at: Scalars
    """Path parameter: mm, radians on turns on the spot."""

    def cut(self, begin: int, end: int) -> "Samples":
        """Take the samples from one on, up to another."""
        return Samples(*(getattr(self, each.name)[begin:end] for each in fields(self)))


@dataclass(frozen=True, slots=True, eq=False)
class _Clock:
    """Ticks as real numbers at the borders of stages, runs stretched to whole ticks."""

    begin: Scalars
    """(m,) of each stage; exact integers where a run begins."""
    end: Scalars
    stretch: Scalars
    """(m,) seconds of the file for a second of the profile, >= 1."""


def sample(path: Path, profile: Profile) -> Samples:
    """Sample a motion densely enough for straight lines and slerps between the samples."""
    clock = _wind(profile)
    item = path.chain.item[profile.stages.segment]
    changes = np.flatnonzero(np.diff(item))
    item_ends = np.append(_round(clock.end[changes]), int(clock.end[-1]))
    forced = _forced(path, profile, clock)
    keep = np.unique(np.concatenate(([0], _round(clock.end[_ends_of_runs(profile)]), item_ends)))
    density = _density(path, profile)
    ticks = _fill(_thin(forced, keep), density, clock)
    owner = item[np.append(changes, len(item) - 1)][np.searchsorted(item_ends, ticks, side="left")]
    needed = _needed(path, _places(profile, clock, ticks.astype(np.float64)))
    whole, times = _slow(ticks, needed, keep)
    at = _places(profile, clock, times)
    # A sample moved to a whole tick may still be too fast beside a change of speed, and gets one more.
    needed = np.ceil(_needed(path, at) - _TIE).astype(np.int64)
    retimed = np.concatenate((whole[:1], whole[0] + np.cumsum(np.maximum(np.diff(whole), needed))))
    positions, quaternions = path.positions(at), path.orientations(at)
    return Samples(
        tick=retimed,
        item=owner,
        position=np.round(positions, 3) + 0.0,
        quaternion=np.round(quaternions, 7) + 0.0,
        at=at,
    )


def _places(profile: Profile, clock: _Clock, times: Scalars) -> Scalars:
    """Path parameters at times in ticks (m,)."""
    stages = profile.stages
    stage = np.clip(np.searchsorted(clock.begin, times, side="right") - 1, 0, len(clock.begin) - 1)
    seconds = np.maximum(times - clock.begin[stage], 0.0) * TICK_S / clock.stretch[stage]
    along = np.sqrt(profile.begin[stage]) * seconds + 0.5 * profile.accelerations()[stage] * seconds**2
    return stages.start[stage] + np.clip(along, 0.0, stages.length[stage])


def _needed(path: Path, at: Scalars) -> Scalars:
    """(m - 1,) ticks between samples at path parameters (m,), so that none seems faster than the programmed speeds.

    For the worst rounding of the ends, not the actual one, so that it does not depend on where the board lies.
    """
    seconds = np.where(path.spin, 0.0, np.diff(path.knots) / path.chain.speed)
    programmed = np.diff(np.interp(at, path.knots, np.concatenate(([0.0], np.cumsum(seconds)))))
    lengths = np.linalg.norm(np.diff(path.positions(at), axis=0), axis=1)
    longest = np.where(lengths > 1e-6, lengths + _ROUNDING_MM, 0.0)
    return longest * programmed / np.maximum(np.diff(at), 1e-12) / ((1.0 + _SPEED_MARGIN) * TICK_S)


def _slow(ticks: Indices, needed: Scalars, keep: Indices) -> tuple[Indices, Scalars]:
    """Slow the motion between samples by the parts of a tick that it needs more; samples go to whole ticks again.

    A whole tick more between samples 80 ticks apart would slow the motion by 1 %, in one place and not in the next.

    Args:
        ticks: (m,) of samples.
        needed: (m - 1,) ticks between them.
        keep: Ticks of samples that stay at their places: between two of them whole ticks are added.

    Returns:
        (m,) ticks of the slowed motion, and the times (m,) of the motion as it was, in ticks, at which to sample.
    """
    gaps = np.maximum(np.diff(ticks), needed + _SLACK)
    stay = np.searchsorted(ticks, keep)
    totals = np.add.reduceat(gaps, stay[:-1])
    gaps[stay[1:] - 1] += np.ceil(totals - _TIE) - totals
    slowed = ticks[0] + np.concatenate((np.zeros(1), np.cumsum(gaps)))
    whole = _round(slowed)
    times = np.interp(whole, slowed, ticks)
    times[stay] = keep
    return whole, times


def hold(chain: Chain) -> Samples:
    """The one pose of a plan that does not move; none if it has none."""
    count = len(chain.tcp)
    return Samples(
        tick=np.zeros(count, dtype=np.int64),
        item=np.zeros(count, dtype=np.int64),
        position=np.round(chain.tcp, 3) + 0.0,
        quaternion=np.round(chain.quaternion, 7) + 0.0,
        at=np.zeros(count),
    )


def _wind(profile: Profile) -> _Clock:
    """Lay the stages of all runs on one time line."""
    run = profile.stages.run
    seconds = profile.durations()
    total = np.bincount(run, seconds)
    whole = np.maximum(np.ceil(total / TICK_S - _TIE).astype(np.int64), _SHORTEST_RUN_TICKS)
    run_begin = np.cumsum(whole) - whole
    stretch = (whole * TICK_S / total)[run]
    first = np.searchsorted(run, np.arange(len(total)))
    elapsed = np.cumsum(seconds)
    within = elapsed - (elapsed - seconds)[first][run]
    end = run_begin[run] + within * stretch / TICK_S
    last = _ends_of_runs(profile)
    end[last] = np.cumsum(whole)
    return _Clock(begin=np.concatenate(([0.0], end[:-1])), end=end, stretch=stretch)


def _ends_of_runs(profile: Profile) -> Indices:
    """Last stage of each run."""
    run = profile.stages.run
    return np.flatnonzero(np.append(np.diff(run) > 0, True))


def _density(path: Path, profile: Profile) -> Scalars:
    """Samples a second (m,) that each stage needs.

    A straight line in time misses a motion with acceleration a by a t^2 / 8 and its speed by a t / 2.
    """
    stages = profile.stages
    push, squared = np.abs(profile.accelerations()), np.maximum(profile.begin, profile.end)
    spin = np.isinf(stages.grip)
    programmed = path.chain.speed[stages.segment]
    speed = push / (2.0 * _SPEED_SHARE * programmed)
    place = np.sqrt(np.hypot(push, stages.curvature * squared) / (8.0 * _DEVIATION_MM))
    turn = np.sqrt((push * stages.turn + squared * stages.turn_change) / (8.0 * _DEVIATION_RAD))
    density = np.maximum(np.where(spin, 0.0, np.maximum(speed, place)), turn)
    return np.where(density < _UNEVENTFUL, 0.0, np.minimum(density, 1.0 / (_SPACING_TICKS * TICK_S)))


def _forced(path: Path, profile: Profile, clock: _Clock) -> Indices:
    """Ticks where something begins or ends: a ramp, a curve, a segment that goes another way than the last."""
    stages = profile.stages
    quiet = _density(path, profile) == 0.0
    vertex = stages.segment[1:]
    onward = np.concatenate(([True], np.linalg.norm(np.diff(path.rate, axis=0), axis=1) < 1e-9))
    straight = np.concatenate(([True], np.linalg.norm(np.diff(path.tangent[0::2], axis=0), axis=1) < 1e-6))
    plain = (stages.segment[1:] == stages.segment[:-1]) | (onward & straight)[vertex]
    passing = (quiet[1:] & quiet[:-1] & plain) | (~quiet[1:] & ~quiet[:-1])
    return np.unique(_round(clock.end[:-1][~passing]))


def _thin(forced: Indices, keep: Indices) -> Indices:
    """Leave out ticks that come too soon before or after another; those to keep all stay."""
    after = np.searchsorted(keep, forced)
    before = keep[np.maximum(after - 1, 0)]
    following = keep[np.minimum(after, len(keep) - 1)]
    room = (forced - before >= _SPACING_TICKS) & (following - forced >= _SPACING_TICKS)
    chosen: list[int] = []
    last = -_SPACING_TICKS
    for tick in forced[room].tolist():
        if tick - last >= _SPACING_TICKS:
            chosen.append(tick)
            last = tick
    return np.union1d(keep, np.array(chosen, dtype=np.int64))


def _fill(ticks: Indices, density: Scalars, clock: _Clock) -> Indices:
    """Put samples between given ticks, close together where the density is high.

    Raises:
        RecipeError: there would be more than a program may have.
    """
    # The little that is added keeps the count rising where nothing happens, so that it can be turned around.
    count = np.concatenate(([0.0], np.cumsum((density + 1e-6) * (clock.end - clock.begin) * TICK_S)))
    time = np.append(clock.begin, clock.end[-1])
    level = np.interp(ticks, time, count)
    gaps = np.diff(ticks)
    parts = np.clip(np.ceil(np.diff(level) - 1e-3), 1, np.maximum(gaps // _SPACING_TICKS, 1)).astype(np.int64)
    if parts.sum() > MOST_MOVES:
        message = (
            f"the motion needs {parts.sum():,} moves; a program has at most {MOST_MOVES:,}. Plan fewer steps and "
            "repeats, or raise the accelerations under limits"
        )
        raise RecipeError(message, path="sequence")
    gap = np.repeat(np.arange(len(gaps)), parts)
    number = np.arange(len(gap)) - (np.cumsum(parts) - parts)[gap]
    share = number / parts[gap]
    level_at = level[gap] + share * np.diff(level)[gap]
    inner = _round(np.interp(level_at, count, time))
    inner = np.clip(inner, ticks[gap], ticks[gap + 1])
    return np.union1d(ticks, inner[number > 0])


def _round(ticks: Scalars) -> NDArray[np.int64]:
    """Round to whole ticks."""
    return np.floor(ticks + 0.5 + _TIE).astype(np.int64)
