"""A motion in tool points: what a controller takes that derives the carriage of its machine from them."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from programs.motion.installation import Installation, ToolPointMachine
from programs.motion.steps import Line, Moment, MotionProgram, Reach, SampledLine, Step
from programs.posts.writing.axes import needed_samples

MOVE = np.array([1.0, 1.0, 1.0, 0.5, 0.5])
"""mm and degrees by which a joint move may be left: the cell keeps a margin of some mm."""
_PART_RAD = np.radians(3.0)


def in_tool_points(motion: MotionProgram, installation: Installation) -> MotionProgram:
    """Give a motion whose joints are the controller's axes: tool points, and the angles of B and C as it counts them.

    A joint move becomes several, between which the axes go straight. Speeds are those that the robot reaches, as such a
    controller does not slow down for the joints of its carriage; a turn on the spot has that of B and C together.

    Args:
        motion: With joints.
        installation: One with a tool-point machine.
    """
    machine = installation.tool_point
    assert machine is not None
    steps: list[Step] = []
    joints = installation.home
    for step in motion.steps:
        match step:
            case Line():
                steps.append(_line(step, machine))
                joints = step.joints
            case Reach():
                steps += _moves(step, joints, machine)
                joints = step.joints
            case _:
                steps.append(step)
    return replace(motion, steps=tuple(steps))


def one_row(machine: ToolPointMachine, joints: tuple[float, ...]) -> tuple[float, ...]:
    """Give the axes of one row of joints (5,), rad and mm."""
    return tuple(machine.axes(np.array([joints], dtype=np.float64))[0].tolist())


def own_axes(machine: ToolPointMachine, joints: tuple[float, ...]) -> tuple[float, ...]:
    """Give the machine's own axes of one row of joints (5,): the carriage, and B and C as they are counted."""
    return (*joints[:3], *one_row(machine, joints)[3:])


def _line(line: Line, machine: ToolPointMachine) -> Line:
    samples = replace(line.samples, joints=machine.axes(line.samples.joints))
    lasting = np.diff(samples.seconds)
    if line.turns_on_the_spot:
        turns = np.linalg.norm(np.diff(samples.joints[:, 3:], axis=0), axis=1)
        return replace(line, samples=samples, turn_rad_s=float((turns / lasting).max()))
    reached = line.length_mm * float((np.diff(samples.shares) / lasting).max())
    return replace(line, samples=samples, speed_mm_s=min(line.speed_mm_s, reached))


def _moves(reach: Reach, before: tuple[float, ...], machine: ToolPointMachine) -> Iterator[Reach]:
    """Divide a joint move where its tool point leaves a straight way."""
    if not reach.joints or not before:
        yield replace(reach, joints=one_row(machine, reach.joints) if reach.joints else ())
        return
    moments = reach.way or (Moment(1.0, reach.target, reach.joints),)
    rows, seconds = [np.array(before)], [0.0]
    for moment in moments:
        to = np.array(moment.joints)
        parts = max(int(np.ceil(np.abs(to[3:] - rows[-1][3:]).max() / _PART_RAD)), 1)
        shares = np.arange(1, parts + 1)[:, None] / parts
        rows += list(rows[-1] + shares * (to - rows[-1]))
        seconds += list(seconds[-1] + shares[:, 0] * (moment.seconds - seconds[-1]))
    axes = machine.axes(np.array(rows))
    size = np.array([1.0, 1.0, 1.0, np.radians(1.0), np.radians(1.0)])
    passed = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(axes / size, axis=0), axis=1))))
    way = SampledLine(np.array(seconds), passed / max(float(passed[-1]), 1e-9), axes)
    for at in needed_samples(way, size, 1.0, MOVE):
        yield replace(reach, joints=tuple(axes[at].tolist()), way=())
