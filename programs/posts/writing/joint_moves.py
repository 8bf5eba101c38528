"""The speeds of joint motions: those that take the planned time, in whole percents of the joints' own."""

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from programs.motion.installation import Installation
from programs.motion.steps import Call, EndRepeat, Line, Reach, Repeat, Step
from programs.posts.writing.axes import units_of
from programs.timing.controller import Controller
from programs.timing.ways import Machine

_SAME_RAD = 1e-6
"""Radians or mm between joint values that are the same."""
_SLACK = 1e-6


@dataclass(frozen=True, slots=True)
class Pace:
    """How fast a joint motion goes."""

    percent: int
    """Of the joints' greatest speeds."""
    seconds: float | None = None
    """Planned from rest to rest; ``None`` where the robot may come from elsewhere."""


CAUTIOUS = Pace(10)
"""Of a joint motion whose beginning or time is not planned."""


def machine_of(installation: Installation, controller: Controller) -> Machine:
    """Give the limits of a cell's robot under a controller, the joints' in degrees and mm."""
    units, joints = units_of(installation), installation.joints
    return Machine(
        controller,
        np.array([joint.speed for joint in joints]) / units,
        np.array([joint.acceleration for joint in joints]) / units,
        np.array([float(joint.kind == "revolute") for joint in joints]),
    )


def pace_moves(steps: Sequence[Step], installation: Installation, controller: Controller) -> dict[int, Pace]:
    """Find how fast the joint motions of a program have to be to take their planned times.

    The speed is the least whole percent of the joints' greatest ones that takes no longer than planned, with the
    accelerations of the cell; where none does it is 100.

    Args:
        steps: Of the program.
        installation: The cell; the joints' limits count.
        controller: The model, for how accelerations build up.

    Returns:
        The pace of each joint motion that begins where it is planned to, in each turn of a loop too, by its identity
        (``id``). A program may come to the others from elsewhere.
    """
    machine, units = machine_of(installation, controller), units_of(installation)
    paces: dict[int, Pace] = {}
    for step in _planned(steps):
        if len(step.joints) != len(units) or not step.way:
            continue
        way = np.subtract(step.joints, step.start) / units
        moves = np.abs(way) > _SAME_RAD
        if np.any(moves) and np.all(np.isfinite(machine.speed[moves])):
            most_s = step.duration_s * (1.0 + _SLACK)
            slower = bisect_left(range(1, 100), True, key=lambda each: machine.joint_time(way, 0.01 * each) <= most_s)
            paces[id(step)] = Pace(1 + slower, step.duration_s)
    return paces


def _planned(steps: Sequence[Step]) -> list[Reach]:
    """Joint motions that begin where the step before them ends, however the program comes to them."""
    found: dict[int, Reach] = {}
    joints: tuple[float, ...] | None = None
    loops: list[int] = []
    for at, step in enumerate(steps):
        match step:
            case Reach():
                if joints is not None and _is_same(joints, step.start):
                    found[id(step)] = step
                joints = step.joints
            case Line():
                joints = step.joints
            case Call():
                joints = None  # the integrator's routine may leave the robot elsewhere
            case Repeat():
                loops.append(at)
            case EndRepeat() if loops:
                inside = steps[loops.pop() : at]
                first = next((each for each in inside if isinstance(each, Reach | Line | Call)), None)
                if isinstance(first, Reach) and not (joints is not None and _is_same(joints, first.start)):
                    found.pop(id(first), None)
            case _:
                pass
    return list(found.values())


def _is_same(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return bool(one) and len(one) == len(other) and bool(np.all(np.abs(np.subtract(one, other)) <= _SAME_RAD))
