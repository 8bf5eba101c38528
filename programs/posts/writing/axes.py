"""Joint motion as controllers count it: degrees and mm."""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from geometry.compiled import compiled
from programs.motion.installation import Installation, JointKind, ToolPointMachine
from programs.motion.samples import SampledLine
from programs.motion.steps import Line, Moment, MotionProgram, Reach, Step

Joints: TypeAlias = NDArray[np.float64]
"""(m, dof)"""
AXIS_MM, AXIS_DEG = 0.004, 0.002
"""How far an axis may be off the planned motion; at 300 mm from the axis 0.002 degrees are 0.01 mm."""
POINT_MM, TURN_DEG, COARSE_TURN_DEG = 0.09, 0.25, 0.5
"""The same of tool points: what lines may leave out, B and C on a line, and those where blocks would be short."""
_SAME_SHARE = 1e-9


def units_of(installation: Installation) -> Scalars:
    """(dof,) size of one degree, or one mm, in the joints' own unit: radians, or mm."""
    return _units(tuple(joint.kind for joint in installation.joints))


@lru_cache(maxsize=64)
def _units(kinds: tuple[JointKind, ...]) -> Scalars:
    return np.array([math.radians(1.0) if kind == "revolute" else 1.0 for kind in kinds])


def in_degrees_and_mm(joints: tuple[float, ...], installation: Installation) -> tuple[float, ...]:
    """Joint values as the cell counts them, in degrees and mm; joints that it does not describe are revolute."""
    kinds = installation.joint_kinds(len(joints))
    return tuple(math.degrees(q) if kind == "revolute" else q for q, kind in zip(joints, kinds, strict=True))


def as_controller_counts(joints: tuple[float, ...], installation: Installation) -> tuple[float, ...]:
    """Joint values as the robot's own controller counts them: its zeros, signs and couplings, in degrees and mm."""
    values, convention = in_degrees_and_mm(joints, installation), installation.convention
    return values if convention is None else convention.count(values)


def from_controller_counts(counted: tuple[float, ...], installation: Installation) -> tuple[float, ...]:
    """Joint values in degrees and mm, as the cell counts them: the inverse of ``as_controller_counts``."""
    return counted if installation.convention is None else installation.convention.recover(counted)


def place_on(
    samples: SampledLine, units: Scalars, axes: tuple[float, ...], after: float, allowed: Scalars | None = None
) -> tuple[float, float]:
    """Find where the planned motion passes the given axes.

    Args:
        samples: The planned motion along a line.
        units: From ``units_of``.
        axes: Degrees and mm.
        after: Share of the line before which not to look.
        allowed: (dof,) degrees and mm by which each axis may be off; left out, 0.002 degrees and 0.004 mm.

    Returns:
        The share of the line done there, and how far off the axes are, in units of what is allowed.
    """
    if samples.joints.shape[1] != len(axes):
        return 1.0, math.inf
    exact = allowed_of(units)
    allowed = exact if allowed is None else allowed
    return _place(samples.joints, samples.shares, np.array(axes), units, (allowed, exact), after + _SAME_SHARE)


@compiled
def _place(
    joints: Joints, shares: Scalars, axes: Scalars, units: Scalars, limits: tuple[Scalars, Scalars], after: float
) -> tuple[float, float]:
    """Find the nearest place of samples after a share, by what is allowed; limits are what is, and the exact ones."""
    allowed, exact = limits
    last, target = len(shares) - 1, axes / allowed
    off_end = most = 0.0
    for axis in range(len(axes)):
        off = abs(joints[last, axis] / units[axis] / allowed[axis] - target[axis])
        off_end, most = max(off_end, off), max(most, off * allowed[axis] / exact[axis])
    if most <= 1.0:  # where nothing moves all shares fit; the end is meant
        return 1.0, off_end
    found, best = 1.0, np.inf
    row = joints[0] / units / allowed
    for at in range(last):
        after_row = joints[at + 1] / units / allowed
        along = squared = 0.0
        for axis in range(len(axes)):
            step = after_row[axis] - row[axis]
            along += (target[axis] - row[axis]) * step
            squared += step * step
        part = min(max(along / max(squared, 1e-30), 0.0), 1.0)
        share = shares[at] + part * (shares[at + 1] - shares[at])
        off = 0.0
        for axis in range(len(axes)):
            off = max(off, abs(row[axis] + part * (after_row[axis] - row[axis]) - target[axis]))
        if share > after and off < best:
            found, best = share, off
        row = after_row
    return found, best


def needed_samples(
    samples: SampledLine, units: Scalars, fineness: float, allowed: Scalars | None = None
) -> tuple[int, ...]:
    """Choose the samples of a line between which the axes may run straight; the first is not among them, the last is.

    Args:
        samples: The planned motion along a line.
        units: From ``units_of``.
        fineness: How much of what is allowed may be used up.
        allowed: (dof,) degrees and mm, as for ``place_on``.
    """
    allowed = allowed_of(units) if allowed is None else allowed
    key = ("needed", fineness, *units.tolist(), *allowed.tolist())
    if (needed := samples.memo.get(key)) is None:
        needed = samples.memo[key] = tuple(_needed(samples.joints, samples.shares, units, fineness * allowed).tolist())
    return needed


@compiled
def _needed(joints: Joints, shares: Scalars, units: Scalars, allowed: Scalars) -> Indices:
    """Divide samples where they are farthest from straight, until they are nowhere beyond what is allowed."""
    numbers = np.empty(len(shares), dtype=np.int64)
    count = 0
    for at in range(len(shares)):  # the first of those at one share
        if at == 0 or shares[at] != shares[at - 1]:
            numbers[count] = at
            count += 1
    numbers = numbers[:count]
    numbers[count - 1] = len(shares) - 1
    rows = joints[numbers] / units / allowed
    kept = np.zeros(count, dtype=np.bool_)
    kept[count - 1] = True
    stack = [(0, count - 1)]
    while stack:
        begin, end = stack.pop()
        first, worst, most = shares[numbers[begin]], begin, -1.0
        length = max(shares[numbers[end]] - first, 1e-30)
        for at in range(begin, end + 1):
            part, off = (shares[numbers[at]] - first) / length, 0.0
            for axis in range(rows.shape[1]):
                straight = rows[begin, axis] + part * (rows[end, axis] - rows[begin, axis])
                off = max(off, abs(straight - rows[at, axis]))
            if off > most:
                worst, most = at, off
        if most > 1.0:
            kept[worst] = True
            stack.append((begin, worst))
            stack.append((worst, end))
    return numbers[kept]


def allowed_of(units: Scalars) -> Scalars:
    """(dof,) how far each axis may be off, in mm or degrees."""
    return np.where(units == 1.0, AXIS_MM, AXIS_DEG)


def allowed_on(units: Scalars, installation: Installation, turn_deg: float = COARSE_TURN_DEG) -> Scalars:
    """(dof,) how far each axis may be off along a line, in mm or degrees: more where the controller takes tool points.

    There the orifice keeps to its line whatever B and C do, and only the jet's direction is off.
    """
    if installation.tool_point is None:
        return allowed_of(units)
    return np.where(units == 1.0, POINT_MM, turn_deg)


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
