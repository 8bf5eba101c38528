"""How fast and how hard the joints of a robot's program move, against what they may. Seconds, metres, radians."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from programs.program import MoveTo, TimedProgram
from robotcell.robot import Joints

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
    lasting = np.diff(times)[:, None]
    speed = np.diff(q, axis=0) / lasting
    still, none = np.zeros((1, q.shape[1])), np.ones((1, 1))
    before, after = np.concatenate((none, lasting)), np.concatenate((lasting, none))
    before[0], after[-1] = after[0], before[-1]
    acceleration = np.diff(np.concatenate((still, speed, still)), axis=0) / (0.5 * (before + after))
    return Rates(times, q, speed, acceleration)
