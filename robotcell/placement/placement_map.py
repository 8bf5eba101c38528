"""The map of placements over a table: x, y and yaw, as figure 5 of the Maribor paper has it. Metres, radians."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from robotcell.cell.cell import Cell, HasRoom, TableBounds, longest_reach
from robotcell.placement.evaluate import NO_ROOM, PlacementTask, Score, azimuths_of, evaluate, evaluate_many, score
from robotcell.placement.optimise import Placement, find_placements, judge_placement
from robotcell.placement.reachability import thinned
from robotcell.robot.robot import Poses, pose
from specs.progress import Progress, no_progress

_MOST_POSES, _LEAST_TARGETS = 48, 12
_SIFTED_TARGETS = 12
"""With which bodies are checked at the best nodes, until so many are feasible; these are evaluated with all targets."""
_MOST_SIFTED, _CONFIRMED = 400, 24


@dataclass(frozen=True, slots=True)
class MapGrid:
    """Where a map is, and how fine."""

    bounds: TableBounds
    counts: tuple[int, int, int] = (40, 40, 12)
    """Nodes along x, y and yaw."""
    through: Poses | None = None
    """T_cell_board (4, 4) of a place: the grid is shifted by up to half a spacing each way, so that a node is there;
    not for a place beyond the grid."""


@dataclass(frozen=True, slots=True, eq=False)
class PlacementMap:
    """Values of placements on a grid, at the height at which the cell holds the board."""

    x: Scalars
    """(nx,) of the middle of the targets, cell frame, m."""
    y: Scalars
    """(ny,)"""
    yaw: Scalars
    """(nw,) rad, about the cell's z, from how the board lies."""
    values: NDArray[np.float64]
    """(nx, ny, nw) as ``Score.value``, of some of the targets and without the bodies (but for clearance): a bound."""
    best: tuple[int, int, int]
    """The node that is best with all targets, and with the bodies."""
    score: Score
    """Of that node."""
    T_cell_board: Poses
    """Of that node."""
    refined: Placement | None = None
    """The best place within half a spacing of that node, by ``refine_map``; ``None`` where no node is feasible."""
    refined_at: tuple[float, float, float] | None = None
    """x, y and yaw of that place, as of a node."""

    @property
    def nodes(self) -> NDArray[np.float64]:
        """(nx, ny) the mean over the yaws that are feasible, eq. (6) of the paper; NaN where none is."""
        feasible = self.values >= 0.0
        count = feasible.sum(axis=2)
        total = np.where(feasible, self.values, 0.0).sum(axis=2)
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)

    @property
    def highest(self) -> NDArray[np.float64]:
        """(nx, ny) the greatest over the yaws; NaN where none is feasible."""
        most = self.values.max(axis=2)
        return np.where(most >= 0.0, most, np.nan)


def map_placements(
    task: PlacementTask, grid: MapGrid, has_room: HasRoom | None = None, progress: Progress = no_progress
) -> PlacementMap:
    """Evaluate placements on a grid over the table.

    The nodes are evaluated with some of the targets and without the bodies; the best of them with a few targets and the
    bodies, and the best of these with all.

    Args:
        task: What is placed.
        grid: Where, and how many nodes.
        has_room: Whether the board has room at a T_cell_board (4, 4); everywhere if left out.
        progress: Receives the stage and the share done.
    """
    most = max(_MOST_POSES // azimuths_of(task), _LEAST_TARGETS)
    few = replace(task, targets=thinned(task.targets, most))
    (x, y, yaw), through = _axes(task, grid)
    values = np.full(grid.counts, NO_ROOM)
    for i, column in enumerate(x.tolist()):
        progress("mapping placements", 0.5 * i / grid.counts[0])
        placed = np.stack([_placed(task, (column, *node)) for node in product(y, yaw)])
        roomy = np.array([has_room is None or has_room(each) for each in placed])
        if roomy.any():
            values[i].reshape(-1)[roomy] = evaluate_many(few, placed[roomy])
    sifted = replace(task, targets=thinned(task.targets, _SIFTED_TARGETS))
    order = np.argsort(-np.round(values.ravel(), 9), kind="stable")[:_MOST_SIFTED]
    nodes: list[tuple[float, tuple[int, int, int]]] = []
    for number, node in enumerate(order.tolist()):
        progress("checking bodies on the map", 0.5 + 0.4 * number / len(order))
        i, j, k = (int(each) for each in np.unravel_index(node, grid.counts))
        T_cell_board = _placed(task, (x[i], y[j], yaw[k]))
        bound = values[i, j, k] if task.collider is None else score(sifted, evaluate(sifted, T_cell_board)).value
        nodes.append((round(bound, 9), (i, j, k)))
        if sum(value >= 0.0 for value, _ in nodes) == _CONFIRMED:
            break
    nodes.sort(key=lambda each: -each[0])
    best, at = Score(-np.inf), (0, 0, 0)
    confirmed = [] if through is None else [through]
    confirmed += [node for _, node in nodes[:_CONFIRMED] if node != through]
    for i, j, k in confirmed:
        scored = score(task, evaluate(task, _placed(task, (x[i], y[j], yaw[k]))))
        if scored.value > best.value:
            best, at = scored, (i, j, k)
    progress("placements mapped", 1.0)
    return PlacementMap(x, y, yaw, values, at, best, _placed(task, (x[at[0]], y[at[1]], yaw[at[2]])))


def refine_map(
    task: PlacementTask, mapped: PlacementMap, has_room: HasRoom | None = None, progress: Progress = no_progress
) -> PlacementMap:
    """Search within half a spacing of a map's best node: peaks of the least value, or a percentile, lie between nodes.

    Args:
        task: As for ``map_placements``.
        mapped: The map.
        has_room: As for ``map_placements``.
        progress: Receives the stage and the share done.
    """
    if mapped.score.value < 0.0:
        return mapped
    there = replace(task.cell, T_cell_board=mapped.T_cell_board)
    node = judge_placement(there, task.targets, task.goal, task.collider)
    half = 0.5 * max(float(np.ptp(each)) / max(len(each) - 1, 1) for each in (mapped.x, mapped.y))
    around, turned = half / max(node.distance, half), np.pi / len(mapped.yaw)
    near = replace(
        task.goal,
        distance=(max(node.distance - half, 0.0), node.distance + half),
        height=(0.0, 0.0),
        yaw=(-turned, turned),
        direction=(-around, around),
    )
    found = find_placements(there, task.targets, near, task.collider, has_room=has_room, progress=progress)[0]
    refined = found if found.value > node.value else node
    x, y, turned = _node_at(task, refined.T_cell_board, mapped.T_cell_board)
    return replace(mapped, refined=refined, refined_at=(x, y, float(mapped.yaw[mapped.best[2]]) + turned))


def _node_at(task: PlacementTask, T_cell_board: Poses, T_cell_before: Poses) -> tuple[float, float, float]:
    """Give x and y of a place, and by which yaw it is turned about the cell's z from another."""
    x, y = (T_cell_board @ task.targets.middle)[:2].tolist()
    turn = T_cell_board[:3, :3] @ T_cell_before[:3, :3].T
    return x, y, float(np.arctan2(turn[1, 0], turn[0, 0]))


def _axes(task: PlacementTask, grid: MapGrid) -> tuple[tuple[Scalars, Scalars, Scalars], tuple[int, int, int] | None]:
    """Give x, y and yaw of the nodes, and the node at the place that the grid goes through."""
    x, y = (np.linspace(*span, count) for span, count in zip(grid.bounds, grid.counts[:2], strict=True))
    yaw = -np.pi + 2.0 * np.pi * np.arange(grid.counts[2]) / grid.counts[2]
    if grid.through is None:
        return (x, y, yaw), None
    *at, turned = _node_at(task, grid.through, task.cell.T_cell_board)
    at.append(np.mod(turned - yaw[0], 2.0 * np.pi) + yaw[0])
    nearest = [int(np.argmin(np.abs(axis - value))) for axis, value in zip((x, y, yaw), at, strict=True)]
    shifts = [value - axis[node] for axis, value, node in zip((x, y, yaw), at, nearest, strict=True)]
    halves = [0.5 * np.ptp(axis) / max(len(axis) - 1, 1) for axis in (x, y)]
    if any(abs(shift) > half + 1e-9 for shift, half in zip(shifts, halves, strict=False)):
        return (x, y, yaw), None  # it lies beyond the grid
    return (x + shifts[0], y + shifts[1], yaw + shifts[2]), (nearest[0], nearest[1], nearest[2])


def reach_bounds(cell: Cell) -> TableBounds:
    """Give the square around the base that the robot may reach at all."""
    base, far = cell.T_cell_base[:2, 3], longest_reach(cell)
    return TableBounds((float(base[0] - far), float(base[0] + far)), (float(base[1] - far), float(base[1] + far)))


def _placed(task: PlacementTask, node: tuple[float, float, float]) -> Poses:
    """(4, 4) T_cell_board with the middle of the targets at x and y, turned by the yaw about the cell's z."""
    held, centre = task.cell.T_cell_board, task.targets.middle
    turned = pose((0, 0, 0), (0, 0, float(node[2]))) @ held
    middle = (turned @ centre)[:3]
    turned[:3, 3] += np.array([*node[:2], (held @ centre)[2]]) - middle
    return turned
