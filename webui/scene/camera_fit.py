"""Where the camera stands so that a box fills the free part of the picture. Board frame, millimetres."""

from dataclasses import dataclass
from itertools import product

import numpy as np

from geometry.arrays import Points

_FROM = np.array([0.0, -0.62, 0.785])
"""From what is looked at towards the eye: from the front, well above it, so that stripes and heights both show."""
_BESIDE = 0.9
_ABOVE, _BELOW = 0.85, 0.35
"""Shares of half the picture's width and height that may be filled: the playback stands at its foot."""


@dataclass(frozen=True, slots=True, eq=False)
class Lens:
    """What a camera sees."""

    fov: float
    """Vertical angle of view, radians."""
    aspect: float
    """Width of the free part of the picture divided by the height of all of it."""


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Where a camera stands and what it looks at."""

    eye: Points
    """(3,)"""
    target: Points
    """(3,)"""


def frame_box(low: Points, high: Points, lens: Lens, *, from_below: bool = False) -> Pose:
    """Stand just far enough away to see a box as a whole, above what stands at the foot of the page.

    Every corner c, seen from the middle of the box in the camera's axes (right, up, towards the eye), must keep
    ``|right| <= share * tan(fov / 2) * aspect * (distance - towards)``, and the same upwards.

    Args:
        low: (3,) lowest corner.
        high: (3,) highest corner.
        lens: What the camera sees.
        from_below: Look at the bottom side.
    """
    towards = _FROM * [1.0, 1.0, -1.0 if from_below else 1.0]
    right = np.array([1.0, 0.0, 0.0])
    upward = np.cross(towards, right)
    corners = np.array(list(product(*zip(low, high, strict=True)))) - (low + high) / 2
    tall = float(np.tan(lens.fov / 2))
    depth = corners @ towards
    across = np.abs(corners @ right) / (_BESIDE * tall * lens.aspect)
    height = np.abs(corners @ upward) / ((_ABOVE + _BELOW) / 2 * tall)
    distance = float((np.maximum(across, height) + depth).max())
    target = (low + high) / 2 - upward * ((_ABOVE - _BELOW) / 2 * tall * distance)
    return Pose(target + distance * towards, target)


def between(begin: Pose, end: Pose, share: float) -> Pose:
    """Give a pose on the way from one to another; it starts and ends gently."""
    eased = share * share * (3.0 - 2.0 * share)
    return Pose(begin.eye + eased * (end.eye - begin.eye), begin.target + eased * (end.target - begin.target))
