"""Passes that are sprayed more slowly than programmed, and the causes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from geometry.arrays import Indices, Scalars
from programs.plan import Plan
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


@dataclass(frozen=True, slots=True)
class Slow:
    """How much of a pass is slow, and the worst of it."""

    slow_mm: float
    sprayed_mm: float
    ratio: float
    """Of the worst speed to the programmed one; infinite where nothing is slow."""
    speed_mm_s: float
    programmed_mm_s: float
    where: tuple[float, float, float]
    cause: Cause


def slow_items(path: Path, profile: Profile, limits: Limits) -> dict[int, Slow]:
    """How slow the passes of a path are, by the number of the plan's item.

    The ramps from and to rest at the ends of a pass are left out, unless the pass is too short for anything else.
    """
    segment = profile.stages.segment
    chosen = np.flatnonzero(path.chain.spraying[segment] & ~path.spin[segment])
    if len(chosen) == 0:
        return {}
    sprayed = _look(path, profile.pick(chosen), limits.acceleration_mm_s2)
    items, group = np.unique(sprayed.item, return_inverse=True)
    slow_mm, sprayed_mm = (np.bincount(group, each) for each in (sprayed.slow_mm, sprayed.profile.stages.length))
    ratio = np.where(sprayed.slow_mm > 0.0, np.round(sprayed.worst / sprayed.programmed, 6), np.inf)
    order = np.lexsort((ratio, group))
    worst = order[np.searchsorted(group[order], np.arange(len(items)))]
    place = np.round(path.positions(sprayed.place[worst]), 3)
    return {
        int(item): Slow(
            slow_mm=float(slow_mm[number]),
            sprayed_mm=float(sprayed_mm[number]),
            ratio=float(ratio[at]),
            speed_mm_s=float(sprayed.worst[at]),
            programmed_mm_s=float(sprayed.programmed[at]),
            where=tuple(place[number].tolist()),
            cause=_cause(sprayed, int(at), limits),
        )
        for number, (item, at) in enumerate(zip(items, worst, strict=True))
    }


def find_slow_passes(plan: Plan, slow: Mapping[int, Slow]) -> tuple[Finding, ...]:
    """Find where the sprayed speed is more than 2 % below the programmed one: one finding for each ``made_by``."""
    groups: dict[Source, list[Slow]] = {}
    for number, each in slow.items():
        groups.setdefault(plan.items[number].made_by, []).append(each)
    findings: list[Finding] = []
    for made_by, passes in groups.items():
        slow_mm, sprayed_mm = sum(each.slow_mm for each in passes), sum(each.sprayed_mm for each in passes)
        if slow_mm > _LEAST_MM:
            worst = min(passes, key=lambda each: each.ratio)
            severity: Severity = "warning" if slow_mm > _MOST_SHARE * sprayed_mm else "info"
            message = (
                f"{slow_mm / sprayed_mm:.1%} of {sprayed_mm:.1f} mm is sprayed more slowly than programmed, at "
                f"{worst.speed_mm_s:.1f} instead of {worst.programmed_mm_s:.1f} mm/s: {_ADVICE[worst.cause]}."
            )
            findings.append(Finding(SPEED_BELOW_PROGRAMMED, message, made_by, worst.where, override=severity))
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
