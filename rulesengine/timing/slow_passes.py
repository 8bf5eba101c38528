"""Passes that are sprayed more slowly than programmed, and the causes."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from geometry.arrays import Indices, Scalars
from programs.plan import Plan, SprayPass
from recipes.recipe import Limits
from rulesengine.timing.corner_blending import Path
from rulesengine.timing.limit_intervals import Profile
from specs.finding import Finding, Severity
from specs.finding_rules import SPEED_BELOW_PROGRAMMED
from specs.source import Source

_SHARE = 0.98
"""Slower than this share of the programmed speed is slow."""
_LEAST_MM = 0.01
_MOST_SHARE = 0.5
"""Above this share of the sprayed length it is a warning, up to it a note."""

Cause: TypeAlias = Literal["stop", "robot", "corner", "rotation", "length"]
_ADVICE: dict[Cause, str] = {
    "stop": "it stops inside the path, to turn on the spot or at a bend that cannot be rounded; "
    "round the bend or raise limits.blend_mm",
    "robot": "the robot's joints are at their limits; place the board where they turn less, or lower the speed",
    "corner": "a corner is too sharp; raise limits.blend_mm or limits.acceleration_mm_s2, or lower the speed",
    "rotation": "the nozzle has to turn; raise limits.rotation_deg_s or limits.rotation_acceleration_deg_s2, "
    "or lower the speed",
    "length": "the path is too short to get there; raise limits.acceleration_mm_s2, give a lead-in, or lower the speed",
}


@dataclass(frozen=True, slots=True, eq=False)
class _Sprayed:
    """The stages (m,) of all passes, and what is slow on them."""

    profile: Profile
    item: Indices
    programmed: Scalars
    slow_mm: Scalars
    """How much of the stage is slow, the ramps at the ends of its pass left out."""
    worst: Scalars
    """Speed to report, mm/s: the lowest there, or the highest of a pass that is too short."""
    place: Scalars
    """Path parameter of that speed."""


def find_slow_passes(plan: Plan, path: Path, profile: Profile, limits: Limits) -> tuple[Finding, ...]:
    """Find where the sprayed speed is more than 2 % below the programmed one: one finding for each ``made_by``.

    The ramps from and to rest at the ends of a pass are left out, unless the pass is too short for anything else.
    """
    segment = profile.stages.segment
    chosen = np.flatnonzero(path.chain.spraying[segment] & ~path.spin[segment])
    if len(chosen) == 0:
        return ()
    sprayed = _look(path, profile.pick(chosen), limits.acceleration_mm_s2)
    names: dict[Source, int] = {}
    numbers = [names.setdefault(x.made_by, len(names)) if isinstance(x, SprayPass) else -1 for x in plan.items]
    group = np.array(numbers)[sprayed.item]
    slow_mm = np.bincount(group, sprayed.slow_mm, minlength=len(names))
    total_mm = np.bincount(group, sprayed.profile.stages.length, minlength=len(names))
    ratio = np.where(sprayed.slow_mm > 0.0, np.round(sprayed.worst / sprayed.programmed, 6), np.inf)
    order = np.lexsort((ratio, group))
    first = np.searchsorted(group[order], np.arange(len(names)))
    findings: list[Finding] = []
    for made_by, number in names.items():
        if slow_mm[number] > _LEAST_MM:
            worst = int(order[first[number]])
            x, y, z = np.round(path.positions(sprayed.place[worst : worst + 1])[0], 3).tolist()
            share = slow_mm[number] / total_mm[number]
            severity: Severity = "warning" if share > _MOST_SHARE else "info"
            message = (
                f"{share:.1%} of {total_mm[number]:.1f} mm is sprayed more slowly than programmed, at "
                f"{sprayed.worst[worst]:.1f} instead of {sprayed.programmed[worst]:.1f} mm/s: "
                f"{_ADVICE[_cause(sprayed, worst, limits)]}."
            )
            findings.append(Finding(SPEED_BELOW_PROGRAMMED, message, made_by, (x, y, z), override=severity))
    return tuple(findings)


def _look(path: Path, profile: Profile, acceleration: float) -> _Sprayed:
    """Measure what is slow on each stage, between the ramps at the ends of its pass."""
    stages = profile.stages
    item, programmed = path.chain.item[stages.segment], path.chain.speed[stages.segment]
    enough = (_SHARE * programmed) ** 2
    ramp = 0.5 * enough / acceleration
    begins = np.cumsum(stages.length) - stages.length
    borders = np.flatnonzero(np.diff(item)) + 1
    of_pass = np.cumsum(np.concatenate(([0], np.diff(item) != 0)))
    firsts = np.concatenate(([0], borders))
    pass_begin = begins[firsts][of_pass]
    pass_end = (begins + stages.length)[np.concatenate((borders - 1, [len(item) - 1]))][of_pass]
    short = pass_end - pass_begin <= 2.0 * ramp
    ramp = np.where(short, 0.0, ramp)
    growth = (profile.end - profile.begin) / stages.length
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = np.clip((enough - profile.begin) / growth, 0.0, stages.length)
    first = np.where((profile.begin < enough) | (growth >= 0.0), 0.0, crossing)
    last = np.where(profile.begin >= enough, np.where(profile.end < enough, stages.length, 0.0), stages.length)
    last = np.where((profile.begin < enough) & (profile.end >= enough), crossing, last)
    first = np.maximum(first, pass_begin + ramp - begins)
    last = np.minimum(last, pass_end - ramp - begins)
    # A short pass is reported with its highest speed, any other one with the lowest between its ramps.
    highest = np.maximum(profile.begin, profile.end)
    peak = highest == np.maximum.reduceat(highest, firsts)[of_pass]
    at = np.where((growth >= 0.0) != short, first, last)
    worst = np.sqrt(np.maximum(profile.begin + growth * at, 0.0))
    return _Sprayed(
        profile=profile,
        item=item,
        programmed=programmed,
        slow_mm=np.maximum(last - first, 0.0),
        worst=np.where(short & ~peak, np.inf, worst),
        place=stages.start + at,
    )


def _cause(sprayed: _Sprayed, worst: int, limits: Limits) -> Cause:
    """Cause of the low speed at the worst stage: from it and its neighbours in the same pass."""
    stages = sprayed.profile.stages
    near = np.arange(max(worst - 1, 0), min(worst + 2, len(sprayed.item)))
    near = near[sprayed.item[near] == sprayed.item[worst]]
    if sprayed.worst[worst] < 1e-6 and len(np.unique(stages.run[near])) > 1:
        return "stop"
    if stages.bounded[worst]:
        return "robot"
    turning = stages.turn[near] > 0.0
    free = np.where(
        stages.curvature[near] > 0.0, limits.acceleration_mm_s2 / np.maximum(stages.curvature[near], 1e-12), np.inf
    )
    held = stages.cap[near] < np.minimum(free, sprayed.programmed[near] ** 2) * (1.0 - 1e-9)
    if np.any(turning & (held | (stages.push[near] < limits.acceleration_mm_s2))):
        return "rotation"
    return "corner" if np.any(stages.curvature[near] > 0.0) else "length"
