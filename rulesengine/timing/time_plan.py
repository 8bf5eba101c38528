"""Plan in, timed program out."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from operator import itemgetter
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from geometry.frames import align_signs, quaternions_from_axes, rotation_angles
from programs.plan import Dwell, Plan, SprayPass, Transfer
from programs.program import TimedProgram
from recipes.recipe import Limits
from rulesengine.timing.corner_blending import Chain, Path, round_corners
from rulesengine.timing.limit_intervals import FREE, Pace, Profile, Stages, envelope, join
from rulesengine.timing.sampling import TICK_S, Samples, hold, sample
from rulesengine.timing.slow_passes import Slow, find_slow_passes, slow_items
from rulesengine.timing.write_instructions import dwell_ticks, write_instructions

_SAME = 1e-8
"""Breaks of the path closer than this (mm, radians) are one."""
ACCELERATION_SHARE = 0.94
"""Of the limit that is planned with: positions rounded to 1 um, 8 ms apart, may add 31 mm/s2, and a
reader of the file is to find the limit kept."""
_SAME_MM = 1e-4
_SAME_RAD = 1e-5
"""Neighbouring vertices nearer than this are one."""
_GAP_MM = 1e-3
_GAP_RAD = 1e-3
"""Items that do not meet within this are a mistake in the plan."""


def parametrise(path: Path, limits: Limits, pace: Pace = FREE) -> Profile:
    """Find the fastest motion along the path within the limits and no faster than a pace, at rest at every stop."""
    spin_rate = np.radians(limits.rotation_acceleration_deg_s2)
    profile = envelope(_stages(path, limits, pace))
    stages, push = profile.stages, np.abs(profile.accelerations())
    highest = np.maximum(profile.begin, profile.end)
    sideways = np.where(np.isinf(stages.grip), 0.0, np.hypot(push, stages.curvature * highest) / stages.grip)
    turning = (push * stages.turn + highest * stages.turn_change) / spin_rate
    coupled = np.unique(stages.run[np.maximum(sideways, turning) > 1.0 + 1e-6])
    if len(coupled) == 0:
        return profile
    from rulesengine.timing.coupled_limits import parametrise_coupled

    chosen = np.isin(stages.run, coupled)
    solved = parametrise_coupled(profile.pick(np.flatnonzero(chosen)), spin_rate)
    return join(profile.pick(np.flatnonzero(~chosen)), solved)


def _stages(path: Path, limits: Limits, pace: Pace) -> Stages:
    """Cut the path wherever a limit changes."""
    borders = _borders(path, pace)
    middle = 0.5 * (borders[:-1] + borders[1:])
    segment = np.clip(np.searchsorted(path.knots, middle, side="right") - 1, 0, len(path.knots) - 2)
    piece = np.searchsorted(path.start, middle, side="right") - 1
    # In a window the rate of rotation goes over linearly.
    rates = np.stack([_rates_at(path, at, segment) for at in (borders[:-1], borders[1:])])
    turn = np.max(np.linalg.norm(rates, axis=2), axis=0)
    turn_change = np.linalg.norm(rates[1] - rates[0], axis=1) / np.diff(borders)
    turn_change = np.where(turn_change > 1e-9, turn_change, 0.0)
    curvature, spin = path.curvature[piece], path.spin[segment]
    grip = np.where(spin, np.inf, limits.acceleration_mm_s2)
    speed = np.where(spin, np.inf, path.chain.speed[segment])
    omega, alpha = np.radians(limits.rotation_deg_s), np.radians(limits.rotation_acceleration_deg_s2)
    with np.errstate(divide="ignore", invalid="ignore"):
        centripetal = np.where(curvature > 0.0, grip / curvature, np.inf)
        cap = np.minimum(np.minimum(speed**2, centripetal), np.minimum((omega / turn) ** 2, alpha / turn_change))
        push = np.minimum(grip, alpha / turn)
    stops = path.knots[path.rest]
    run = np.searchsorted(stops, middle) - 1
    bounded, highest = pace.between(borders)
    first, last = np.minimum(cap, highest[0]), np.minimum(cap, highest[1])
    lengths = np.diff(borders)
    cap = np.maximum(first, last)
    return Stages(
        borders[:-1], lengths, run, segment, curvature, turn, turn_change, cap, first, last, bounded, push, grip
    )


def _borders(path: Path, pace: Pace) -> Scalars:
    """Path parameters where a limit may change, the stops exactly among them."""
    window = path.window[:, None] * np.array([-1.0, -0.5, 0.5, 1.0])
    around = (path.knots[:, None] + window)[path.window > 0.0].ravel()
    ends = np.concatenate((pace.begin, pace.end))
    inner = np.sort(np.concatenate((path.start, path.knots, around, ends[(ends > 0.0) & (ends < path.length)])))
    stops = path.knots[path.rest]
    nearest = np.minimum(np.searchsorted(stops, inner), len(stops) - 1)
    far = np.minimum(np.abs(inner - stops[nearest]), np.abs(inner - stops[np.maximum(nearest - 1, 0)])) > _SAME
    borders = np.sort(np.concatenate((stops, inner[far])))
    return borders[np.concatenate(([True], np.diff(borders) > _SAME))]


def _rates_at(path: Path, at: Scalars, segment: Indices) -> Scalars:
    """Vector of rotation per path parameter (m, 3) at each place, seen from inside its segment."""
    left, right = at - path.knots[segment], path.knots[segment + 1] - at
    vertex = np.where(left < right, segment, segment + 1)
    window = path.window[vertex]
    inside = (window > 0.0) & (np.minimum(left, right) < window)
    fraction = np.clip(0.5 + 0.5 * (at - path.knots[vertex]) / np.where(inside, window, 1.0), 0.0, 1.0)[:, None]
    last = len(path.rate) - 1
    before, after = path.rate[np.maximum(vertex - 1, 0)], path.rate[np.minimum(vertex, last)]
    return np.where(inside[:, None], (1.0 - fraction) * before + fraction * after, path.rate[segment])


@dataclass(frozen=True, slots=True, eq=False)
class TimedPath:
    """A timed program and the path that it follows, which depends on the recipe's limits and not on the pace."""

    program: TimedProgram
    path: Path | None
    """``None`` where nothing moves."""
    at: Scalars
    """(moves,) path parameter of each ``MoveTo``."""


@dataclass(frozen=True, slots=True, eq=False)
class TimedItem:
    """The motion of one item of a plan."""

    samples: Samples
    """The first is the pose in which the item begins."""
    slow: Slow | None
    """``None`` where nothing is sprayed."""


TimedItems: TypeAlias = dict[Hashable, TimedItem]
"""Items that were timed within the same limits, by all that their motion depends on."""


def time_plan(plan: Plan, limits: Limits, known: TimedItems | None = None) -> TimedProgram:
    """Time a plan: the fastest motion within the limits, at the programmed speed while spraying wherever they allow it.

    The findings are those of the timing; those of the plan stay with the plan.

    Args:
        plan: Untimed.
        limits: Of the motion.
        known: Items that need not be timed again; receives the others.

    Raises:
        ValueError: An item of the plan does not start where the one before it ended.
    """
    motions = _motions(plan, limits, {} if known is None else known)
    slow = {number: each.slow for number, each in motions.items() if each.slow is not None}
    written = write_instructions(plan, _spliced(motions) if motions else hold(chain_of(plan)))
    return TimedProgram(plan.origin, written.totals, written.instructions, find_slow_passes(plan, slow))


def sprayed_s(plan: Plan, limits: Limits, known: TimedItems) -> dict[int | None, float]:
    """Seconds with the jet on in each step of a plan that is timed as by ``time_plan``, but not written."""
    motions = _motions(plan, limits, known)
    ticks: dict[int | None, int] = {}
    for number, item in enumerate(plan.items):
        if isinstance(item, SprayPass):
            tick = motions[number].samples.tick
            ticks[item.made_by.step] = ticks.get(item.made_by.step, 0) + int(tick[-1] - tick[0])
        elif isinstance(item, Dwell):
            ticks[item.made_by.step] = ticks.get(item.made_by.step, 0) + dwell_ticks(item)
    return {step: total * TICK_S for step, total in ticks.items()}


def time_path(plan: Plan, limits: Limits, pace: Pace = FREE) -> TimedPath:
    """Time a plan as ``time_plan`` does, and nowhere faster than a pace along its path.

    Raises:
        ValueError: An item of the plan does not start where the one before it ended.
    """
    path, samples, slow = _follow(plan, limits, pace)
    written = write_instructions(plan, samples)
    program = TimedProgram(plan.origin, written.totals, written.instructions, find_slow_passes(plan, slow))
    return TimedPath(program, path, samples.at[written.poses])


def _follow(plan: Plan, limits: Limits, pace: Pace = FREE) -> tuple[Path | None, Samples, dict[int, Slow]]:
    """Path of a plan, the samples of the motion along it, and how slow its passes are, by the number of the item."""
    # Keeps back what the rounding of the file may add to the acceleration.
    limits = limits.model_copy(update={"acceleration_mm_s2": ACCELERATION_SHARE * limits.acceleration_mm_s2})
    chain = chain_of(plan)
    if len(chain.item) == 0:
        return None, hold(chain), {}
    path = round_corners(chain, limits)
    profile = parametrise(path, limits, pace)
    return path, sample(path, profile), slow_items(path, profile, limits)


def _motions(plan: Plan, limits: Limits, known: TimedItems) -> dict[int, TimedItem]:
    """Motion of each moving item, by its number; new ones that follow each other are timed as one path."""
    keys = _keys(plan)
    marked = [(number, key not in known) for number, key in keys.items()]
    for unknown, group in groupby(marked, itemgetter(1)):
        numbers = [number for number, _ in group]
        if unknown:
            first = numbers[0]
            part = replace(plan, items=plan.items[first : numbers[-1] + 1])
            _, samples, slow = _follow(part, limits)
            ends = 1 + np.searchsorted(samples.item[1:], np.array(numbers) - first, side="right")
            begins = np.concatenate(([1], ends[:-1]))
            for number, begin, end in zip(numbers, begins.tolist(), ends.tolist(), strict=True):
                known[keys[number]] = TimedItem(samples.cut(begin - 1, end), slow.get(number - first))
    return {number: known[key] for number, key in keys.items()}


def _keys(plan: Plan) -> dict[int, Hashable]:
    """What the motion of each moving item depends on: itself, and the run-up or pass that it meets without a stop."""
    moving = {number: item for number, item in enumerate(plan.items) if isinstance(item, SprayPass | Transfer)}
    own = {
        number: (
            item.tcp.tobytes(),
            item.approach.tobytes(),
            item.reference.tobytes(),
            item.speeds_mm_s.tobytes() if isinstance(item, SprayPass) else item.speed_mm_s,
        )
        for number, item in moving.items()
    }
    joined = {
        number
        for number, item in moving.items()
        if isinstance(item, Transfer) and isinstance(moving.get(number + 1), SprayPass)
    }
    return {
        number: (
            own[number - 1] if number - 1 in joined else None,
            key,
            own[number + 1] if number in joined else None,
        )
        for number, key in own.items()
    }


def _spliced(motions: Mapping[int, TimedItem]) -> Samples:
    """Samples of items one after the other, each with the sign of orientation in which the one before it ends."""
    parts = [each.samples for each in motions.values()]

    def joined(name: str) -> NDArray[np.float64]:
        return np.concatenate([getattr(parts[0], name)[:1], *(getattr(part, name)[1:] for part in parts)])

    return Samples(
        tick=np.cumsum(np.concatenate([[0], *(np.diff(part.tick) for part in parts)])),
        item=np.repeat(list(motions), [len(part.tick) - (number > 0) for number, part in enumerate(parts)]),
        position=joined("position"),
        quaternion=align_signs(joined("quaternion")) + 0.0,
        at=joined("at"),
    )


def chain_of(plan: Plan) -> Chain:
    """Chain of the items' vertices, each pose once."""
    moving = [(number, item) for number, item in enumerate(plan.items) if isinstance(item, SprayPass | Transfer)]
    owner = np.repeat([number for number, _ in moving], [len(item.tcp) for _, item in moving]).astype(np.int64)
    tcp = _stack([item.tcp for _, item in moving])
    quaternion = quaternions_from_axes(
        _stack([item.approach for _, item in moving]), _stack([item.reference for _, item in moving])
    )
    lengths = np.linalg.norm(np.diff(tcp, axis=0), axis=1)
    angles = rotation_angles(quaternion[:-1], quaternion[1:])
    wrong = np.flatnonzero(((lengths > _GAP_MM) | (angles > _GAP_RAD)) & (np.diff(owner) > 0))
    if len(wrong):
        before, after = (plan.items[int(owner[wrong[0] + k])].made_by for k in (0, 1))
        raise ValueError(f"{after}: does not start where {before} ended, in position and orientation.")
    kept = np.concatenate((np.ones(len(tcp[:1]), dtype=np.bool_), (lengths > _SAME_MM) | (angles > _SAME_RAD)))
    item = owner[kept][1:]
    # A stop wherever the item changes, except where a run-up may meet its pass without one.
    run_up = [isinstance(a, Transfer) and isinstance(b, SprayPass) for a, b in pairwise(plan.items)]
    served = np.concatenate(([False], np.array(run_up, dtype=np.bool_)))
    lead_in = (np.diff(item) == 1) & served[item[1:]]
    stop = (np.diff(item) > 0) & ~lead_in
    spraying = np.array([isinstance(each, SprayPass) for each in plan.items], dtype=np.bool_)
    # On the way to each vertex of an item; to the first, another item came.
    speeds = (
        np.full(len(move.tcp), move.speed_mm_s)
        if isinstance(move, Transfer)
        else np.append(move.speeds_mm_s[:1], move.speeds_mm_s)
        for _, move in moving
    )
    speed = np.concatenate([np.empty(0), *speeds])
    return Chain(
        tcp=tcp[kept],
        quaternion=quaternion[kept],
        item=item,
        speed=speed[kept][1:],
        spraying=spraying[item],
        stop=np.pad(stop, 1, constant_values=True),
        lead_in=np.pad(lead_in, 1, constant_values=False),
    )


def _stack(parts: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    return np.concatenate([np.empty((0, 3)), *parts])
