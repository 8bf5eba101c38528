"""How fast and how hard the joints of a robot's program move, against what they may. Seconds, metres, radians."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from programs.program import MoveTo, TimedProgram
from robotcell.robot.robot import Joints

_LEAST_S = 1e-6
"""Moves closer than this are at the same time: a tool was changed."""


@dataclass(frozen=True, slots=True, eq=False)
class Rates:
    """Joints over time: k moments at which the program states a pose."""

    times: Scalars
    """(k,) ascending"""
    q: Joints
    """(k, dof)"""
    speed: NDArray[np.float64]
    """(k - 1, dof) mean of each interval."""
    acceleration: NDArray[np.float64]
    """(k, dof) change of the mean speeds before and after; from rest and to rest at the ends."""


def rates_of(program: TimedProgram, joints: Joints) -> Rates:
    """Take the differences of joints (moves, dof), one row for each move of the program; at least one move."""
    times = np.array([item.time_s for item in program.instructions if isinstance(item, MoveTo)], dtype=np.float64)
    kept = np.concatenate(([True], np.diff(times) > _LEAST_S))
    times, q = times[kept], joints[kept]
    return Rates(times, q, *differences(np.diff(times), q))


def differences(lasting: Scalars, q: Joints) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Speeds and accelerations of rows of joints (k + 1, dof) that are ``lasting`` (k,) seconds apart.

    Returns:
        (k, dof) mean speeds of the intervals, and (k + 1, dof) their changes at the rows: from rest at the first and to
        rest at the last, over half of the time to each side.
    """
    seconds = lasting[:, None]
    speed = np.diff(q, axis=0) / seconds
    still, none = np.zeros((1, q.shape[1])), np.ones((1, 1))
    before, after = np.concatenate((none, seconds)), np.concatenate((seconds, none))
    before[0], after[-1] = after[0], before[-1]
    return speed, np.diff(np.concatenate((still, speed, still)), axis=0) / (0.5 * (before + after))
