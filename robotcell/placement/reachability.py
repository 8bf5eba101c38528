"""How well a robot reaches poses: by manipulability, condition, distance from limits, or clearance. Metres, radians."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import Cell
from robotcell.collision.clearance import clearance
from robotcell.collision.collision import Collider, collides
from robotcell.kinematics.chain import chain_of
from robotcell.kinematics.inverse import solve
from robotcell.kinematics.manipulability_batch import manipulability
from robotcell.motion.sampled_path import Flags
from robotcell.robot.conditioning import singularity
from robotcell.robot.full_turns import unwound
from robotcell.robot.poses import inverse, pose
from robotcell.robot.robot import Joints, Poses, Robot

Metric: TypeAlias = Literal["manipulability", "condition", "limits", "clearance"]
METRICS: tuple[Metric, ...] = ("manipulability", "condition", "limits", "clearance")

Ask: TypeAlias = Callable[[Indices, int], NDArray[np.float64]]

_OFF_AZIMUTH = np.radians(0.5)


@dataclass(frozen=True, slots=True, eq=False)
class Targets:
    """Poses that a tool is to reach: k of them, in the frame that a placement moves."""

    T_board_tcp: Poses
    """(k, 4, 4)"""
    tool: Indices
    """(k,) index into the cell's tools."""
    free: Flags
    """(k,) whether the azimuth about the jet is free."""


@dataclass(frozen=True, slots=True, eq=False)
class Postures:
    """Postures within the limits: m of them, of k targets."""

    target: Indices
    """(m,) ascending"""
    branch: Indices
    """(m,) configuration; the same number at different targets is the same configuration, for closed forms."""
    q: Joints
    """(m, dof) as near to home as whole turns allow."""


def postures_at(cell: Cell, T_cell_board: Poses, targets: Targets, azimuths: int = 12) -> Postures:
    """Give the postures that reach targets with the board at a place, at several azimuths where they are free.

    Args:
        cell: The cell; where its own board is does not matter.
        T_cell_board: (4, 4)
        targets: What is to be reached.
        azimuths: How many are tried about a free jet.
    """
    turns = np.stack([pose((0, 0, 0), (0, 0, 2.0 * np.pi * number / azimuths)) for number in range(azimuths)])
    T_base_tcp = inverse(cell.T_cell_base) @ T_cell_board @ targets.T_board_tcp
    found: list[Postures] = []
    for tool in np.unique(targets.tool).tolist():
        for free in (False, True):
            at = np.flatnonzero((targets.tool == tool) & (targets.free == free))
            if len(at):
                tried = turns if free else turns[:1]
                asked = (T_base_tcp[at, None] @ tried).reshape(-1, 4, 4)
                found.append(_solved(cell, asked, int(tool), np.repeat(at, len(tried)), free=free))
    order = np.argsort(np.concatenate([part.target for part in found]), kind="stable")
    return Postures(*(np.concatenate([getattr(part, name) for part in found])[order] for name in Postures.__slots__))


def _solved(cell: Cell, asked: Poses, tool: int, target: Indices, *, free: bool) -> Postures:
    T_flange_tcp = cell.tools[tool].T_flange_tcp
    solved = solve(cell.robot, asked @ inverse(T_flange_tcp), T_flange_tcp=T_flange_tcp)
    q = unwound(cell.robot, solved.q, cell.home)
    good = np.isfinite(q[..., 0]) & (free | (np.abs(solved.azimuth) < _OFF_AZIMUTH))
    row, branch = np.nonzero(good)
    return Postures(target[row], branch, q[row, branch])


def clear_of(cell: Cell, collider: Collider, targets: Targets, postures: Postures) -> Postures:
    """Leave out the postures that collide."""
    hits = np.zeros(len(postures.q), dtype=np.bool_)
    tool = targets.tool[postures.target]
    for each in np.unique(tool).tolist():
        hits[tool == each] = collides(collider, postures.q[tool == each], cell.tools[each].number)
    kept = ~hits
    return Postures(postures.target[kept], postures.branch[kept], postures.q[kept])


def measure(cell: Cell, q: Joints, tool: Indices, metric: Metric, collider: Collider | None = None) -> Scalars:
    """Measure postures (m, dof): the greater the better.

    Args:
        cell: The cell.
        q: The postures.
        tool: (m,) index into the cell's tools.
        metric: ``manipulability`` |det J| (m, rad); ``condition`` the inverse condition, 0 to 1; ``limits`` how far the
            nearest joint is from its limit, 0 at the limit to 1 in the middle; ``clearance`` the distance to board and
            fixtures, m.
        collider: Needed for the clearance.

    Raises:
        ValueError: The clearance is asked for without a collider.
    """
    match metric:
        case "manipulability":
            return _manipulability(cell.robot, q)
        case "condition":
            return _by_tool(tool, lambda at, each: singularity(cell.robot, q[at], cell.tools[each].T_flange_tcp)[1])
        case "limits":
            return limit_share(cell.robot, q)
        case "clearance":
            if collider is None:
                raise ValueError("distances are measured by a collider")
            return _by_tool(tool, lambda at, each: clearance(collider, q[at], cell.tools[each].number).distances)


def limit_share(robot: Robot, q: Joints) -> Scalars:
    """How far (m,) the nearest joint is from its nearer limit: 0 at the limit, 1 in the middle of the range."""
    low = np.array([joint.lowest for joint in robot.joints])
    high = np.array([joint.highest for joint in robot.joints])
    bounded = np.isfinite(low) & np.isfinite(high)
    if not bounded.any():
        return np.ones(len(q))
    near = np.minimum(q - low, high - q)[:, bounded] / (0.5 * (high - low)[bounded])
    return np.clip(near.min(axis=1), 0.0, 1.0)


def best_of(values: Scalars, target: Indices, count: int) -> Scalars:
    """Give the greatest value (count,) of each target; minus infinity where it has none."""
    best = np.full(count, -np.inf)
    np.maximum.at(best, target, values)
    return best


def reach_map(
    cell: Cell, targets: Targets, metric: Metric, collider: Collider | None = None, azimuths: int = 12
) -> Scalars:
    """Give how well each target (k,) is reached at best, where the board is held; minus infinity where it is not.

    Args:
        cell: The cell.
        targets: What is to be reached.
        metric: See ``measure``.
        collider: If given, postures that collide do not count.
        azimuths: How many are tried about a free jet.
    """
    found = postures_at(cell, cell.T_cell_board, targets, azimuths)
    if collider is not None:
        found = clear_of(cell, collider, targets, found)
    values = measure(cell, found.q, targets.tool[found.target], metric, collider)
    return best_of(values, found.target, len(targets.tool))


def _manipulability(robot: Robot, q: Joints) -> Scalars:
    if robot.dof != 6:
        return singularity(robot, q)[0]
    chain = chain_of(robot)
    return manipulability(chain.steps, chain.turns, np.ascontiguousarray(q))


def _by_tool(tool: Indices, ask: Ask) -> Scalars:
    values = np.zeros(len(tool))
    for each in np.unique(tool).tolist():
        at = np.flatnonzero(tool == each)
        values[at] = ask(at, int(each))
    return values
