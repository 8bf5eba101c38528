"""Plan in, timed program out."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from geometry.frames import quaternions_from_axes, rotation_angles
from programs.plan import Plan, SprayPass, Transfer
from programs.program import TimedProgram
from recipes.recipe import Limits
from rulesengine.timing.corner_blending import Chain, Path, round_corners
from rulesengine.timing.pace import FREE, Pace
from rulesengine.timing.sampling import hold, sample
from rulesengine.timing.slow_passes import find_slow_passes
from rulesengine.timing.speed_profile import parametrise
from rulesengine.timing.write_instructions import write_instructions

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


def time_plan(plan: Plan, limits: Limits) -> TimedProgram:
    """Time a plan: the fastest motion within the limits, at the programmed speed while spraying wherever they allow it.

    The findings are those of the timing; those of the plan stay with the plan.

    Raises:
        ValueError: An item of the plan does not start where the one before it ended.
    """
    return time_path(plan, limits).program


def time_path(plan: Plan, limits: Limits, pace: Pace = FREE) -> TimedPath:
    """Time a plan as ``time_plan`` does, and nowhere faster than a pace along its path.

    Raises:
        ValueError: An item of the plan does not start where the one before it ended.
    """
    # Keeps back what the rounding of the file may add to the acceleration.
    limits = limits.model_copy(update={"acceleration_mm_s2": ACCELERATION_SHARE * limits.acceleration_mm_s2})
    chain = chain_of(plan)
    if len(chain.item) == 0:
        held = write_instructions(plan, hold(chain))
        return TimedPath(TimedProgram(plan.origin, held.totals, held.instructions), None, np.zeros(len(held.poses)))
    path = round_corners(chain, limits)
    profile = parametrise(path, limits, pace)
    samples = sample(path, profile)
    written = write_instructions(plan, samples)
    slow = find_slow_passes(plan, path, profile, limits)
    program = TimedProgram(plan.origin, written.totals, written.instructions, slow)
    return TimedPath(program, path, samples.at[written.poses])


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
