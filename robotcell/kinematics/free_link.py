"""Which way to turn a link that may be turned freely, so that two others reach its end; compiled."""

import math

from geometry.compiled import compiled
from robotcell.kinematics.arm_types import ParallelArm
from robotcell.kinematics.subproblems import SLACK


@compiled
def choose_total(arm: ParallelArm, place: tuple[float, float], middle: float) -> float:
    """Choose the sum of joints 2 to 4 where any keeps the orientation.

    The distance that joints 2 and 3 have to span grows steadily as the last link turns from pointing away from axis 2
    to pointing at it: what they reach is two arcs, each the other's mirror image.

    Args:
        arm: the arm.
        place: where axes 5 and 6 meet, in the plane.
        middle: the sum that is liked best.

    Returns:
        The middle if it can be reached. Else the middle of the nearer arc, as far as it lies within a quarter turn of
        what is liked best. If there is nothing the middle nevertheless, which then is not reached.
    """
    x, y = place[0] - arm.bend.first[0], place[1] - arm.bend.first[1]
    offset = math.atan2(y, x) - math.atan2(arm.last[1], arm.last[0])
    least, most = _arc(arm, math.hypot(x, y))
    liked = middle - offset
    liked -= 2.0 * math.pi * math.ceil((liked - math.pi) / (2.0 * math.pi))
    if least <= abs(liked) <= most or least > most:
        return middle
    best, nearest = liked, math.inf
    for mirrored in range(2):
        begin, end = (-most, -least) if mirrored else (least, most)
        for turns in range(-1, 2):
            low = max(begin + turns * 2.0 * math.pi, liked - math.pi / 2.0)
            high = min(end + turns * 2.0 * math.pi, liked + math.pi / 2.0)
            away = abs((low + high) / 2.0 - liked)
            # a hair's breadth, so that a rounding does not choose between an arc and its mirror image
            if low <= high and away < nearest - 1e-9:
                best, nearest = (low + high) / 2.0, away
    return middle + best - liked


@compiled
def _arc(arm: ParallelArm, far: float) -> tuple[float, float]:
    """Give between which turns of the last link, from pointing away, its beginning is reached; nothing if reversed."""
    a, b = arm.bend.lengths
    last = math.hypot(arm.last[0], arm.last[1])
    least, most = abs(a - b) - SLACK, a + b + SLACK
    twice = 2.0 * far * last
    square = far * far + last * last
    if twice < SLACK * SLACK:
        return (0.0, math.pi) if least <= math.sqrt(square) <= most else (1.0, 0.0)
    nearest = (square - max(0.0, least) ** 2) / twice
    farthest = (square - most * most) / twice
    if nearest < -1.0 or farthest > 1.0:
        return 1.0, 0.0
    return math.acos(min(1.0, nearest)), math.acos(max(-1.0, farthest))
