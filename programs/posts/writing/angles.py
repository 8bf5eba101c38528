"""Orientations as the makers write them, and back. Degrees; quaternions w, x, y, z."""

import math

from programs.pose import Position, Quaternion, product, unit

_POLE = 1e-6
"""rad from +-90 degrees within which the first and the last of three angles turn about one axis."""


def fixed_xyz(q: Quaternion) -> Position:
    """Turn about the fixed x, then y, then z axis: FANUC W, P, R; Yaskawa Rx, Ry, Rz. At P = +-90 degrees W is 0.

    The same numbers in the opposite order turn about z, y', x'': ``moving_zyx``.
    """
    m = matrix(q)
    pitch = math.atan2(-m[2][0], math.hypot(m[0][0], m[1][0]))
    if math.hypot(m[0][0], m[1][0]) < _POLE:
        return (0.0, math.degrees(pitch), math.degrees(math.atan2(-m[0][1], m[1][1])))
    return _degrees(math.atan2(m[2][1], m[2][2]), pitch, math.atan2(m[1][0], m[0][0]))


def from_fixed_xyz(w: float, p: float, r: float) -> Quaternion:
    """Read what ``fixed_xyz`` writes."""
    return unit(product(_about(2, r), product(_about(1, p), _about(0, w))))


def moving_zyx(q: Quaternion) -> Position:
    """Turn about z, then the new y, then the new x axis: KUKA A, B, C; Epson U, V, W."""
    x, y, z = fixed_xyz(q)
    return (z, y, x)


def from_moving_zyx(a: float, b: float, c: float) -> Quaternion:
    """Read what ``moving_zyx`` writes."""
    return from_fixed_xyz(c, b, a)


def moving_xyz(q: Quaternion) -> Position:
    """Turn about x, then the new y, then the new z axis: Staubli rx, ry, rz. At ry = +-90 degrees rz is 0."""
    m = matrix(q)
    pitch = math.atan2(m[0][2], math.hypot(m[0][0], m[0][1]))
    if math.hypot(m[0][0], m[0][1]) < _POLE:
        return (math.degrees(math.atan2(m[2][1], m[1][1])), math.degrees(pitch), 0.0)
    return _degrees(math.atan2(-m[1][2], m[2][2]), pitch, math.atan2(-m[0][1], m[0][0]))


def from_moving_xyz(rx: float, ry: float, rz: float) -> Quaternion:
    """Read what ``moving_xyz`` writes."""
    return unit(product(_about(0, rx), product(_about(1, ry), _about(2, rz))))


def rotation_vector(q: Quaternion) -> Position:
    """Axis times angle, in RADIANS: Universal Robots rx, ry, rz."""
    w, x, y, z = q if q[0] >= 0 else (-q[0], -q[1], -q[2], -q[3])
    sine = math.hypot(x, y, z)
    scale = 2.0 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0
    return (scale * x, scale * y, scale * z)


def from_rotation_vector(rx: float, ry: float, rz: float) -> Quaternion:
    """Read what ``rotation_vector`` writes."""
    size = math.hypot(rx, ry, rz)
    if size < 1e-12:
        return (1.0, 0.0, 0.0, 0.0)
    scale = math.sin(0.5 * size) / size
    return (math.cos(0.5 * size), scale * rx, scale * ry, scale * rz)


def matrix(q: Quaternion) -> tuple[Position, Position, Position]:
    """Give the rows of the rotation matrix; near a pole the last digit of a length other than 1 would be the angles."""
    w, x, y, z = unit(q)
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def _about(axis: int, degrees: float) -> Quaternion:
    half = math.radians(degrees) / 2
    parts = [0.0, 0.0, 0.0]
    parts[axis] = math.sin(half)
    return (math.cos(half), parts[0], parts[1], parts[2])


def _degrees(a: float, b: float, c: float) -> Position:
    return (math.degrees(a), math.degrees(b), math.degrees(c))
