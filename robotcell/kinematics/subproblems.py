"""The steps that closed forms of six-axis arms are made of, compiled. The plane frame of the forms, metres, radians.

Every root is taken of a product, not of a difference of squares, and every angle of two arguments: small angles keep
their digits where branches meet. The result of a step enters the next one, so that an angle that a nearly singular
pose leaves undetermined costs no accuracy of the pose.
"""

import math

from geometry.compiled import compiled
from robotcell.kinematics.arm_types import Bend
from robotcell.kinematics.chain import Matrix

SLACK = 1e-9
"""m: a pose that lies so little out of reach is taken to lie on the border"""
MERGED = 1e-13
"""m: so near the border of reach two branches are one; they would differ by 1e-6 rad at most, for rounding alone"""
FREE = 1e-9
"""m or rad: nearer than so to a singular pose a joint turns freely"""
NO_ANGLE, ONE_ANGLE, FREE_ANGLE = 0, 1, 2
"""Results of a step: no angle, one angle, or any angle"""


@compiled
def _room(less: float, more: float) -> float:
    """How much is left between two lengths: nothing if hardly anything."""
    return more - less if more - less > MERGED else 0.0


@compiled
def turn_to_plane(x: float, z: float, aside: float, side: int) -> tuple[int, float, float]:
    """Turn joint 1 so that the wrist's centre comes to lie ``aside`` the plane.

    Args:
        x: of the centre.
        z: of the centre.
        aside: what z has to become.
        side: 0 or 1, the centre before or behind axis 1.

    Returns:
        What was found, the angle, and the x that the centre then has.
    """
    radius, away = math.hypot(x, z), abs(aside)
    if radius < FREE and away < FREE:
        return FREE_ANGLE, 0.0, 0.0
    if away > radius + SLACK:
        return NO_ANGLE, 0.0, 0.0
    root = math.sqrt(_room(away, radius) * (radius + away))
    sign = 1.0 - 2.0 * side
    return ONE_ANGLE, math.atan2(x, z) + sign * math.atan2(root, aside), -sign * root


@compiled
def bend_to(bend: Bend, x: float, y: float, side: int, preferred_first: float) -> tuple[int, float, float]:
    """Turn two links so that their end comes to a point of the plane: the law of cosines, with half the angle.

    Args:
        bend: the links.
        x: of the point.
        y: of the point.
        side: 0 or 1, the elbow to the left or to the right.
        preferred_first: the first angle where any will do: the end lies on the first axis.

    Returns:
        What was found, and both angles from zero on.
    """
    x, y = x - bend.first[0], y - bend.first[1]
    a, b = bend.lengths
    reach = math.hypot(x, y)
    least = abs(a - b)
    if reach > a + b + SLACK or reach < least - SLACK:
        return NO_ANGLE, 0.0, 0.0
    outer = _room(reach, a + b) * (a + b + reach)
    inner = _room(least, reach) * (reach + least)
    between = (1.0 - 2.0 * side) * 2.0 * math.atan2(math.sqrt(outer), math.sqrt(inner))
    second = between - (bend.angles[1] - bend.angles[0])
    if reach < FREE:
        return FREE_ANGLE, preferred_first + side * math.pi, second
    first = math.atan2(y, x) - math.atan2(b * math.sin(between), a + b * math.cos(between))
    return ONE_ANGLE, first - bend.angles[0], second


@compiled
def turn_back(matrix: Matrix, y_angle: float, z_angle: float, out: Matrix) -> None:
    """Write Rz(-z_angle) Ry(-y_angle) matrix; all (3, 3)."""
    cy, sy = math.cos(y_angle), math.sin(y_angle)
    cz, sz = math.cos(z_angle), math.sin(z_angle)
    for column in range(3):
        x, y, z = matrix[0, column], matrix[1, column], matrix[2, column]
        x, z = cy * x - sy * z, sy * x + cy * z
        out[0, column], out[1, column], out[2, column] = cz * x + sz * y, cz * y - sz * x, z


@compiled
def tilt_of(turned: Matrix, side: int) -> tuple[int, float]:
    """Give b of Rz(a) Ry(b) Rz(c), 0 <= b <= pi for side 0, its negative for side 1.

    LOOSE where b is 0 or pi: a and c then turn about the same axis.
    """
    across = math.hypot(turned[0, 2], turned[1, 2])
    tilt = (1.0 - 2.0 * side) * math.atan2(across, turned[2, 2])
    return (FREE_ANGLE if across < FREE else ONE_ANGLE), tilt


@compiled
def first_turn(turned: Matrix, side: int) -> float:
    """Give a of Rz(a) Ry(b) Rz(c) where b is not 0 or pi."""
    sign = 1.0 - 2.0 * side
    return math.atan2(sign * turned[1, 2], sign * turned[0, 2])


@compiled
def last_turn(turned: Matrix, first: float) -> float:
    """Give c of Rz(a) Ry(b) Rz(c), from a."""
    c, s = math.cos(first), math.sin(first)
    return math.atan2(c * turned[1, 0] - s * turned[0, 0], c * turned[1, 1] - s * turned[0, 1])


@compiled
def first_from_last(turned: Matrix, last: float) -> float:
    """Give a of Rz(a) Ry(b) Rz(c), from c."""
    c, s = math.cos(last), math.sin(last)
    return math.atan2(-(s * turned[0, 0] + c * turned[0, 1]), s * turned[1, 0] + c * turned[1, 1])
