"""From a posture at each node to the joints at every sample: the same branch all along."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.motion.ladder_graph import Nodes, Postures, leant, solve_by_tool
from robotcell.motion.ladder_search import Choice, Layers
from robotcell.motion.sampled_path import Course, Flags
from robotcell.robot.full_turns import unwound
from robotcell.robot.robot import Joint, Joints, Poses, Robot

_CALM_S = 0.5
"""Turns about the jet are spread over about twice this time."""
_PINNED = 1e6
"""How much more the azimuth of a pinned node counts than its being smooth."""


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """What the robot does at the n samples of a course."""

    course: Course
    q: Joints
    """(n, dof); inside a leap it is where the leap begins."""
    T_base_tcp: Poses
    """(n, 4, 4) as the robot does it: with the chosen azimuth and lean."""
    azimuth: Scalars
    """(n,) rad, about the jet, from what was asked."""
    lean: NDArray[np.float64]
    """(n, 2) rad"""
    piece: Indices
    """(n,) samples that are reached without a leap have the same number."""
    lost: Flags
    """(n,) whether no posture was found here; the joints are those of the nearest node then."""


@dataclass(frozen=True, slots=True, eq=False)
class Wanted:
    """Postures at nodes, with the azimuths made smooth."""

    sample: Indices
    """(k,) the first of each node"""
    until: Indices
    """(k,) the last of each node: the posture is held till then"""
    q: Joints
    """(k, dof)"""
    azimuth: Scalars
    """(k,) rad, going on from node to node"""
    lean: NDArray[np.float64]
    leaps: Flags
    """(k - 1,)"""


def chosen_postures(robot: Robot, layers: Layers, choice: Choice, nodes: Nodes, wraps: Flags) -> Wanted:
    """Give the postures of a choice: joints that wrap (dof,) go on past whole turns until they leap."""
    azimuth = layers.azimuth[choice.state]
    steps = np.diff(azimuth)
    steps -= 2.0 * np.pi * np.round(steps / (2.0 * np.pi) - 1e-9)
    return Wanted(
        sample=nodes.sample,
        until=nodes.until,
        q=_wound(robot, layers.q[choice.state], choice.leaps, wraps),
        azimuth=np.concatenate((azimuth[:1], azimuth[0] + np.cumsum(steps))),
        lean=layers.lean[choice.state],
        leaps=choice.leaps,
    )


def overwound(robot: Robot, wanted: Wanted) -> Indices:
    """Give the joints that were wound up beyond their limits."""
    low = np.array([joint.lowest for joint in robot.joints])
    high = np.array([joint.highest for joint in robot.joints])
    return np.flatnonzero(((wanted.q < low - 1e-6) | (wanted.q > high + 1e-6)).any(axis=0))


def smooth(wanted: Wanted, course: Course, pinned: Flags) -> Wanted:
    """Spread the turns about the jet over time where the azimuth is free.

    Minimises the integral of (a - chosen)^2 + T^2 (da/dt)^2, a tridiagonal system; nothing crosses a leap.
    """
    from scipy.linalg import solveh_banded

    if len(wanted.sample) == 1:
        return wanted
    gaps = np.maximum(course.times[wanted.sample[1:]] - course.times[wanted.until[:-1]], 1e-3)
    weight = np.zeros(len(wanted.sample))
    weight[:-1] += 0.5 * gaps
    weight[1:] += 0.5 * gaps
    weight = np.where(pinned, weight * _PINNED + _PINNED, weight)
    stiff = np.where(wanted.leaps, 0.0, _CALM_S**2 / gaps)
    band = np.zeros((2, len(weight)))
    band[0, 1:] = -stiff
    band[1] = weight
    band[1, :-1] += stiff
    band[1, 1:] += stiff
    return replace(wanted, azimuth=np.asarray(solveh_banded(band, weight * wanted.azimuth)))


def settle(robot: Robot, wanted: Wanted, course: Course, postures: Postures) -> tuple[Wanted, Flags]:
    """Solve the nodes anew at their smooth azimuths, next to the chosen postures; say where that failed."""
    poses = leant(course.T_base_tcp[wanted.sample], wanted.azimuth, wanted.lean)
    q, lost = _nearest(robot, poses, course.tool[wanted.sample], wanted.q, postures)
    lost |= _far(robot, q, wanted.q) > np.radians(40.0)
    return replace(wanted, q=np.where(lost[:, None], wanted.q, q)), lost


def follow(robot: Robot, wanted: Wanted, course: Course, postures: Postures) -> Followed:
    """Give the joints at every sample, nearest to what lies between the nodes' postures."""
    number = np.arange(len(course.times))
    before = np.searchsorted(wanted.sample, number, side="right") - 1
    after = np.minimum(before + 1, len(wanted.sample) - 1)
    begin, end = course.times[wanted.until[before]], course.times[wanted.sample[after]]
    inner = (number > wanted.until[before]) & (end > begin)
    share = np.where(inner, (course.times - begin) / np.where(end > begin, end - begin, 1.0), 0.0)
    skipped = inner & np.append(wanted.leaps, False)[before]
    share[skipped] = 0.0
    reference = wanted.q[before] + share[:, None] * (wanted.q[after] - wanted.q[before])
    azimuth = wanted.azimuth[before] + share * (wanted.azimuth[after] - wanted.azimuth[before])
    azimuth = np.where(course.free, azimuth, 0.0)
    lean = wanted.lean[before] + share[:, None] * (wanted.lean[after] - wanted.lean[before])
    poses = leant(course.T_base_tcp, azimuth, lean)
    poses[skipped] = poses[wanted.until[before]][skipped]
    q, lost = _nearest(robot, poses, course.tool, reference, postures)
    q[skipped] = wanted.q[before][skipped]
    begins = np.zeros(len(number), dtype=np.int64)
    begins[wanted.sample[1:][wanted.leaps]] = 1
    piece = np.cumsum(begins)
    return Followed(course, q, poses, azimuth, lean, piece, lost & ~skipped)


def _nearest(robot: Robot, poses: Poses, tool: Indices, reference: Joints, postures: Postures) -> tuple[Joints, Flags]:
    """Solve poses (k, 4, 4); give the branch next to a reference row, and where there is none within the limits."""
    found, _ = solve_by_tool(poses, tool, postures)
    fitted = unwound(robot, found, reference[:, None])
    far = np.max(np.abs(fitted - reference[:, None]), axis=2)
    far = np.where(np.isfinite(far), far, np.inf)
    row = np.arange(len(poses))
    best = np.argmin(np.round(far, 9), axis=1)
    lost = ~np.isfinite(far[row, best])
    return np.where(lost[:, None], reference, fitted[row, best]), lost


def _far(robot: Robot, one: Joints, other: Joints) -> Scalars:
    """Greatest difference (k,) of the turning joints of two rows."""
    turning = np.array([joint.kind == "revolute" for joint in robot.joints])
    return np.max(np.abs(one - other) * turning, axis=1, initial=0.0)


def _wound(robot: Robot, q: Joints, leaps: Flags, wraps: Flags) -> Joints:
    """Let joints go on past whole turns between leaps, and begin each piece where it stays within the limits."""
    wound = q.copy()
    edges = [0, *(np.flatnonzero(leaps) + 1).tolist(), len(q)]
    for a, b in pairwise(edges):
        for index in np.flatnonzero(wraps).tolist():
            joint = robot.joints[index]
            going = np.unwrap(q[a:b, index])
            came = wound[a - 1, index] if a > 0 else _middle(joint)
            wound[a:b, index] = going + _turns(going, joint.lowest, joint.highest, float(came))
    return wound


def _middle(joint: Joint) -> float:
    bounded = np.isfinite(joint.lowest) and np.isfinite(joint.highest)
    return 0.5 * (joint.lowest + joint.highest) if bounded else 0.0


def _turns(going: Scalars, lowest: float, highest: float, came: float) -> float:
    """Whole turns, rad, that bring angles within limits; of several the ones next to where the joint comes from."""
    full = 2.0 * np.pi
    least = -np.inf if np.isinf(lowest) else np.ceil((lowest - going.min()) / full - 1e-9)
    most = np.inf if np.isinf(highest) else np.floor((highest - going.max()) / full + 1e-9)
    near = np.round((came - going[0]) / full - 1e-9)
    return full * float(np.clip(near, least, most) if least <= most else near)
