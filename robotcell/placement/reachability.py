"""Configurations that reach poses, and their quality: manipulability, condition, distance from limits, clearance."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import Cell
from robotcell.collision.clearance import clearance
from robotcell.collision.collision import Collider, collides
from robotcell.kinematics.chain import chain_of, manipulability
from robotcell.kinematics.inverse import solve
from robotcell.motion.sampled_path import Flags
from robotcell.robot.full_turns import nearest_turns
from robotcell.robot.poses import inverse, pose
from robotcell.robot.robot import Joints, Poses, limit_share, singularity

Metric: TypeAlias = Literal["manipulability", "condition", "limits", "clearance"]

_OFF_AZIMUTH = np.radians(0.5)


@dataclass(frozen=True, slots=True, eq=False)
class Targets:
    """Poses that a tool is to reach: k of them, in the board's frame."""

    T_board_tcp: Poses
    """(k, 4, 4)"""
    tool: Indices
    """(k,) index into the cell's tools."""
    free: Flags
    """(k,) whether the azimuth about the jet is free."""
    weight: Scalars = field(default_factory=lambda: np.ones(1))
    """(k,) how much each counts in a mean and a percentile; (1,) where all count alike."""
    stroke: Indices = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    """(k,) targets of the same number are passed in one configuration; (0,) where each is for itself."""

    @property
    def weights(self) -> Scalars:
        """(k,) of each."""
        return np.broadcast_to(self.weight, (len(self.tool),))

    @property
    def strokes(self) -> Indices:
        """(k,) of each."""
        return self.stroke if len(self.stroke) else np.arange(len(self.tool))

    def taken(self, at: Indices) -> "Targets":
        """Give some of them."""
        return Targets(self.T_board_tcp[at], self.tool[at], self.free[at], self.weights[at], self.strokes[at])


@dataclass(frozen=True, slots=True, eq=False)
class Configurations:
    """Configurations within the limits: m of them, of k targets."""

    target: Indices
    """(m,) ascending"""
    branch: Indices
    """(m,) IK branch; of closed forms the same number at different targets is the same branch."""
    q: Joints
    """(m, dof) as near to home as whole turns allow."""


def configurations_at(cell: Cell, T_cell_board: Poses, targets: Targets, azimuths: int) -> Configurations:
    """Give the configurations that reach targets with the board at a pose, at several azimuths where they are free.

    Args:
        cell: The cell; the pose of its own board does not matter.
        T_cell_board: (4, 4)
        targets: What is to be reached; at least one.
        azimuths: How many are tried about a free jet.
    """
    turns = np.stack([pose((0, 0, 0), (0, 0, 2.0 * np.pi * number / azimuths)) for number in range(azimuths)])
    T_base_tcp = inverse(cell.T_cell_base) @ T_cell_board @ targets.T_board_tcp
    found: list[Configurations] = []
    for tool in np.unique(targets.tool).tolist():
        T_flange_tcp = cell.tools[tool].T_flange_tcp
        for free in (False, True):
            at = np.flatnonzero((targets.tool == tool) & (targets.free == free))
            if not len(at):
                continue
            tried = turns if free else turns[:1]
            poses = (T_base_tcp[at, None] @ tried).reshape(-1, 4, 4)
            solved = solve(cell.robot, poses @ inverse(T_flange_tcp), T_flange_tcp=T_flange_tcp)
            q = nearest_turns(cell.robot, solved.q, cell.home)
            row, branch = np.nonzero(np.isfinite(q[..., 0]) & (free | (np.abs(solved.azimuth) < _OFF_AZIMUTH)))
            found.append(Configurations(np.repeat(at, len(tried))[row], branch, q[row, branch]))
    order = np.argsort(np.concatenate([part.target for part in found]), kind="stable")
    fields = (np.concatenate([getattr(part, name) for part in found]) for name in Configurations.__slots__)
    return Configurations(*(field[order] for field in fields))


def spread(points: NDArray[np.float64], most: int) -> Indices:
    """Choose points (n, k) one after the other: the farthest from the middle, then the farthest from all before."""
    apart = np.linalg.norm(points - points.mean(axis=0), axis=1)
    chosen: list[int] = []
    nearest = np.full(len(points), np.inf)
    while len(chosen) < most and nearest.max() > 1e-6:
        # Rounded, so that among equals the first in the program is taken wherever the board lies.
        chosen.append(int(np.argmax(np.round(apart, 7))))
        nearest = np.minimum(nearest, np.linalg.norm(points - points[chosen[-1]], axis=1))
        apart = nearest
    return np.array(chosen, dtype=np.int64)


def thinned(targets: Targets, most: int, lever: float = 0.1) -> Targets:
    """Choose targets of each tool as far from one another as there are; each counts for those that it is nearest to.

    Directions of the jet, and azimuths that are not free, are compared with positions by a lever, m.
    """
    if len(targets.tool) <= most:
        return targets
    at = chosen_rows(targets, most, lever)
    points = _points(targets, lever)
    owner = np.empty(len(targets.tool), dtype=np.int64)
    for tool in np.unique(targets.tool).tolist():
        mine, kept = np.flatnonzero(targets.tool == tool), np.flatnonzero(targets.tool[at] == tool)
        owner[mine] = kept[KDTree(points[at[kept]]).query(points[mine])[1]]
    weight = np.bincount(owner, weights=targets.weights, minlength=len(at)).astype(np.float64)
    return replace(targets.taken(at), weight=weight)


def chosen_rows(targets: Targets, most: int, lever: float) -> Indices:
    """Choose which of the targets are farthest from one another, as many of each tool; ascending."""
    points, used = _points(targets, lever), np.unique(targets.tool).tolist()
    each = max(most // len(used), 1)
    rows = (np.flatnonzero(targets.tool == tool) for tool in used)
    return np.sort(np.concatenate([mine[spread(points[mine], each)] for mine in rows]))


def _points(targets: Targets, lever: float) -> NDArray[np.float64]:
    """(k, 9) positions, directions and azimuths in one space, m."""
    azimuth = np.where(targets.free[:, None], 0.0, targets.T_board_tcp[:, :3, 0])
    place, jet = targets.T_board_tcp[:, :3, 3], targets.T_board_tcp[:, :3, 2]
    return np.hstack((place, lever * jet, lever * azimuth))


def clear_of(cell: Cell, collider: Collider, targets: Targets, found: Configurations) -> Configurations:
    """Leave out the configurations that collide."""
    hits = np.zeros(len(found.q), dtype=np.bool_)
    tool = targets.tool[found.target]
    for each in np.unique(tool).tolist():
        hits[tool == each] = collides(collider, found.q[tool == each], cell.tools[each].number)
    return Configurations(found.target[~hits], found.branch[~hits], found.q[~hits])


def measure(cell: Cell, q: Joints, tool: Indices, metric: Metric, collider: Collider | None = None) -> Scalars:
    """Measure configurations (m, dof): the greater the better.

    Args:
        cell: The cell.
        q: The configurations.
        tool: (m,) index into the cell's tools.
        metric: ``manipulability`` |det J| (m, rad); ``condition`` the inverse condition, 0 to 1; ``limits`` how far the
            nearest joint is from its limit, 0 at the limit to 1 in the middle; ``clearance`` the distance to board and
            fixtures, m.
        collider: Needed for the clearance.

    Raises:
        ValueError: The clearance is to be measured without a collider.
    """
    match metric:
        case "manipulability" if cell.robot.dof != 6:
            return singularity(cell.robot, q)[0]
        case "manipulability":
            chain = chain_of(cell.robot)
            return manipulability(chain.steps, chain.turns, np.ascontiguousarray(q))
        case "condition":
            return _by_tool(tool, lambda at, each: singularity(cell.robot, q[at], cell.tools[each].T_flange_tcp)[1])
        case "limits":
            return limit_share(cell.robot, q)
        case "clearance":
            if collider is None:
                raise ValueError("distances are measured by a collider")
            return _by_tool(tool, lambda at, each: clearance(collider, q[at], cell.tools[each].number).distances)


def _by_tool(tool: Indices, measured: Callable[[Indices, int], NDArray[np.float64]]) -> Scalars:
    values = np.zeros(len(tool))
    for each in np.unique(tool).tolist():
        at = np.flatnonzero(tool == each)
        values[at] = measured(at, int(each))
    return values
