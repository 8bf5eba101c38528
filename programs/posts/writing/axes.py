"""Joint motion as controllers count it: degrees and mm."""

import math

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from programs.motion.installation import Installation
from programs.motion.steps_of_robot import Course

AXIS_MM, AXIS_DEG = 0.004, 0.002
"""How far an axis may be off the planned motion; at 300 mm from the axis 0.002 degrees are 0.01 mm."""
_SAME_SHARE = 1e-9


def units_of(installation: Installation) -> Scalars:
    """(dof,) what one degree, or one mm, is in the joints' own unit: radians, or mm."""
    return np.array([math.radians(1.0) if joint.kind == "revolute" else 1.0 for joint in installation.joints])


def in_controller_units(joints: tuple[float, ...], installation: Installation) -> tuple[float, ...]:
    """Give joint values in degrees and mm; joints that the cell does not describe are revolute."""
    kinds = [joint.kind for joint in installation.joints] or ["revolute"] * len(joints)
    return tuple(
        math.degrees(value) if kind == "revolute" else value for value, kind in zip(joints, kinds, strict=True)
    )


def place_on(course: Course, units: Scalars, axes: tuple[float, ...], after: float) -> tuple[float, float]:
    """Find where the planned motion passes the given axes.

    Args:
        course: The planned run along a line.
        units: What ``units_of`` gives.
        axes: Degrees and mm.
        after: Share of the line before which not to look.

    Returns:
        The share of the line done there, and how far off the axes are, in units of what is allowed.
    """
    if course.joints.shape[1] != len(axes):
        return 1.0, math.inf
    rows = course.joints / units / allowed_of(units)
    wanted = np.array(axes) / allowed_of(units)
    steps = np.diff(rows, axis=0)
    squared = np.maximum(np.sum(steps**2, axis=1), 1e-30)
    parts = np.clip(np.sum((wanted - rows[:-1]) * steps, axis=1) / squared, 0.0, 1.0)
    off = np.max(np.abs(rows[:-1] + parts[:, None] * steps - wanted), axis=1)
    shares = course.shares[:-1] + parts * np.diff(course.shares)
    off = np.where(shares > after + _SAME_SHARE, off, np.inf)
    if np.max(np.abs(rows[-1] - wanted)) <= 1.0:  # where nothing moves all shares fit; the end is meant
        return 1.0, float(np.max(np.abs(rows[-1] - wanted)))
    at = int(np.argmin(off))
    return (float(shares[at]), float(off[at])) if np.isfinite(off[at]) else (1.0, math.inf)


def needed_samples(course: Course, units: Scalars, fineness: float) -> tuple[int, ...]:
    """Choose the samples of a line between which the axes may run straight; the first is not among them, the last is.

    Args:
        course: The planned run along a line.
        units: What ``units_of`` gives.
        fineness: How much of what is allowed may be used up.
    """
    shares, samples = np.unique(course.shares, return_index=True)
    samples[-1] = len(course.shares) - 1
    rows = course.joints[samples] / units / (fineness * allowed_of(units))
    kept = {len(shares) - 1}
    stack = [(0, len(shares) - 1)]
    while stack:
        begin, end = stack.pop()
        off = _off_chord(shares[begin : end + 1], rows[begin : end + 1])
        worst = begin + int(np.argmax(off))
        if off[worst - begin] > 1.0:
            kept.add(worst)
            stack += [(begin, worst), (worst, end)]
    return tuple(int(samples[at]) for at in sorted(kept))


def _off_chord(shares: Scalars, rows: NDArray[np.float64]) -> Scalars:
    """How far each row is from where a straight run from the first to the last has it at the same share."""
    parts = (shares - shares[0]) / max(shares[-1] - shares[0], 1e-30)
    return np.max(np.abs(rows[0] + parts[:, None] * (rows[-1] - rows[0]) - rows), axis=1)


def allowed_of(units: Scalars) -> Scalars:
    """(dof,) what each axis may be off, in mm or degrees."""
    return np.where(units == 1.0, AXIS_MM, AXIS_DEG)
