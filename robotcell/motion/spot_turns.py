"""Turns on the spot of a gantry that tilts its jet: over the vertical, so that the first turning axis does not wind up.

Laps around a part turn a tilted jet a quarter at each corner, always the same way, and so its first turning axis C.
Over the vertical the jet goes to the same direction with the other tilt, and C turns a quarter or so back.
"""

import numpy as np

from geometry.arrays import Indices
from robotcell.kinematics.chain import zero_of
from robotcell.kinematics.gantry import recognise_gantry
from robotcell.motion.cell_queries import CellQueries
from robotcell.motion.ladder_graph import AZIMUTHS, NodePoses, Nodes
from robotcell.motion.sampled_path import SampledPath, find_spot_turns
from robotcell.robot.robot import Poses

_LABEL = AZIMUTHS * 64 + 1
"""Of the first of these poses: no others have it."""


def over_vertical(queries: CellQueries, path: SampledPath, nodes: Nodes) -> NodePoses:
    """Give poses with the jet along the first turning axis, at both inner nodes of each turn on the spot that is free.

    At each there are two azimuths: those with which the turn begins and ends, tilted straight.
    """
    robot = queries.cell.robot
    rows: list[tuple[int, float, float, float, int]] = []
    if robot.dof == 5 and (gantry := recognise_gantry(zero_of(robot))) is not None:
        for begin, end in find_spot_turns(path):
            first, last = int(np.searchsorted(nodes.until, begin)), int(np.searchsorted(nodes.sample, end))
            if not path.free[begin : end + 1].all():
                continue
            goals = [
                pose
                for at in (begin, end)
                for pose in _upright(path.T_base_tcp[at], gantry.zero.axes[3], queries, int(path.tool[at]))
            ]
            for node in range(first + 1, last):
                here = path.T_base_tcp[nodes.sample[node], :3, :3]
                rows += [(node, *_apart(here, goal), _LABEL + number) for number, goal in enumerate(goals)]
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    return NodePoses(table[:, 0].astype(np.int64), table[:, 1], table[:, 2:4], table[:, 4].astype(np.int64))


def with_poses(some: NodePoses, more: NodePoses, chosen: Indices) -> NodePoses:
    """Give poses together with those others that belong to chosen nodes, in the nodes' order."""
    own = np.isin(more.node, chosen)
    parts = [(some, slice(None)), (more, own)]
    order = np.argsort(np.concatenate([part.node[rows] for part, rows in parts]), kind="stable")
    fields = (np.concatenate([getattr(part, name)[rows] for part, rows in parts]) for name in NodePoses.__slots__)
    return NodePoses(*(field[order] for field in fields))


def _upright(pose: Poses, axis: Poses, queries: CellQueries, tool: int) -> list[Poses]:
    """Give the rotation (3, 3) in which the jet was tilted straight along the axis, as the robot holds the tool."""
    from scipy.spatial.transform import Rotation

    q, off = queries.configurations(pose[None], tool)
    known = np.isfinite(q[0, :, 0])
    jet = pose[:3, 2]
    along = axis if axis @ jet > 0.0 else -axis
    across = np.cross(jet, along)
    sine = float(np.linalg.norm(across))
    if sine < 1e-6 or not known.any():
        return []
    angle = np.arctan2(sine, float(jet @ along))
    tipped = Rotation.from_rotvec(across / sine * angle).as_matrix() @ pose[:3, :3]
    return [tipped @ Rotation.from_rotvec([0.0, 0.0, float(off[0, known][0])]).as_matrix()]


def _apart(here: Poses, goal: Poses) -> tuple[float, float, float]:
    """Give the azimuth and the tilt, two components, that lead from one rotation (3, 3) to another."""
    from scipy.spatial.transform import Rotation

    turn = here.T @ goal
    z = turn[:, 2]
    sine = float(np.hypot(z[0], z[1]))
    angle = np.arctan2(sine, z[2])
    tilt = np.array([-z[1], z[0]]) * (angle / sine if sine > 1e-12 else 0.0)
    left = Rotation.from_rotvec([tilt[0], tilt[1], 0.0]).as_matrix().T @ turn
    return float(np.arctan2(left[1, 0], left[0, 0])), float(tilt[0]), float(tilt[1])
