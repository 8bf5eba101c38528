"""A position with an orientation, and the few things that are done with single ones."""

import math
from dataclasses import dataclass
from typing import TypeAlias

Position: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Pose:
    """Where b is, seen from a: ``T_a_b``. Millimetres; quaternion w, x, y, z of unit length."""

    position: Position
    quaternion: Quaternion


IDENTITY = Pose((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))


def compose(first: Pose, second: Pose) -> Pose:
    """``T_a_c`` from ``T_a_b`` and ``T_b_c``."""
    x, y, z = rotate(first.quaternion, second.position)
    a, b, c = first.position
    return Pose((a + x, b + y, c + z), unit(product(first.quaternion, second.quaternion)))


def inverse(pose: Pose) -> Pose:
    """``T_b_a`` from ``T_a_b``."""
    w, x, y, z = pose.quaternion
    back = (w, -x, -y, -z)
    a, b, c = rotate(back, pose.position)
    return Pose((-a, -b, -c), back)


def rotate(quaternion: Quaternion, vector: Position) -> Position:
    """Turn a vector."""
    w, *axis = quaternion
    _, x, y, z = product(product(quaternion, (0.0, *vector)), (w, -axis[0], -axis[1], -axis[2]))
    return (x, y, z)


def between(start: Pose, end: Pose, share: float) -> Pose:
    """Interpolate: this share of the straight way in position and of the short turn in orientation (slerp)."""
    (a, b, c), (d, e, f) = start.position, end.position
    position = (a + share * (d - a), b + share * (e - b), c + share * (f - c))
    half = 0.5 * angle(start, end)
    if half < 1e-9:
        return Pose(position, end.quaternion if share > 0.5 else start.quaternion)
    (i, j, k, m), (w, x, y, z) = start.quaternion, end.quaternion
    p, q = math.sin((1 - share) * half) / math.sin(half), math.sin(share * half) / math.sin(half)
    q = q if i * w + j * x + k * y + m * z >= 0 else -q
    return Pose(position, unit((p * i + q * w, p * j + q * x, p * k + q * y, p * m + q * z)))


def angle(start: Pose, end: Pose) -> float:
    """Radians of the short turn between two orientations, 0 to pi."""
    (a, b, c, d), (w, x, y, z) = start.quaternion, end.quaternion  # the product, written out: it is called most of all
    return 2.0 * math.atan2(
        math.hypot(a * x - b * w - c * z + d * y, a * y + b * z - c * w - d * x, a * z - b * y + c * x - d * w),
        abs(a * w + b * x + c * y + d * z),
    )


def distance(start: Pose, end: Pose) -> float:
    """Millimetres between two positions."""
    return math.dist(start.position, end.position)


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Turn by q, then by p."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def unit(q: Quaternion) -> Quaternion:
    """Scale a quaternion to length 1."""
    size = math.hypot(*q)
    return (q[0] / size, q[1] / size, q[2] / size, q[3] / size)
