"""Joint motion as controllers count it: degrees and mm."""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from programs.motion.installation import Installation, ToolPointMachine
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
    return np.array([math.radians(1.0) if joint.kind == "revolute" else 1.0 for joint in installation.joints])


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
    exact, allowed = allowed_of(units), allowed_of(units) if allowed is None else allowed
    rows, steps, squared = _scaled(samples, tuple(units.tolist()), tuple(allowed.tolist()))
    target = np.array(axes) / allowed
    off_end = np.abs(rows[-1] - target)
    if np.max(off_end * allowed / exact) <= 1.0:  # where nothing moves all shares fit; the end is meant
        return 1.0, float(np.max(off_end))
    parts = np.clip(np.sum((target - rows[:-1]) * steps, axis=1) / squared, 0.0, 1.0)
    off = np.max(np.abs(rows[:-1] + parts[:, None] * steps - target), axis=1)
    shares = samples.shares[:-1] + parts * np.diff(samples.shares)
    off = np.where(shares > after + _SAME_SHARE, off, np.inf)
    at = int(np.argmin(off))
    return (float(shares[at]), float(off[at])) if np.isfinite(off[at]) else (1.0, math.inf)


@lru_cache(maxsize=8)
def _scaled(
    samples: SampledLine, units: tuple[float, ...], allowed: tuple[float, ...]
) -> tuple[Joints, Joints, Scalars]:
    """Give the axes in units of what is allowed, their steps, and the squares of these; kept for lines just used."""
    rows = samples.joints / np.array(units) / np.array(allowed)
    steps = np.diff(rows, axis=0)
    return rows, steps, np.maximum(np.sum(steps**2, axis=1), 1e-30)


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
    shares, numbers = np.unique(samples.shares, return_index=True)
    numbers[-1] = len(samples.shares) - 1
    rows = samples.joints[numbers] / units / (fineness * (allowed_of(units) if allowed is None else allowed))
    kept = {len(shares) - 1}
    stack = [(0, len(shares) - 1)]
    while stack:
        begin, end = stack.pop()
        inside = rows[begin : end + 1]
        parts = (shares[begin : end + 1] - shares[begin]) / max(shares[end] - shares[begin], 1e-30)
        off = np.max(np.abs(inside[0] + parts[:, None] * (inside[-1] - inside[0]) - inside), axis=1)
        worst = begin + int(np.argmax(off))
        if off[worst - begin] > 1.0:
            kept.add(worst)
            stack += [(begin, worst), (worst, end)]
    return tuple(int(numbers[at]) for at in sorted(kept))


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
