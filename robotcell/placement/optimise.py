"""Optimal placement of a board: the pose from which the worst point, or the mean, is reached best. Metres, radians.

The value of a place does not change when it is turned about the base's axis with all that belongs to it (unless joint
limits or bodies break the symmetry): the search goes over the distance from that axis, the board's own yaw and its
height, and keeps the direction in which the board lies. The paper of Maribor maximises the mean manipulability; the
mean hides single bad points, so that by default the least is maximised.
"""

import heapq
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robotcell.cell.cell import Cell
from robotcell.collision.collision import Collider, with_board_at
from robotcell.placement.reachability import Metric, Targets, clear_of, configurations_at, measure
from robotcell.robot.poses import inverse, pose
from robotcell.robot.robot import Poses
from specs.progress import Progress, no_progress, subprogress

Criterion: TypeAlias = Literal["least", "mean"]

HasRoom: TypeAlias = Callable[[Poses], bool]

_AZIMUTHS = 8
_COUNTS = np.array([8, 12, 4])
"""Places of the grid along distance, yaw, height."""
_STARTS = 3
"""Places of the grid from which the local search starts."""
_FINEST = np.array([1e-3, np.radians(0.5), 1e-3])
"""Steps at which the search ends: distance, yaw, height."""


@dataclass(frozen=True, slots=True)
class PlacementGoal:
    """What is maximised, and where."""

    metric: Metric = "manipulability"
    criterion: Criterion = "least"
    floor: float = 0.0
    """Least value allowed at any point."""
    distance: tuple[float, float] = (0.2, 0.9)
    """m from the base's axis to the middle of the targets."""
    height: tuple[float, float] = (0.0, 0.0)
    """m that the board may be moved along the base's axis from where it is."""
    yaw: tuple[float, float] = (-np.pi, np.pi)
    """rad that it may be turned about its own normal from how it lies."""


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """A place that was found."""

    T_cell_board: Poses
    value: float
    """Of the criterion; above -1 but negative if a point is worse than the floor; -1 minus the share of points that are
    not reached; -3 where the board has no room."""
    least: float
    mean: float
    distance: float
    """m from the base's axis to the middle of the targets."""
    yaw: float
    """rad, from how the board lay."""
    tried: int
    """Places that were evaluated."""


class _Score(NamedTuple):
    value: float
    least: float = -np.inf
    mean: float = -np.inf


@dataclass(frozen=True, slots=True, eq=False)
class _Task:
    cell: Cell
    targets: Targets
    goal: PlacementGoal
    collider: Collider | None
    has_room: HasRoom | None = None


def find_placements(
    cell: Cell,
    targets: Targets,
    goal: PlacementGoal | None = None,
    collider: Collider | None = None,
    *,
    has_room: HasRoom | None = None,
    progress: Progress = no_progress,
) -> tuple[Placement, ...]:
    """Search places for the board: a grid, then ever smaller steps from its best places. Nothing is random.

    The place where the cell holds the board is one of the starts, if it is within the goal's bounds.

    Args:
        cell: The cell; its board lies in the direction that is kept.
        targets: What is to be reached, all of it in one IK branch.
        goal: What is maximised, and where.
        collider: If given, configurations that collide do not count.
        has_room: Whether the board has room at a T_cell_board (4, 4); everywhere if left out.
        progress: Receives the stage and the share done.

    Returns:
        One to four, best first, none twice.
    """
    task = _Task(cell, targets, goal or PlacementGoal(), collider, has_room)
    low, high = _bounds(task.goal)
    counts = np.where(high > low, _COUNTS, 1)
    starts, tried = _starts(task, counts, subprogress(progress, 0.0, 0.4))
    found: list[tuple[_Score, NDArray[np.float64]]] = []
    for number, (score, start) in enumerate(starts):
        progress("improving places", 0.4 + 0.6 * number / len(starts))
        better, at, more = _descend(task, start, score, (high - low) / counts)
        tried += more
        if not any(np.all(np.abs(at - other) <= 4.0 * _FINEST) for _, other in found):
            found.append((better, at))
    found.sort(key=lambda pair: -round(pair[0].value, 9))
    progress("places found", 1.0)
    return tuple(_placement(task, place, score, tried) for score, place in found)


def judge_placement(
    cell: Cell, targets: Targets, goal: PlacementGoal | None = None, collider: Collider | None = None
) -> Placement:
    """Evaluate the place where the cell holds the board; arguments as for ``find_placements``."""
    task = _Task(cell, targets, goal or PlacementGoal(), collider)
    here = _here(task)
    return _placement(task, here, _score(task, here), 1)


def _placement(task: _Task, place: NDArray[np.float64], score: _Score, tried: int) -> Placement:
    return Placement(_placed(task, place), *score, distance=float(place[0]), yaw=float(place[1]), tried=tried)


def _here(task: _Task) -> NDArray[np.float64]:
    """Give distance, yaw and height of the board where the cell holds it."""
    return np.array([float(np.linalg.norm(_middle(task)[:2])), 0.0, 0.0])


def _starts(
    task: _Task, counts: NDArray[np.int64], progress: Progress
) -> tuple[list[tuple[_Score, NDArray[np.float64]]], int]:
    """Give the present place and the best of a grid that are no neighbours, and how many places were evaluated.

    Collisions only remove configurations: the value without checking for them is a bound, and only the places with the
    best bounds are evaluated again.
    """
    low, high = _bounds(task.goal)
    # The middles of equal spans: a whole turn of yaw does not meet its own beginning.
    axes = [a + (b - a) * (np.arange(count) + 0.5) / count for a, b, count in zip(low, high, counts, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    steps = np.stack(np.unravel_index(np.arange(len(grid)), counts), axis=-1)
    queue: list[tuple[float, int, _Score | None]] = []
    for index, place in enumerate(grid):
        progress("evaluating places of the board", index / len(grid))
        queue.append((-round(_bound(task, place).value, 9), index, None))
    heapq.heapify(queue)
    here = _here(task)
    chosen: list[int] = []
    starts = [(_score(task, here), here)] if np.all((here >= low) & (here <= high)) else []
    while queue and len(chosen) < _STARTS:
        _, index, score = heapq.heappop(queue)
        apart = np.abs(steps[index] - steps[chosen])
        apart[:, 1] = np.minimum(apart[:, 1], counts[1] - apart[:, 1])
        if np.any(np.all(apart <= 1, axis=1)):
            continue
        if score is None:
            score = _score(task, grid[index])
            heapq.heappush(queue, (-round(score.value, 9), index, score))
        else:
            chosen.append(index)
            starts.append((score, grid[index]))
    return starts, len(grid) + len(starts) - len(chosen)


def _bounds(goal: PlacementGoal) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest distance, yaw and height."""
    spans = np.array([goal.distance, goal.yaw, goal.height])
    return spans[:, 0], spans[:, 1]


def _descend(
    task: _Task, place: NDArray[np.float64], score: _Score, step: NDArray[np.float64]
) -> tuple[_Score, NDArray[np.float64], int]:
    """Coordinate ascent: walk uphill along the axes; halve the steps where no neighbour is better."""
    low, high = _bounds(task.goal)
    tried = 0
    while np.any(step > _FINEST):
        moved = False
        for axis in np.flatnonzero(step > 0.25 * _FINEST).tolist():
            for sign in (1.0, -1.0):
                near = place.copy()
                near[axis] = np.clip(near[axis] + sign * step[axis], low[axis], high[axis])
                tried += 1
                if _bound(task, near).value <= score.value + 1e-12:
                    continue
                other = _score(task, near)
                if other.value > score.value + 1e-12:
                    place, score, moved = near, other, True
        if not moved:
            step = 0.5 * step
    return score, place, tried


def _placed(task: _Task, place: NDArray[np.float64]) -> Poses:
    """(4, 4) T_cell_board with the middle of the targets at a distance from the base's axis, turned and lifted."""
    T_base_board = inverse(task.cell.T_cell_base) @ task.cell.T_cell_board
    middle = _middle(task)
    away = np.array([middle[0], middle[1], 0.0])
    length = float(np.linalg.norm(away))
    away = away / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    target = away * place[0] + np.array([0.0, 0.0, middle[2] + place[2]])
    turned = T_base_board @ pose((0, 0, 0), (0, 0, float(place[1])))
    turned[:3, 3] += target - (turned @ np.append(_centre(task), 1.0))[:3]
    return task.cell.T_cell_base @ turned


def _centre(task: _Task) -> NDArray[np.float64]:
    """(3,) the middle of the targets, board frame."""
    return task.targets.T_board_tcp[:, :3, 3].mean(axis=0)


def _middle(task: _Task) -> NDArray[np.float64]:
    """(3,) where that is as the cell holds the board, base frame."""
    T_base_board = inverse(task.cell.T_cell_base) @ task.cell.T_cell_board
    return (T_base_board @ np.append(_centre(task), 1.0))[:3]


def _bound(task: _Task, place: NDArray[np.float64]) -> _Score:
    """Give an upper bound of the score: collisions are not checked where that can be left out."""
    return _score(task if task.goal.metric == "clearance" else replace(task, collider=None), place)


def _score(task: _Task, place: NDArray[np.float64]) -> _Score:
    """Evaluate a place by the best single branch."""
    T_cell_board = _placed(task, place)
    if task.has_room is not None and not task.has_room(T_cell_board):
        return _Score(-3.0)
    found = configurations_at(task.cell, T_cell_board, task.targets, _AZIMUTHS)
    collider = None if task.collider is None else with_board_at(task.collider, T_cell_board)
    if collider is not None:
        found = clear_of(task.cell, collider, task.targets, found)
    count = len(task.targets.tool)
    values = measure(task.cell, found.q, task.targets.tool[found.target], task.goal.metric, collider)
    branches = int(found.branch.max(initial=0)) + 1
    best = np.full((branches, count), -np.inf)
    np.maximum.at(best, (found.branch, found.target), values)
    scores: list[_Score] = []
    for row, there in zip(best, np.isfinite(best), strict=True):
        if not there.all():
            scores.append(_Score(-1.0 - float(np.mean(~there))))
            continue
        least, mean = float(row.min()), float(row.mean())
        value = least if task.goal.criterion == "least" else mean
        scores.append(_Score(least - task.goal.floor - 1e-9 if least < task.goal.floor else value, least, mean))
    return max(scores, key=lambda score: round(score.value, 12))
