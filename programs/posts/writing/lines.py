"""Lines beside each other: where outputs change, how a corner is passed, how fast the tool turns."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from programs.motion.steps import Event, Line, Step

_STRAIGHT = 1e-3
"""Radians between two directions that count as one."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A step, and where on it outputs change."""

    step: Step
    begins: tuple[Event, ...] = ()
    """Where it begins: its own, and those of the end of the line before it if that is passed."""
    inside: tuple[Event, ...] = ()
    ends: tuple[Event, ...] = ()
    """Where it stops."""


def place_events(steps: Sequence[Step]) -> Iterator[Placed]:
    """Move outputs from the end of a line that is passed to the beginning of the next line."""
    carried: tuple[Event, ...] = ()
    for step in steps:
        if not isinstance(step, Line):
            yield Placed(step)
            continue
        begins = (*carried, *(event for event in step.events if event.share <= 0.0))
        inside = tuple(event for event in step.events if 0.0 < event.share < 1.0)
        last = tuple(event for event in step.events if event.share >= 1.0)
        carried = last if step.blend_mm > 0.0 else ()
        yield Placed(step, begins, inside, () if carried else last)


def follow(steps: Sequence[Step]) -> dict[int, Line]:
    """Find the line right after each line that is passed, by the identity (``id``) of the latter."""
    return {
        id(step): after
        for step, after in pairwise(steps)
        if isinstance(step, Line) and isinstance(after, Line) and step.blend_mm > 0.0
    }


def is_straight(line: Line, after: Line | None) -> bool:
    """Whether the next line has the same direction."""
    if after is None or line.turns_on_the_spot or after.turns_on_the_spot:
        return False
    return math.dist(line.direction, after.direction) <= _STRAIGHT


def turn_limit(line: Line) -> float | None:
    """Rate that a turn may have where it is not to slow the line down, degrees/s; ``None`` where it hardly turns.

    A tenth more than planned on a line with a length, so that the speed of the TCP decides; rounded up to a tenth.
    """
    if line.turns_on_the_spot:
        return degrees_per_s(line)
    if math.degrees(line.angle_rad) <= 0.5:
        return None
    return max(math.ceil(11.0 * math.degrees(line.turn_rad_s)) / 10.0, 0.1)


def degrees_per_s(line: Line) -> float:
    """Rate of a line's turn, rounded up to a tenth so that rounding never slows it down; at least 0.1."""
    return max(math.ceil(10.0 * math.degrees(line.turn_rad_s)) / 10.0, 0.1)
