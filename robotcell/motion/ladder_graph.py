"""What the robot could do at each node of a course: every branch, at every azimuth and lean that is allowed."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import Cell
from robotcell.kinematics.chain import chain_of
from robotcell.kinematics.manipulability_batch import manipulability
from robotcell.motion.ladder_search import FOLLOW, MAY_LEAP, MUST_LEAP, Layers, Paces, Steps
from robotcell.motion.sampled_path import Course, Flags
from robotcell.robot.robot import Joint, Joints, Poses, Robot

Postures: TypeAlias = Callable[[Poses, int], tuple[Joints, Scalars]]
"""Takes (n, 4, 4) T_base_tcp and a tool's index; gives (n, b, dof) joints, nan where none, and (n, b) by how much each
differs from the asked azimuth about the jet."""

NODE_M = 8e-3
NODE_RAD = np.radians(12.0)
"""Nodes are about this far apart, and at every rest, change of tool, and switch of the jet."""
_MOST_POSES = 300_000
"""Asked at all nodes together; of a longer program fewer azimuths are tried, but not fewer than"""
_FEWEST_AZIMUTHS = 6
AZIMUTHS = 18
"""Tried about the jet where it is free."""
_LIMIT_S = 0.02
"""What being at a joint's limit costs, in seconds for each node; half way to it next to nothing."""
_SINGULAR_S = 1e-3
"""What a singular posture costs at a tenth of the greatest manipulability; four times as much at half of that."""
_MOST_SINGULAR_S = 0.5
_MOST_TURNS = 3
_SLACK = 0.45
"""rad that a joint may turn from node to node where the course itself hardly turns."""
_HALF_TURN = 3.0
_WINDOW = np.radians(62.0)
"""The tool turns about its jet no more than this from node to node."""
_LEAN_S = 1.0
"""What a radian of lean costs for each node: more than anything but a collision."""


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """Samples of the course at which the robot's posture is chosen: n nodes."""

    sample: Indices
    """(n,) ascending"""
    until: Indices
    """(n,) the last sample that has this pose: a rest is one node."""
    azimuths: Indices
    """(n,) how many are tried about the jet."""


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """Poses that are asked for at nodes: k of them."""

    node: Indices
    azimuth: Scalars
    lean: NDArray[np.float64]
    """(k, 2) rad about the tool's x and y."""
    label: Indices
    """(k,) the same for the same azimuth and lean."""


def nodes_of(course: Course, dof: int) -> Nodes:
    """Choose the nodes of a course; five axes have more: they turn far for a jet that hardly does, in few states."""
    finer = 1.0 if dof >= 6 else 5.0
    places = course.T_base_tcp[:, :3, 3]
    angles = _turn_between(course.T_base_tcp)
    way = np.maximum(np.linalg.norm(np.diff(places, axis=0), axis=1) / NODE_M, angles / NODE_RAD)
    passed = np.floor(np.round(np.concatenate(([0.0], np.cumsum(finer * way))), 6))
    switched = np.diff(course.wet.astype(np.int8)) != 0
    chosen = np.concatenate(([True], np.diff(passed) > 0)) | course.changed | course.held
    chosen[1:] |= switched | course.held[:-1]
    chosen[:-1] |= switched | course.changed[1:]
    chosen[-1] = True
    begins = np.flatnonzero(chosen & ~np.concatenate(([False], course.held[:-1])))
    ends = np.maximum.accumulate(np.where(np.concatenate(([False], course.held[:-1])), np.arange(len(chosen)), 0))
    until = np.maximum(begins, ends[np.append(begins[1:] - 1, len(chosen) - 1)])
    until = np.where(course.held[begins], until, begins)
    free = _free_all_along(course, begins, until)
    tried = int(np.clip(_MOST_POSES // max(int(free.sum()), 1), _FEWEST_AZIMUTHS, AZIMUTHS))
    return Nodes(begins, until, np.where(free, tried, 1))


def _free_all_along(course: Course, begins: Indices, until: Indices) -> Flags:
    """Whether the azimuth is free at every sample of each node."""
    bound = np.concatenate(([0], np.cumsum(~course.free)))
    return bound[until + 1] == bound[begins]


def asked_at(nodes: Nodes, chosen: Indices, leans: NDArray[np.float64]) -> Asked:
    """Give every azimuth with every lean (l, 2), for the chosen nodes, in the nodes' order."""
    count = nodes.azimuths[chosen]
    node = np.repeat(chosen, count * len(leans))
    number = np.arange(len(node)) - np.repeat(np.cumsum(count * len(leans)) - count * len(leans), count * len(leans))
    azimuth = 2.0 * np.pi * (number // len(leans)) / nodes.azimuths[node]
    label = np.round(azimuth / (2.0 * np.pi) * AZIMUTHS).astype(np.int64) * 64 + number % len(leans)
    return Asked(node, azimuth, leans[number % len(leans)], label)


def leant(T_base_tcp: Poses, azimuth: Scalars, lean: NDArray[np.float64]) -> Poses:
    """Lean poses (k, 4, 4) about the orifice, then turn them about the jet."""
    from scipy.spatial.transform import Rotation

    tipped = Rotation.from_rotvec(np.column_stack((lean, np.zeros(len(lean)))))
    turned = tipped * Rotation.from_rotvec(azimuth[:, None] * np.array([0.0, 0.0, 1.0]))
    poses = T_base_tcp.copy()
    poses[:, :3, :3] = T_base_tcp[:, :3, :3] @ turned.as_matrix()
    return poses


@dataclass(frozen=True, slots=True, eq=False)
class States:
    """Layers, and what is known of their m states."""

    layers: Layers
    node: Indices
    """(m,) which layer it belongs to."""
    label: Indices
    """(m,) the same for states of different nodes that were asked for alike and have the same branch."""


def states_of(robot: Robot, course: Course, nodes: Nodes, asked: Asked, postures: Postures) -> States:
    """Solve what is asked at the nodes; give the states that keep the joints' limits.

    A node with no state has an empty layer.
    """
    sample = nodes.sample[asked.node]
    poses = leant(course.T_base_tcp[sample], asked.azimuth, asked.lean)
    q, off = solve_by_tool(poses, course.tool[sample], postures)
    kept = np.isfinite(q[..., 0])
    kept &= (nodes.azimuths[asked.node] > 1)[:, None] | (np.abs(off) < np.radians(0.5))
    row, branch = np.nonzero(kept)
    joints, inside = within_limits(robot, q[row, branch])
    row, branch, joints = row[inside], branch[inside], joints[inside]
    azimuth = asked.azimuth[row] + off[row, branch]
    node = asked.node[row]
    fresh = _distinct(node, joints) if robot.dof < 6 else np.arange(len(node))
    node, joints, azimuth, lean = node[fresh], joints[fresh], azimuth[fresh], asked.lean[row[fresh]]
    first = np.searchsorted(node, np.arange(len(nodes.sample) + 1))
    cost = state_costs(robot, joints) + _LEAN_S * np.linalg.norm(lean, axis=1)
    layers = Layers(first, np.ascontiguousarray(joints), azimuth, np.ascontiguousarray(lean), cost)
    return States(layers, node, (asked.label[row] * q.shape[1] + branch)[fresh])


def solve_by_tool(poses: Poses, tool: Indices, postures: Postures) -> tuple[Joints, Scalars]:
    """Solve poses (k, 4, 4) T_base_tcp, each for its own tool."""
    parts: list[tuple[Indices, Joints, Scalars]] = []
    for each in np.unique(tool).tolist():
        at = np.flatnonzero(tool == each)
        parts.append((at, *postures(poses[at], each)))
    branches = max((q.shape[1] for _, q, _ in parts), default=1)
    dof = parts[0][1].shape[2]
    joints, off = np.full((len(poses), branches, dof), np.nan), np.zeros((len(poses), branches))
    for at, q, azimuth in parts:
        joints[at, : q.shape[1]] = q
        off[at, : q.shape[1]] = azimuth
    return joints, off


def within_limits(robot: Robot, q: Joints) -> tuple[Joints, Flags]:
    """Shift turning joints (k, dof) by whole turns next to the middle of their limits; say which rows are inside."""
    low = np.array([joint.lowest for joint in robot.joints])
    high = np.array([joint.highest for joint in robot.joints])
    turning = np.array([joint.kind == "revolute" for joint in robot.joints])
    middle = np.array([_middle(joint) for joint in robot.joints])
    shifts = np.where(turning, np.round((q - middle) / (2.0 * np.pi) - 1e-12), 0.0)
    shifted = q - 2.0 * np.pi * shifts
    return shifted, np.asarray(((shifted >= low - 1e-9) & (shifted <= high + 1e-9)).all(axis=1))


def with_windings(robot: Robot, states: States, joints: Iterable[int]) -> tuple[States, Indices]:
    """Give states with every whole turn of some joints that their limits allow, and which state each was made of."""
    layers = states.layers
    q, parent = layers.q, np.arange(len(layers.q))
    for index in joints:
        joint = robot.joints[index]
        turns = np.arange(-_MOST_TURNS, _MOST_TURNS + 1)
        turned = q[:, index, None] + 2.0 * np.pi * turns
        row, column = np.nonzero((turned >= joint.lowest - 1e-9) & (turned <= joint.highest + 1e-9))
        q = q[row]
        q[:, index] = turned[row, column]
        parent = parent[row]
    node = states.node[parent]
    first = np.searchsorted(node, np.arange(len(layers.first)))
    made = Layers(first, q, layers.azimuth[parent], layers.lean[parent], layers.cost[parent])
    return States(made, node, states.label[parent]), parent


def state_costs(robot: Robot, joints: Joints) -> Scalars:
    """Seconds (m,) that states are as bad as: near a limit, near a singular posture."""
    middle = np.array([_middle(joint) for joint in robot.joints])
    half = np.array([joint.highest for joint in robot.joints]) - middle
    cost = _LIMIT_S * np.sum(((joints - middle) / half) ** 8, axis=1)
    if robot.dof < 6 or len(joints) == 0:
        return cost  # five axes have no posture in which a jet's direction is lost for good: steps tell it
    chain = chain_of(robot)
    w = manipulability(chain.steps, chain.turns, joints)
    share = w / max(float(w.max()), 1e-12)
    return cost + np.minimum(_SINGULAR_S * (0.1 / np.maximum(share, 1e-6)) ** 2, _MOST_SINGULAR_S)


def near_home(cell: Cell, states: States) -> States:
    """Let the first and the last node cost what the ways from and to home take."""
    layers = states.layers
    cost = layers.cost.copy()
    seconds = np.array([1.0 / joint.speed for joint in cell.robot.joints])
    for begin, end in ((0, layers.first[1]), (layers.first[-2], layers.first[-1])):
        cost[begin:end] += np.max(np.abs(layers.q[begin:end] - cell.home) * seconds, axis=1, initial=0.0)
    return replace(states, layers=layers._replace(cost=cost))


def steps_of(course: Course, nodes: Nodes, cell: Cell) -> Steps:
    """Say what lies between nodes that follow each other."""
    sample = nodes.sample
    lasting = course.times[sample[1:]] - course.times[nodes.until[:-1]]
    angle = _turn_between(course.T_base_tcp[sample])
    kind = np.full(len(lasting), FOLLOW, dtype=np.int64)
    kind[leap_places(course, nodes, cell.T_cell_base)] = MAY_LEAP
    kind[course.changed[sample[1:]]] = MUST_LEAP
    if cell.robot.dof >= 6:
        slack, turning = _SLACK + 1.5 * angle, np.full(len(angle), 1.5)
        return Steps(lasting, kind, slack, np.full(len(angle), _WINDOW), turning)
    # Five axes have to turn far where the jet is nearly along the first of them, and go over in both of their branches.
    return Steps(lasting, kind, np.full(len(angle), _HALF_TURN), np.full(len(angle), 4.0), np.zeros(len(angle)))


def leap_places(course: Course, nodes: Nodes, T_cell_base: Poses) -> Indices:
    """Intervals in which the configuration may change: the highest of each stretch with the jet off."""
    dry = ~course.wet[nodes.sample]
    up = T_cell_base[2, :3]
    height = np.round(course.T_base_tcp[nodes.sample, :3, 3] @ up, 6)
    between = dry[:-1] & dry[1:]
    edges = np.flatnonzero(np.diff(np.concatenate(([False], between, [False])).astype(np.int8)))
    stretches = zip(edges[0::2].tolist(), edges[1::2].tolist(), strict=True)
    return np.array([a + int(np.argmax(height[a:b])) for a, b in stretches], dtype=np.int64)


def paces_of(robot: Robot, wound: Iterable[int] = ()) -> Paces:
    """Say what the joints can do.

    Args:
        robot: Whose.
        wound: Joints whose states tell their whole turns: they go straight from one to the next.
    """
    turns = np.array([joint.kind == "revolute" for joint in robot.joints])
    span = np.array([joint.highest - joint.lowest for joint in robot.joints])
    wraps = turns & (span >= 2.0 * np.pi - 1e-6)
    wraps[list(wound)] = False
    return Paces(np.array([1.0 / joint.speed for joint in robot.joints]), wraps, turns)


def _middle(joint: Joint) -> float:
    """Middle of a joint's limits; 0 if it turns without end."""
    return 0.5 * (joint.lowest + joint.highest) if np.isfinite(joint.highest - joint.lowest) else 0.0


def _turn_between(poses: Poses) -> Scalars:
    turns = np.einsum("nji,njk->nik", poses[:-1, :3, :3], poses[1:, :3, :3])
    return np.arccos(np.clip(0.5 * (np.trace(turns, axis1=1, axis2=2) - 1.0), -1.0, 1.0))


def _distinct(node: Indices, joints: Joints) -> Indices:
    """Rows that are the first of their node with these joints: five axes give the same at many azimuths."""
    key = np.column_stack((node, np.round(joints * 1e6)))
    _, index = np.unique(key, axis=0, return_index=True)
    return np.sort(index)
