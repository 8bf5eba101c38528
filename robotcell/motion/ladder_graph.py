"""The ladder graph of a path: every IK branch at each node, at every azimuth and tilt that is allowed."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import Cell
from robotcell.kinematics.chain import chain_of, manipulability
from robotcell.kinematics.inverse import gantry_of
from robotcell.motion.cell_queries import CellQueries
from robotcell.motion.even_turns import NO_LINES, EvenLines
from robotcell.motion.ladder_search import FOLLOW, MAY_RECONFIGURE, MUST_RECONFIGURE, JointSpeeds, Ladder, Steps
from robotcell.motion.sampled_path import SampledPath, jet_turns, runs_of, turns_between
from robotcell.robot.robot import Joints, Poses, Robot, nearest_turns, row_pieces, rows_by

STRAIGHT = np.zeros((1, 2))
"""The tilt of a jet as it is programmed."""
NODE_M = 8e-3
NODE_RAD = np.radians(12.0)
"""Nodes are about this far apart, and at every rest, change of tool, and switch of the jet."""
_MOST_POSES = 1_200_000
"""Of six axes, in sum of all nodes: of a longer program fewer azimuths are tried, but not fewer than"""
_FEWEST_AZIMUTHS = 6
AZIMUTHS = 18
"""Tried about the jet where it is free."""
_NODES_AT_ONCE = 2048
"""Nodes whose poses are solved together: a pose takes a kilobyte or two while that lasts."""
_LIMIT_COST_S = 0.02
"""Cost of a joint at its limit for each node; half way to it next to nothing."""
_SINGULAR_COST_S = 1e-3
"""Cost of a configuration at a tenth of the greatest manipulability; four times as much at half of that."""
_MOST_SINGULAR_COST_S = 0.5
_MOST_TURNS = 3
_SLACK = 0.45
"""rad that a joint may turn from node to node where the path itself hardly turns."""
_HALF_TURN = 3.0
_WINDOW = np.radians(62.0)
"""The tool turns about its jet no more than this from node to node."""
_AZIMUTH_COST_S, _SPRAYING_AZIMUTH_COST_S = 0.02, 0.5
"""Cost of a radian about the jet while it is off, so that the tool does not turn for nothing, and while it is on: a
controller drives a line quicker on which the tool does not turn, and the jet is the same at every azimuth."""
_EVEN_AZIMUTH_COST_S = 0.1
"""The same where both axes go evenly on the spot: past the vertical, far from what is programmed, it is half a turn."""
_LEVEL_M = 1e-3
"""Heights that differ by less are one level."""
_TILT_COST_S = 1.0
"""Cost of a radian of tilt for each node: more than anything but a collision."""


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """Samples of the path at which the robot's configuration is chosen: n nodes."""

    sample: Indices
    """(n,) ascending"""
    until: Indices
    """(n,) the last sample that has this pose: a rest is one node."""
    azimuths: Indices
    """(n,) how many are tried about the jet."""


@dataclass(frozen=True, slots=True, eq=False)
class NodePoses:
    """Poses to be solved at nodes: k of them."""

    node: Indices
    azimuth: Scalars
    tilt: NDArray[np.float64]
    """(k, 2) rad about the tool's x and y."""
    label: Indices
    """(k,) the same for the same azimuth and tilt."""


def choose_nodes(
    path: SampledPath, dof: int, even: EvenLines = NO_LINES, loops: Sequence[tuple[int, int]] = ()
) -> Nodes:
    """Choose the nodes of a path; five axes have more: they turn far for a jet that hardly does, in few states.

    Lines along which the axes go evenly have nodes at their ends only. Samples at which a loop begins and ends are
    nodes, so that it can be closed there.
    """
    finer = 1.0 if dof >= 6 else 5.0
    places = path.T_base_tcp[:, :3, 3]
    angles = turns_between(path.T_base_tcp)
    way = np.maximum(np.linalg.norm(np.diff(places, axis=0), axis=1) / NODE_M, angles / NODE_RAD)
    passed = np.floor(np.round(np.concatenate(([0.0], np.cumsum(finer * way))), 6))
    switched = np.diff(path.jet_on.astype(np.int8)) != 0
    chosen = np.concatenate(([True], np.diff(passed) > 0)) | path.changed | path.dwelling
    chosen[1:] |= switched | path.dwelling[:-1]
    chosen[:-1] |= switched | path.changed[1:]
    chosen[-1] = True
    chosen[[at for loop in loops for at in loop]] = True
    chosen[even.inside(len(chosen))] = False
    chosen[even.first] = chosen[even.last] = True
    begins = np.flatnonzero(chosen & ~np.concatenate(([False], path.dwelling[:-1])))
    ends = np.maximum.accumulate(np.where(np.concatenate(([False], path.dwelling[:-1])), np.arange(len(chosen)), 0))
    until = np.maximum(begins, ends[np.append(begins[1:] - 1, len(chosen) - 1)])
    until = np.where(path.dwelling[begins], until, begins)
    bound = np.concatenate(([0], np.cumsum(~path.free)))
    free = bound[until + 1] == bound[begins]
    tried = AZIMUTHS  # five axes give the same joints at most azimuths: those take no memory
    if dof >= 6:
        tried = int(np.clip(_MOST_POSES // max(int(free.sum()), 1), _FEWEST_AZIMUTHS, AZIMUTHS))
    return Nodes(begins, until, np.where(free, tried, 1))


def node_poses(nodes: Nodes, chosen: Indices, tilts: NDArray[np.float64]) -> NodePoses:
    """Give every azimuth with every tilt (l, 2), for the chosen nodes, in the nodes' order."""
    count = nodes.azimuths[chosen]
    node = np.repeat(chosen, count * len(tilts))
    number = np.arange(len(node)) - np.repeat(np.cumsum(count * len(tilts)) - count * len(tilts), count * len(tilts))
    azimuth = 2.0 * np.pi * (number // len(tilts)) / nodes.azimuths[node]
    label = np.round(azimuth / (2.0 * np.pi) * AZIMUTHS).astype(np.int64) * 64 + number % len(tilts)
    return NodePoses(node, azimuth, tilts[number % len(tilts)], label)


def node_pieces(nodes: Nodes) -> Iterator[Indices]:
    """Give the nodes some at a time, in their order."""
    return (np.arange(rows.start, rows.stop) for rows in row_pieces(len(nodes.sample), _NODES_AT_ONCE))


def tilted(T_base_tcp: Poses, azimuth: Scalars, tilt: NDArray[np.float64]) -> Poses:
    """Tilt poses (k, 4, 4) about the orifice, then turn them about the jet."""
    from scipy.spatial.transform import Rotation

    poses = T_base_tcp.copy()
    leans = np.flatnonzero(tilt.any(axis=1))
    for rows in row_pieces(len(leans)):
        some = leans[rows]
        poses[some, :3, :3] @= Rotation.from_rotvec(np.pad(tilt[some], ((0, 0), (0, 1)))).as_matrix()
    c, s = np.cos(azimuth)[:, None], np.sin(azimuth)[:, None]
    x, y = poses[:, :3, 0], poses[:, :3, 1]
    poses[:, :3, 0], poses[:, :3, 1] = c * x + s * y, c * y - s * x
    return poses


def solve_states(queries: CellQueries, path: SampledPath, nodes: Nodes, requested: Iterable[NodePoses]) -> Ladder:
    """Solve the poses at the nodes; give the states within the joints' limits.

    A node with no state has an empty rung.

    Args:
        queries: To the cell.
        path: The path.
        nodes: All nodes of it.
        requested: The poses, some nodes at a time in their order: that bounds the memory.
    """
    parts = [_solve_some(queries, path, nodes, each) for each in requested]
    node, joints, azimuth, tilt, label = (np.concatenate(column) for column in zip(*parts, strict=True))
    first = np.searchsorted(node, np.arange(len(nodes.sample) + 1))
    cost = state_costs(queries.cell.robot, joints) + _TILT_COST_S * np.linalg.norm(tilt, axis=1)
    return Ladder(first, joints, azimuth, tilt, cost, node, label)


def _solve_some(
    queries: CellQueries, path: SampledPath, nodes: Nodes, requested: NodePoses
) -> tuple[Indices, Joints, Scalars, NDArray[np.float64], Indices]:
    """Give node, joints, azimuth, tilt and label of the states at some poses."""
    robot, sample = queries.cell.robot, nodes.sample[requested.node]
    poses = tilted(path.T_base_tcp[sample], requested.azimuth, requested.tilt)
    q, off = solve_by_tool(queries, poses, path.tool[sample])
    kept = np.isfinite(q[..., 0])
    kept &= (nodes.azimuths[requested.node] > 1)[:, None] | (np.abs(off) < np.radians(0.5))
    row, branch = np.nonzero(kept)
    joints = nearest_turns(robot, q[row, branch], robot.middle)
    inside = np.isfinite(joints[:, 0])
    row, branch, joints = row[inside], branch[inside], joints[inside]
    node, azimuth = requested.node[row], requested.azimuth[row] + off[row, branch]
    fresh = np.arange(len(node))
    if robot.dof < 6:  # five axes give the same joints at many azimuths
        rounded = np.column_stack((node, np.round(joints * 1e6)))
        fresh = np.sort(np.unique(rounded, axis=0, return_index=True)[1])
    label = (requested.label[row] * q.shape[1] + branch)[fresh]
    return node[fresh], joints[fresh], azimuth[fresh], requested.tilt[row[fresh]], label


def solve_by_tool(queries: CellQueries, poses: Poses, tool: Indices) -> tuple[Joints, Scalars]:
    """Solve poses (k, 4, 4) T_base_tcp, each for its own tool: (k, b, dof), NaN where none, and (k, b) azimuths off."""
    parts = [(at, *queries.configurations(poses[at], each)) for each, at in rows_by(tool)]
    branches = max((q.shape[1] for _, q, _ in parts), default=1)
    dof = parts[0][1].shape[2]
    joints, off = np.full((len(poses), branches, dof), np.nan), np.zeros((len(poses), branches))
    for at, q, azimuth in parts:
        joints[at, : q.shape[1]] = q
        off[at, : q.shape[1]] = azimuth
    return joints, off


def with_full_turns(robot: Robot, ladder: Ladder, joints: Iterable[int]) -> tuple[Ladder, Indices]:
    """Give states with every whole turn of some joints that their limits allow, and which state each was made of."""
    q, parent = ladder.q, np.arange(len(ladder.q))
    for index in joints:
        joint = robot.joints[index]
        turns = np.arange(-_MOST_TURNS, _MOST_TURNS + 1)
        turned = q[:, index, None] + 2.0 * np.pi * turns
        row, column = np.nonzero((turned >= joint.lowest - 1e-9) & (turned <= joint.highest + 1e-9))
        q = q[row]
        q[:, index] = turned[row, column]
        parent = parent[row]
    node, label, cost = ladder.node[parent], ladder.label[parent], ladder.cost[parent]
    first = np.searchsorted(node, np.arange(len(ladder.first)))
    return Ladder(first, q, ladder.azimuth[parent], ladder.tilt[parent], cost, node, label), parent


def state_costs(robot: Robot, joints: Joints) -> Scalars:
    """Give the costs (m,) of states near a limit or near a singular configuration, s."""
    middle = robot.middle
    cost = _LIMIT_COST_S * np.sum(((joints - middle) / (robot.highest - middle)) ** 8, axis=1)
    if robot.dof < 6 or len(joints) == 0:
        return cost  # five axes have no configuration in which a jet's direction is lost for good: steps show it
    chain = chain_of(robot)
    w = manipulability(chain.steps, chain.turns, joints)
    share = w / max(float(w.max()), 1e-12)
    return cost + np.minimum(_SINGULAR_COST_S * (0.1 / np.maximum(share, 1e-6)) ** 2, _MOST_SINGULAR_COST_S)


def with_home_costs(cell: Cell, ladder: Ladder) -> Ladder:
    """Add the time of the moves from and to home to the costs of the first and the last node."""
    cost, seconds = ladder.cost.copy(), 1.0 / cell.robot.speed
    for begin, end in ((0, ladder.first[1]), (ladder.first[-2], ladder.first[-1])):
        cost[begin:end] += np.max(np.abs(ladder.q[begin:end] - cell.home) * seconds, axis=1, initial=0.0)
    return ladder._replace(cost=cost)


def ladder_steps(
    path: SampledPath, nodes: Nodes, cell: Cell, even: EvenLines = NO_LINES, *, anywhere: bool = False
) -> Steps:
    """Give the intervals between nodes that follow each other.

    Args:
        path: The path.
        nodes: Its nodes.
        cell: Whose robot it is.
        even: Lines along which the axes go evenly.
        anywhere: Whether the configuration may change all along the highest part of a stretch with the jet off.
    """
    sample = nodes.sample
    lasting = path.times[sample[1:]] - path.times[nodes.until[:-1]]
    angle = turns_between(path.T_base_tcp[sample])
    kind = np.full(len(lasting), FOLLOW, dtype=np.int64)
    kind[reconfiguration_intervals(path, nodes, cell.T_cell_base, anywhere=anywhere)] = MAY_RECONFIGURE
    kind[path.changed[sample[1:]]] = MUST_RECONFIGURE
    count = len(angle)
    sprays = path.jet_on[nodes.until[:-1]] & path.jet_on[sample[1:]]
    azimuth = np.where(sprays, _SPRAYING_AZIMUTH_COST_S, _AZIMUTH_COST_S)
    if cell.robot.dof >= 6:
        slack, turning = _SLACK + 1.5 * angle, np.full(count, 1.5)
        return Steps(lasting, kind, slack, np.full(count, _WINDOW), turning, azimuth)
    slack, gantry = np.full(count, _HALF_TURN), gantry_of(cell.robot)
    if gantry is not None:
        # A joint may turn far where the jet is nearly along the first axis that turns: there both branches meet.
        # Elsewhere the one is not followed by the other.
        bent = np.concatenate(([0.0], np.cumsum(jet_turns(path.T_base_tcp))))
        bend = bent[sample[1:]] - bent[nodes.until[:-1]]
        lean = np.linalg.norm(np.cross(path.T_base_tcp[sample, :3, 2], gantry.zero.axes[3]), axis=1)
        least = np.maximum(np.minimum(lean[:-1], lean[1:]) - bend, 1e-3)
        slack = np.minimum(_SLACK + 2.0 * bend / least, _HALF_TURN)
    evenly = np.searchsorted(sample, even.last) - 1
    slack[evenly] = np.inf
    azimuth[evenly] = np.where(sprays[evenly], _EVEN_AZIMUTH_COST_S, _AZIMUTH_COST_S)
    return Steps(lasting, kind, slack, np.full(count, 4.0), np.zeros(count), azimuth)


def reconfiguration_intervals(
    path: SampledPath, nodes: Nodes, T_cell_base: Poses, *, anywhere: bool = False
) -> Indices:
    """Give the intervals in which the configuration may change: the highest of each stretch with the jet off.

    Of those that are as high the first, or ``anywhere`` all: on a level way between two regions that one configuration
    cannot do both, either may end or begin in the middle.
    """
    jet_off = ~path.jet_on[nodes.sample]
    up = T_cell_base[2, :3]
    height = np.round(path.T_base_tcp[nodes.sample, :3, 3] @ up, 6)
    found: list[int] = []
    for a, b in runs_of(jet_off[:-1] & jet_off[1:]):
        level = a + np.flatnonzero(height[a:b] >= height[a:b].max() - (_LEVEL_M if anywhere else 0.0))
        found += level.tolist() if anywhere else level[:1].tolist()
    return np.array(found, dtype=np.int64)


def joint_speeds(robot: Robot, multi_turn: Iterable[int] = ()) -> JointSpeeds:
    """Give the joints' greatest speeds and which of them turn.

    Args:
        robot: Whose.
        multi_turn: Joints whose whole turns are states of their own: they go straight from one to the next.
    """
    wraps = robot.turning & (robot.highest - robot.lowest >= 2.0 * np.pi - 1e-6)
    wraps[list(multi_turn)] = False
    return JointSpeeds(1.0 / robot.speed, wraps, robot.turning)
