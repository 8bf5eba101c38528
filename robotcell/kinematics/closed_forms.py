"""Closed forms of six-axis arms: every configuration of spherical wrists and of three parallel axes, compiled.

Spherical wrist, Pieper (1968): the first three joints bring the point where the last three axes meet to its place, the
last three turn about it.

Three parallel axes, in the order of the Cairo paper, the usual one for Universal Robots: joint 1 from the place where
axes 5 and 6 meet, joints 5 and 6 and the sum of 2, 3 and 4 from the orientation, joints 2 and 3 from what is left in
the plane.

Where a joint turns freely its branches take the preferred angle and the one opposite, as the branches of every pose
nearby lie opposite each other. With three parallel axes (axes 5 and 6 meet above axis 1; axis 6 parallel to axes 2 to
4) what is left in the plane depends on that angle: each branch then has a half turn for itself, around these angles.
Joint 6 takes the middle of that half turn, or of the part of it that can be reached; joint 1 that angle of 512 that
leaves most configurations.

The order of the branches is shoulder (before, behind), elbow (left, right), wrist (axis 6 tilted forth, back), the last
fastest.
"""

import math

import numpy as np

from geometry.compiled import compiled, inner
from robotcell.kinematics.chain import Bend, Chain, Matrix, Row, SixAxis, add_step, polish_rows
from robotcell.robot.robot import Joints, Poses

SLACK = 1e-9
"""m: a pose that lies so little out of reach is taken to lie on the border"""
MERGED = 1e-13
"""m: so near the border of reach two branches are one; they would differ by 1e-6 rad at most, for rounding alone"""
FREE = 1e-9
"""m or rad: nearer than so to a singular pose a joint turns freely"""
NO_ANGLE, ONE_ANGLE, FREE_ANGLE = 0, 1, 2
"""Results of a step: no angle, one angle, or any angle"""


@inner
def _room(less: float, more: float) -> float:
    """How much is left between two lengths: nothing if hardly anything."""
    return more - less if more - less > MERGED else 0.0


@inner
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


@inner
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


@inner
def turn_back(matrix: Matrix, y_angle: float, z_angle: float, out: Matrix) -> None:
    """Write Rz(-z_angle) Ry(-y_angle) matrix; all (3, 3)."""
    cy, sy = math.cos(y_angle), math.sin(y_angle)
    cz, sz = math.cos(z_angle), math.sin(z_angle)
    for column in range(3):
        x, y, z = matrix[0, column], matrix[1, column], matrix[2, column]
        x, z = cy * x - sy * z, sy * x + cy * z
        out[0, column], out[1, column], out[2, column] = cz * x + sz * y, cz * y - sz * x, z


@inner
def tilt_of(turned: Matrix, side: int) -> tuple[int, float]:
    """Give b of Rz(a) Ry(b) Rz(c), 0 <= b <= pi for side 0, its negative for side 1.

    LOOSE where b is 0 or pi: a and c then turn about the same axis.
    """
    across = math.hypot(turned[0, 2], turned[1, 2])
    tilt = (1.0 - 2.0 * side) * math.atan2(across, turned[2, 2])
    return (FREE_ANGLE if across < FREE else ONE_ANGLE), tilt


@inner
def first_turn(turned: Matrix, side: int) -> float:
    """Give a of Rz(a) Ry(b) Rz(c) where b is not 0 or pi."""
    sign = 1.0 - 2.0 * side
    return math.atan2(sign * turned[1, 2], sign * turned[0, 2])


@inner
def last_turn(turned: Matrix, first: float) -> float:
    """Give c of Rz(a) Ry(b) Rz(c), from a."""
    c, s = math.cos(first), math.sin(first)
    return math.atan2(c * turned[1, 0] - s * turned[0, 0], c * turned[1, 1] - s * turned[0, 1])


@inner
def first_from_last(turned: Matrix, last: float) -> float:
    """Give a of Rz(a) Ry(b) Rz(c), from c."""
    c, s = math.cos(last), math.sin(last)
    return math.atan2(-(s * turned[0, 0] + c * turned[0, 1]), s * turned[1, 0] + c * turned[1, 1])


TRIES = 512
"""Angles of a half turn that are tried for a joint that turns freely"""


def solve_six_axis(arm: SixAxis, chain: Chain, poses: Poses, preferred: Joints, rows: Joints) -> None:
    """Write the rows (n, 8, 6) that bring the flange to poses (n, 4, 4) of the base frame, NaN where there is none."""
    rows[:] = np.nan
    wrists, preferred = _wrist_poses(arm.T_plane_base, poses, arm.T_flange_wrist), preferred.copy()
    if arm.is_parallel:
        parallel_branches(arm, wrists, preferred, rows)
    else:
        spherical_branches(arm, wrists, preferred, rows)
    polish_rows(chain, poses, rows)


@compiled
def _wrist_poses(T_plane_base: Poses, poses: Poses, T_flange_wrist: Poses) -> Poses:
    """Give the wrist frame (n, 4, 4) in the plane frame."""
    wrists, moved = np.empty_like(poses), np.empty((3, 4))
    for index in range(len(poses)):
        wrists[index] = T_plane_base
        add_step(wrists[index], poses[index], moved)
        add_step(wrists[index], T_flange_wrist, moved)
    return wrists


@compiled
def spherical_branches(arm: SixAxis, wrists: Poses, preferred: Joints, rows: Joints) -> None:
    """Write the rows (n, 8, 6) that bring the wrist frame to poses (n, 4, 4) of the plane frame."""
    arm_end, turned = np.empty((3, 3)), np.empty((3, 3))
    for index in range(len(wrists)):
        wrist = wrists[index]
        for side in range(2):
            found, shoulder, forward = turn_to_plane(wrist[0, 3], wrist[2, 3], arm.aside, side)
            if found == NO_ANGLE:
                continue
            if found == FREE_ANGLE:
                shoulder = preferred[index, 0] + side * math.pi
            for elbow in range(2):
                found, first, second = bend_to(arm.bend, forward, wrist[1, 3], elbow, preferred[index, 1])
                if found == NO_ANGLE:
                    continue
                turn_back(wrist[:3, :3], shoulder, first + second, arm_end)
                at = 4 * side + 2 * elbow
                mine = rows[index, at : at + 2]
                mine[:, 0], mine[:, 1], mine[:, 2] = shoulder, first, arm.signs[2] * second
                _turn_wrist(arm, arm_end, turned, preferred[index, 3], mine)


@inner
def _turn_wrist(arm: SixAxis, arm_end: Matrix, turned: Matrix, preferred: float, rows: Joints) -> None:
    """Write joints 4 to 6 of both ways (2, 6) to turn the wrist from its rotation in link 3; ``turned`` is scratch."""
    frame = arm.wrist
    for row in range(3):
        for column in range(3):
            turned[row, column] = (
                frame[0, row] * arm_end[0, column]
                + frame[1, row] * arm_end[1, column]
                + frame[2, row] * arm_end[2, column]
            )
    for side in range(2):
        found, tilt = tilt_of(turned, side)
        first = preferred + side * math.pi if found == FREE_ANGLE else first_turn(turned, side)
        rows[side, 3] = first
        rows[side, 4] = tilt - arm.tilt
        rows[side, 5] = last_turn(turned, first)


@compiled
def parallel_branches(arm: SixAxis, wrists: Poses, preferred: Joints, rows: Joints) -> None:
    """Write the rows (n, 8, 6) that bring the wrist frame to poses (n, 4, 4) of the plane frame."""
    turned = np.empty((3, 3))
    for index in range(len(wrists)):
        wrist, favoured = wrists[index], preferred[index]
        for side in range(2):
            found, shoulder, forward = turn_to_plane(wrist[0, 3], wrist[2, 3], arm.aside, side)
            if found == NO_ANGLE:
                continue
            mine = rows[index, 4 * side : 4 * side + 4]
            if found == FREE_ANGLE:
                _choose_shoulder(arm, wrist, favoured[0] + side * math.pi, favoured, mine)
                continue
            turn_back(wrist[:3, :3], shoulder, 0.0, turned)
            _below_shoulder(arm, turned, (forward, wrist[1, 3]), favoured, mine)
            mine[:, 0] = shoulder


@compiled
def _choose_shoulder(arm: SixAxis, wrist: Poses, middle: float, preferred: Row, rows: Joints) -> None:
    """Write the rows (4, 6) at the angle of joint 1 that leaves most of them."""
    turned, tried = np.empty((3, 3)), np.empty_like(rows)
    most = 0
    for number in range(TRIES):
        step = (number + 1) // 2 * (math.pi / TRIES)  # farther and farther out on both sides
        shoulder = middle + step if number % 2 else middle - step
        turn_back(wrist[:3, :3], shoulder, 0.0, turned)
        tried[:] = np.nan
        count = _below_shoulder(arm, turned, (0.0, wrist[1, 3]), preferred, tried)
        if count > most:
            most = count
            rows[:] = tried
            rows[:, 0] = shoulder


@inner
def _below_shoulder(arm: SixAxis, turned: Matrix, place: tuple[float, float], preferred: Row, rows: Joints) -> int:
    """Write joints 2 to 6 of up to four rows (4, 6), seen from joint 1; give how many there are."""
    count = 0
    for side in range(2):
        found, tilt = tilt_of(turned, side)
        if found == FREE_ANGLE:
            middle = first_from_last(turned, preferred[5] + side * math.pi) - arm.turn
            first = choose_total(arm, place, middle) + arm.turn
        else:
            first = first_turn(turned, side)
        total = first - arm.turn
        c, s = math.cos(total), math.sin(total)
        x = place[0] - (c * arm.last[0] - s * arm.last[1])
        y = place[1] - (s * arm.last[0] + c * arm.last[1])
        last = last_turn(turned, first)
        for elbow in range(2):
            found, second, third = bend_to(arm.bend, x, y, elbow, preferred[1])
            if found == NO_ANGLE:
                rows[2 * elbow + side] = np.nan
                continue
            row = rows[2 * elbow + side]
            row[1], row[2], row[3] = second, arm.signs[2] * third, arm.signs[3] * (total - second - third)
            row[4], row[5] = tilt - arm.tilt, last
            count += 1
    return count


@inner
def choose_total(arm: SixAxis, place: tuple[float, float], middle: float) -> float:
    """Choose the sum of joints 2 to 4 where any keeps the orientation.

    The distance that joints 2 and 3 have to span grows steadily as the last link turns from pointing away from axis 2
    to pointing at it: what they reach is two arcs, each the other's mirror image.

    Args:
        arm: the arm.
        place: where axes 5 and 6 meet, in the plane.
        middle: the preferred sum.

    Returns:
        The middle if it can be reached. Else the middle of the nearer arc, as far as it lies within a quarter turn of
        the preferred sum. If there is none the middle nevertheless, which then is not reached.
    """
    x, y = place[0] - arm.bend.first[0], place[1] - arm.bend.first[1]
    offset = math.atan2(y, x) - math.atan2(arm.last[1], arm.last[0])
    least, most = _arc(arm, math.hypot(x, y))
    preferred = middle - offset
    preferred -= 2.0 * math.pi * math.ceil((preferred - math.pi) / (2.0 * math.pi))
    if least <= abs(preferred) <= most or least > most:
        return middle
    best, nearest = preferred, math.inf
    for mirrored in range(2):
        begin, end = (-most, -least) if mirrored else (least, most)
        for turns in range(-1, 2):
            low = max(begin + turns * 2.0 * math.pi, preferred - math.pi / 2.0)
            high = min(end + turns * 2.0 * math.pi, preferred + math.pi / 2.0)
            away = abs((low + high) / 2.0 - preferred)
            # a hair's breadth, so that a rounding does not choose between an arc and its mirror image
            if low <= high and away < nearest - 1e-9:
                best, nearest = (low + high) / 2.0, away
    return middle + best - preferred


@compiled
def _arc(arm: SixAxis, far: float) -> tuple[float, float]:
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
