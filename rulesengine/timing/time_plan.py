"""Plan in, timed program out."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from operator import itemgetter
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from geometry.frames import align_signs, quaternions_from_axes, rotation_angles
from programs.plan import Dwell, Plan, SprayPass, Transfer
from programs.program import TimedProgram
from recipes.recipe import Limits
from rulesengine.timing.corner_blending import Chain, Path, round_corners
from rulesengine.timing.pace import FREE, Pace
from rulesengine.timing.sampling import TICK_S, Samples, hold, sample
from rulesengine.timing.slow_passes import Slow, find_slow_passes, slow_items
from rulesengine.timing.speed_profile import parametrise
from rulesengine.timing.write_instructions import dwell_ticks, write_instructions

ACCELERATION_SHARE = 0.94
"""Of the limit that is planned with: positions rounded to 1 um, 8 ms apart, may add 31 mm/s2, and a
reader of the file is to find the limit kept."""
_SAME_MM = 1e-4
_SAME_RAD = 1e-5
"""Neighbouring vertices nearer than this are one."""
_GAP_MM = 1e-3
_GAP_RAD = 1e-3
"""Items that do not meet within this are a mistake in the plan."""


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
    speed = np.concatenate([np.empty(0), *(_speeds_at(move) for _, move in moving)])
    return Chain(
        tcp=tcp[kept],
        quaternion=quaternion[kept],
        item=item,
        speed=speed[kept][1:],
        spraying=spraying[item],
        stop=np.pad(stop, 1, constant_values=True),
        lead_in=np.pad(lead_in, 1, constant_values=False),
    )


def _speeds_at(move: SprayPass | Transfer) -> Scalars:
    """(n,) programmed speed on the way to each vertex of an item; of the first, where another item came to it."""
    if isinstance(move, Transfer):
        return np.full(len(move.tcp), move.speed_mm_s)
    return np.append(move.speeds_mm_s[:1], move.speeds_mm_s)


def _stack(parts: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    return np.concatenate([np.empty((0, 3)), *parts])
