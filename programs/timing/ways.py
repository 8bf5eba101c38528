"""Lines as a controller sees them, and how fast it drives each and passes its end."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, zip_longest
from math import acos, cos, dist, hypot, inf, sqrt, tan

import numpy as np

from geometry.arrays import Scalars
from geometry.compiled import compiled
from programs.pose import Position
from programs.timing.controller import Controller
from programs.timing.drive import Lane, Ramp
from programs.timing.forecast import Cause

_STRAIGHT = 1e-6
"""Change of a direction that is none."""
_LARGEST = 1e9
"""Speed and acceleration where nothing limits them."""
_ARC_SHARE = sqrt(0.75)
"""Of the acceleration that LinuxCNC uses across an arc (``BLEND_ACC_RATIO_NORMAL`` of its ``blendmath.h``)."""
_LEAST_COSINE = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """One line, all rates per mm of it, or per degree where the tool turns on the spot."""

    length: float
    turns: bool
    """Whether the tool turns on the spot."""
    direction: Position
    """Unit vector; zeros where the tool turns on the spot."""
    turning: Position
    """Turn of the tool: axis times degrees."""
    first: Scalars
    """(dof,) rates of the joints where it begins, degrees or mm."""
    last: Scalars
    """(dof,) where it ends."""
    fastest: Scalars
    """(dof,) largest."""
    bend: Scalars
    """(dof,) largest change of those rates."""
    speed: float
    """As commanded, mm/s or degrees/s."""
    stops: bool
    zone: float
    """How its end is passed, in the terms of the controller's blending."""
    turn_deg_s: float = inf
    """Greatest rate of the turn that its text states."""
    acceleration_mm_s2: float | None = None
    """That its text states; ``None`` for the controller's own."""
    turn_acceleration_deg_s2: float | None = None
    """Likewise."""
    whole_s: float | None = None
    """Time from rest to rest that its text states in place of a speed."""


@dataclass(frozen=True, slots=True)
class Limit:
    """How fast a line may be driven, whatever speed is commanded."""

    top: float
    """Greatest speed."""
    cause: Cause
    """What sets it."""
    ramp: Ramp
    leave: float
    """Greatest speed at its end."""
    kept: float = inf
    """Share of the lesser of its speed and the next one's that it has there at most."""
    rest_s: float = 0.0
    """Pause at its end."""


@dataclass(frozen=True, slots=True, eq=False)
class Machine:
    """What limits a motion: the controller and the joints."""

    controller: Controller
    speed: Scalars
    """(dof,) greatest speeds of the joints, degrees/s or mm/s."""
    acceleration: Scalars
    """(dof,)"""
    revolute: Scalars
    """(dof,) 1 where a joint turns, 0 where it slides."""

    def joint_time(self, way: Scalars, share: float) -> float:
        """Time of a joint motion from rest to rest.

        Args:
            way: (dof,) degrees or mm.
            share: Of the joints' greatest speeds.
        """
        longest = 0.0
        for size, speed, acceleration in np.column_stack((np.abs(way), self.speed, self.acceleration)).tolist():
            ramp = Ramp(min(acceleration, _LARGEST), self.controller.rise_s)
            top = ramp.peak(0.0, 0.0, size, min(share * speed, _LARGEST))
            if top > 0.0:
                longest = max(longest, 2.0 * ramp.duration(top) + (size - 2.0 * ramp.length(0.0, top)) / top)
        return longest

    def lanes(self, ways: Sequence[Way]) -> list[tuple[Lane, Cause]]:
        """Give how each of some lines that follow each other may be driven, and what limits it most."""
        limits = self.limits(ways)
        stated = [commanded(way, limit.ramp) for way, limit in zip(ways, limits, strict=True)]
        causes: list[Cause] = [
            cause if speed <= limit.top else limit.cause for (speed, cause), limit in zip(stated, limits, strict=True)
        ]
        return list(zip(self.lanes_at(ways, limits, [speed for speed, _ in stated]), causes, strict=True))

    def limits(self, ways: Sequence[Way]) -> list[Limit]:
        """Give what limits each of some lines that follow each other, whatever their commanded speeds."""
        tolerates = self.controller.blending == "tolerance"  # one line slows down while the next speeds up
        overlaps = [
            tolerates and not way.stops and (self._is_rotary(way) or self._is_rotary(after))
            for way, after in pairwise(ways)
        ]
        around = zip(ways, [False, *overlaps], [*overlaps, False], strict=False)
        limits = [self._limit(way, shared=before or after) for way, before, after in around]
        return [
            limit
            if after is None or next_limit is None or way.stops
            else self._pass(way, after, limit, min(limit.ramp.acceleration, next_limit.ramp.acceleration))
            for (way, after), (limit, next_limit) in zip(
                zip_longest(ways, ways[1:]), zip_longest(limits, limits[1:]), strict=True
            )
        ]

    def lanes_at(self, ways: Sequence[Way], limits: Sequence["Limit"], speeds: Sequence[float]) -> list[Lane]:
        """Give how lines may be driven with these limits at some commanded speeds."""
        tops = [max(min(speed, limit.top, _LARGEST), 1e-6) for speed, limit in zip(speeds, limits, strict=True)]
        return [
            Lane(way.length, way.turns, top, limit.ramp, min(limit.leave, limit.kept * min(top, after)), limit.rest_s)
            for way, limit, top, after in zip(ways, limits, tops, [*tops[1:], inf], strict=False)
        ]

    def _limit(self, way: Way, *, shared: bool) -> "Limit":
        """Greatest speed of a line that stops, what sets it, and how its speed may change.

        Args:
            way: The line.
            shared: Whether it shares the acceleration with a line before or after it, and is driven by itself.
        """
        controller, turn = self.controller, hypot(*way.turning)
        share = controller.blend_acceleration_share if shared else 1.0
        acceleration = min(
            inf if way.turns else way.acceleration_mm_s2 or controller.acceleration_mm_s2,
            (way.turn_acceleration_deg_s2 or controller.turn_acceleration_deg_s2) / turn if turn > 0.0 else inf,
            _least(self.acceleration, way.fastest),
        )
        ramp = Ramp(min(share * acceleration, _LARGEST), controller.rise_s)
        tops: list[tuple[float, Cause]] = [
            (_least(self.speed, way.fastest), "joint limits"),
            (sqrt(_least(self.acceleration, way.bend)), "joint limits"),
            (controller.turn_speed_deg_s / turn if turn > 0.0 else inf, "turn of the tool"),
            (way.length / controller.least_line_s if controller.least_line_s > 0.0 else inf, "short lines"),
        ]
        if controller.stops_in_turning_line and shared:
            tops.append((sqrt(ramp.acceleration * way.length), "short lines"))
        top, cause = min(tops, key=lambda each: each[0])
        return Limit(top, cause, ramp, leave=0.0, rest_s=controller.settle_s)

    def _is_rotary(self, way: Way) -> bool:
        return _turns(way.fastest, self.revolute) or (way.turns and not way.fastest.size)

    def _pass(self, way: Way, after: Way, limit: "Limit", acceleration: float) -> "Limit":
        """Give the limit of a line that is passed to another one."""
        leave, kept = 0.0, inf
        if way.turns == after.turns:
            match self.controller.blending:
                case "overlap":
                    leave, kept = inf, min(way.zone, 1.0)
                case "zone":
                    half = 0.5 * min(way.length, after.length)
                    leave = self._round(way, after, half if way.turns else min(way.zone, half))
                case "tolerance":
                    leave = self._within(way, after, acceleration)
        return replace(limit, leave=leave, kept=kept, rest_s=0.0)

    def _round(self, way: Way, after: Way, radius: float) -> float:
        """Greatest speed through a parabola that begins and ends ``radius`` from a corner.

        Over its 2 radius/v seconds each rate per mm changes evenly, so its acceleration is change v²/(2 radius).
        """
        controller, turn = self.controller, dist(way.turning, after.turning)
        least = _least(self.acceleration, np.abs(after.first - way.last))
        if not way.turns and (change := dist(way.direction, after.direction)) > _STRAIGHT:
            own = way.acceleration_mm_s2 or controller.acceleration_mm_s2
            least = min(least, own / change)
        if turn > _STRAIGHT:
            least = min(least, (way.turn_acceleration_deg_s2 or controller.turn_acceleration_deg_s2) / turn)
        return sqrt(2.0 * radius * least)

    def _within(self, way: Way, after: Way, acceleration: float) -> float:
        """Greatest speed through a corner that is left by ``zone`` mm at most, as LinuxCNC blends.

        Where a turning axis moves, one line slows down while the next speeds up: v = 2 sqrt(a zone / cos(angle/2)), the
        angle between the lines (``tpComputeBlendVelocity`` of its ``tp.c``). Elsewhere an arc is put into the corner.
        """
        dot = min(max(sum(a * b for a, b in zip(way.direction, after.direction, strict=True)), -1.0), 1.0)
        if self._is_rotary(way) or self._is_rotary(after):
            cosine = cos(0.5 * acos(-dot))
            return 2.0 * sqrt(acceleration * way.zone / cosine) if cosine > _LEAST_COSINE else inf
        half = 0.5 * acos(dot)
        if half < _LEAST_COSINE:
            return inf
        if cos(half) < _LEAST_COSINE:
            return 0.0
        by_zone = way.zone * cos(half) / (1.0 - cos(half))
        by_length = 0.5 * min(way.length, after.length) / tan(half)
        return sqrt(_ARC_SHARE * acceleration * min(by_zone, by_length))


def commanded(way: Way, ramp: Ramp) -> tuple[float, Cause]:
    """Speed that the text of a line states, in whichever terms, and what it is by."""
    if way.whole_s is not None:
        under_root = (ramp.acceleration * way.whole_s) ** 2 - 4.0 * ramp.acceleration * way.length
        return 0.5 * (ramp.acceleration * way.whole_s - sqrt(max(under_root, 0.0))), "speed"
    turn = hypot(*way.turning)
    by_turn = way.turn_deg_s / turn if turn > 0.0 else inf
    return min((way.speed, "speed"), (by_turn, "turn of the tool"))


@compiled
def _turns(fastest: Scalars, revolute: Scalars) -> bool:
    """Whether a turning axis moves."""
    return bool((fastest * revolute > _STRAIGHT).any())


@compiled
def _least(limits: Scalars, rates: Scalars) -> float:
    """Greatest speed or acceleration along a line at which no joint exceeds its limit."""
    least = inf
    for joint in range(len(rates)):
        if rates[joint] > 1e-12:
            least = min(least, limits[joint] / rates[joint])
    return least
