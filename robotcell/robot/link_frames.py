"""Where the links of a robot are, for many rows of joints. Metres, radians."""

import math

import numpy as np
from numpy.typing import NDArray

from geometry.compiled import compiled, inner


@compiled
def write_links(
    terms: NDArray[np.float64], turns: NDArray[np.bool_], q: NDArray[np.float64], poses: NDArray[np.float64]
) -> None:
    """Write the links (n, dof + 1, 4, 4) at (n, dof) rows of joints, the base's frame first.

    Args:
        terms: (dof, 3, 4, 4) a joint's motion is the first matrix of the sum, and the second times its value, or where
            it turns times the sine of that, and the third times 1 less its cosine.
        turns: (dof,) whether a joint turns.
        q: Rows of joints.
        poses: Receives the links.
    """
    motion = np.empty((3, 4))
    for row in range(len(q)):
        poses[row] = 0.0
        for link in range(len(turns) + 1):
            poses[row, link, 3, 3] = 1.0
        for axis in range(3):
            poses[row, 0, axis, axis] = 1.0
        for joint in range(len(turns)):
            value = q[row, joint]
            once, twice = (math.sin(value), 1.0 - math.cos(value)) if turns[joint] else (value, 0.0)
            for line in range(3):
                for column in range(4):
                    motion[line, column] = (
                        terms[joint, 0, line, column]
                        + once * terms[joint, 1, line, column]
                        + twice * terms[joint, 2, line, column]
                    )
            _multiply(poses[row, joint], motion, poses[row, joint + 1])


@inner
def _multiply(before: NDArray[np.float64], motion: NDArray[np.float64], after: NDArray[np.float64]) -> None:
    """Write the pose (4, 4) after a motion (3, 4)."""
    for line in range(3):
        for column in range(4):
            total = before[line, 3] if column == 3 else 0.0
            for between in range(3):
                total += before[line, between] * motion[between, column]
            after[line, column] = total
