"""Targets, the configurations that reach them, and their quality: manipulability, condition, limits, clearance."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from boards.board import Part
from boards.part.cells import served_cells
from geometry.arrays import Directions, Indices, Points, Scalars
from robotcell.cell.cell import Cell
from robotcell.collision.clearance import clearance
from robotcell.collision.collision import Collider, collides
from robotcell.kinematics.chain import chain_of, manipulability
from robotcell.kinematics.inverse import solve
from robotcell.motion.sampled_path import Flags, SampledPath
from robotcell.robot.robot import (
    Joints,
    Poses,
    flange_manipulability,
    inverse,
    limit_share,
    nearest_turns,
    pose,
    rows_by,
    singularity,
)

Metric: TypeAlias = Literal["manipulability", "condition", "limits", "clearance"]

_OFF_AZIMUTH = np.radians(0.5)
_LEVER = 0.1
"""m by which directions of the jet are compared with positions."""


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

    @property
    def middle(self) -> Scalars:
        """(4,) the mean of the places, and 1: to be multiplied by poses."""
        return np.append(self.T_board_tcp[:, :3, 3].mean(axis=0), 1.0)

    @property
    def columns(self) -> tuple[NDArray[Any], ...]:
        """What there is of each target, in the order of the fields."""
        return self.T_board_tcp, self.tool, self.free, self.weights, self.strokes

    def taken(self, at: Indices) -> "Targets":
        """Give some of them."""
        return Targets(*(column[at] for column in self.columns))

    def joined(self, others: "Targets") -> "Targets":
        """Give them, and others after them."""
        return Targets(*(np.concatenate(pair) for pair in zip(self.columns, others.columns, strict=True)))


class Configurations(NamedTuple):
    """Configurations within the limits: m of them, of k targets."""

    target: Indices
    """(m,) ascending"""
    branch: Indices
    """(m,) IK branch; of closed forms the same number at different targets is the same branch."""
    q: Joints
    """(m, dof) as near to home as whole turns allow."""

    @classmethod
    def joined(cls, parts: Sequence["Configurations"]) -> "Configurations":
        """Put some together, at least one."""
        return cls(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def taken(self, which: Indices | Flags) -> "Configurations":
        """Give some of them."""
        return Configurations._make(column[which] for column in self)


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
    for tool, rows in rows_by(targets.tool):
        T_flange_tcp = cell.tools[tool].T_flange_tcp
        for free in np.unique(targets.free[rows]).tolist():
            at, tried = rows[targets.free[rows] == free], turns if free else turns[:1]
            poses = (T_base_tcp[at, None] @ tried).reshape(-1, 4, 4)
            solved = solve(cell.robot, poses @ inverse(T_flange_tcp), T_flange_tcp=T_flange_tcp)
            q = nearest_turns(cell.robot, solved.q, cell.home)
            row, branch = np.nonzero(np.isfinite(q[..., 0]) & (free | (np.abs(solved.azimuth) < _OFF_AZIMUTH)))
            found.append(Configurations(np.repeat(at, len(tried))[row], branch, q[row, branch]))
    whole = Configurations.joined(found)
    return whole.taken(np.argsort(whole.target, kind="stable"))


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


def spread_samples(path: SampledPath, samples: Indices, most: int) -> Indices:
    """Choose among samples (k,), the outermost first, poses that are far from one another: indices into them."""
    poses = path.T_base_tcp[samples]
    apart = np.column_stack((path.tool[samples], path.placement[samples])).astype(np.float64)
    return spread(np.hstack((poses[:, :3, 3], _LEVER * poses[:, :3, 2], apart)), most)


def thinned(targets: Targets, most: int) -> Targets:
    """Choose targets of each tool as far from one another as there are; each counts for those that it is nearest to.

    Directions of the jet, and azimuths that are not free, are compared with positions.
    """
    if len(targets.tool) <= most:
        return targets
    azimuth = np.where(targets.free[:, None], 0.0, targets.T_board_tcp[:, :3, 0])
    place, jet = targets.T_board_tcp[:, :3, 3], targets.T_board_tcp[:, :3, 2]
    points = np.hstack((place, _LEVER * jet, _LEVER * azimuth))
    rows = list(rows_by(targets.tool))
    each = max(most // len(rows), 1)
    at = np.sort(np.concatenate([mine[spread(points[mine], each)] for _, mine in rows]))
    owner = np.empty(len(targets.tool), dtype=np.int64)
    for tool, mine in rows:
        kept = np.flatnonzero(targets.tool[at] == tool)
        owner[mine] = kept[KDTree(points[at[kept]]).query(points[mine])[1]]
    weight = np.bincount(owner, weights=targets.weights, minlength=len(at)).astype(np.float64)
    return replace(targets.taken(at), weight=weight)


def hits_of(cell: Cell, collider: Collider | None, q: Joints, tool: Indices) -> Flags:
    """Give (m,) which configurations (m, dof) collide, each with the tool of an index into the cell's."""
    hits = np.zeros(len(q), dtype=np.bool_)
    if collider is not None:
        for index, at in rows_by(tool):
            hits[at] = collides(collider, q[at], cell.tools[index].number)
    return hits


def clear_of(cell: Cell, collider: Collider, targets: Targets, found: Configurations) -> Configurations:
    """Leave out the configurations that collide."""
    return found.taken(~hits_of(cell, collider, found.q, targets.tool[found.target]))


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
            return flange_manipulability(cell.robot, q)
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
    for index, at in rows_by(tool):
        values[at] = measured(at, index)
    return values


_MM = 1e-3
_UPRIGHT = 1e-6


def surface_targets(part: Part, standoff_mm: float, most: int, tool: int = 0) -> Targets:
    """Choose targets on the faces of a part that are sprayed, farthest first; each counts for the area around it.

    Args:
        part: The part.
        standoff_mm: From the surface to the orifice, along the normal.
        most: How many targets at most.
        tool: Index into the cell's tools.

    Returns:
        Targets in the part's frame, m; the azimuth about the jet is free.
    """
    cells = served_cells(part).cells
    points, normals = cells.points * _MM, cells.normals
    poses = jet_frames(points + standoff_mm * _MM * normals, normals)
    every = Targets(poses, np.full(len(points), tool), np.ones(len(points), dtype=np.bool_), cells.areas_mm2)
    return thinned(every, most)


def jet_frames(points: Points, normals: Directions) -> Poses:
    """Give frames (n, 4, 4) at points whose +Z is opposite to normals, +X the tangent n x z of Maribor's section 3.1.

    Where the normal is upright that product vanishes; the tangent is the frame's own x then.
    """
    tangent = np.cross(normals, np.array([0.0, 0.0, 1.0]))
    length = np.linalg.norm(tangent, axis=1, keepdims=True)
    flat = length[:, 0] < _UPRIGHT
    tangent = np.where(flat[:, None], np.array([1.0, 0.0, 0.0]), tangent / np.where(flat[:, None], 1.0, length))
    frames = np.tile(np.eye(4), (len(points), 1, 1))
    frames[:, :3, 0], frames[:, :3, 2] = tangent, -normals
    frames[:, :3, 1] = np.cross(-normals, tangent)
    frames[:, :3, 3] = points
    return frames
