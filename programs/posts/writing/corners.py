"""Where a line goes on straight into the next."""

import math
from itertools import pairwise

from programs.motion.steps_of_robot import Line, Step

_STRAIGHT = 1e-3
"""Radians between two directions that count as one."""


def follow(steps: tuple[Step, ...]) -> dict[int, Line]:
    """Give the line that comes right after each line that is passed, by the identity (``id``) of the latter."""
    return {
        id(step): after
        for step, after in pairwise(steps)
        if isinstance(step, Line) and isinstance(after, Line) and step.blend_mm > 0.0
    }


def goes_on(line: Line, after: Line) -> bool:
    """Whether the next line has the same direction."""
    if line.turns_on_the_spot or after.turns_on_the_spot:
        return False
    one, two = (
        [(b - a) / each.length_mm for a, b in zip(each.start.position, each.target.position, strict=True)]
        for each in (line, after)
    )
    return math.dist(one, two) <= _STRAIGHT
