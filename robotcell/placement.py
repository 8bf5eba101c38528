"""Where a board is held best: the place from which the worst point, or the mean, is reached best. Metres, radians.

The value of a place does not change when it is turned about the base's axis with all that belongs to it (unless joint
limits or bodies break the symmetry): the search goes over the distance from that axis, the board's own yaw and its
height, and keeps the direction in which the board lies. The paper of Maribor maximises the mean manipulability; the
mean hides single bad points, so that the least is what is maximised if nothing else is asked.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robotcell.cell import Cell
from robotcell.collision import Collider, with_board_at
from robotcell.poses import inverse, pose
from robotcell.reach import Metric, Targets, clear_of, measure, postures_at
from robotcell.robot import Poses

Criterion: TypeAlias = Literal["least", "mean"]

_AZIMUTHS = 8
_FINEST = np.array([1e-3, np.radians(0.5), 1e-3])
"""Steps at which the search ends: distance, yaw, height."""


@dataclass(frozen=True, slots=True)
class Wish:
    """What is looked for, and where."""

    metric: Metric = "manipulability"
    criterion: Criterion = "least"
    floor: float = 0.0
    """No point may be worse than this."""
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
    """Of the criterion; negative if not every point is reached: minus the share that is not."""
    least: float
    mean: float
    branch: int
    """The configuration in which every point is reached so."""
    distance: float
    """m from the base's axis to the middle of the targets."""
    yaw: float
    """rad, from how the board lay."""
    tried: int
    """Places that were looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class _Score:
    value: float
    least: float
    mean: float
    branch: int


@dataclass(frozen=True, slots=True, eq=False)
class _Task:
    cell: Cell
    targets: Targets
    wish: Wish
    collider: Collider | None


def find_placement(
    cell: Cell, targets: Targets, wish: Wish | None = None, collider: Collider | None = None
) -> Placement:
    """Search a place for the board: a grid, then ever smaller steps from its best places. Nothing is random.

    Args:
        cell: The cell; its board lies in the direction that is kept.
        targets: What is to be reached, all of it in one configuration.
        wish: What is looked for.
        collider: If given, postures that collide do not count.
    """
    task = _Task(cell, targets, wish or Wish(), collider)
    low, high = _bounds(task.wish)
    counts = np.where(high > low, [8, 12, 4], 1)
    # The middles of equal spans: a whole turn of yaw does not meet its own beginning.
    axes = [a + (b - a) * (np.arange(count) + 0.5) / count for a, b, count in zip(low, high, counts, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    scores = [_score(task, place) for place in grid]
    order = np.argsort([-round(score.value, 9) for score in scores], kind="stable")
    tried = len(grid)
    best, place = scores[int(order[0])], grid[int(order[0])]
    for start in order[:3].tolist():
        found, at, more = _descend(task, grid[start], scores[start], (high - low) / counts)
        tried += more
        if found.value > best.value + 1e-12:
            best, place = found, at
    return Placement(
        T_cell_board=_placed(task, place),
        value=best.value,
        least=best.least,
        mean=best.mean,
        branch=best.branch,
        distance=float(place[0]),
        yaw=float(place[1]),
        tried=tried,
    )


def _bounds(wish: Wish) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest distance, yaw and height."""
    spans = np.array([wish.distance, wish.yaw, wish.height])
    return spans[:, 0], spans[:, 1]


def _descend(
    task: _Task, place: NDArray[np.float64], score: _Score, step: NDArray[np.float64]
) -> tuple[_Score, NDArray[np.float64], int]:
    """Walk uphill along the axes; halve the steps where no neighbour is better."""
    low, high = _bounds(task.wish)
    tried = 0
    while np.any(step > _FINEST):
        moved = False
        for axis in np.flatnonzero(step > 0.25 * _FINEST).tolist():
            for sign in (1.0, -1.0):
                near = place.copy()
                near[axis] = np.clip(near[axis] + sign * step[axis], low[axis], high[axis])
                other = _score(task, near)
                tried += 1
                if other.value > score.value + 1e-12:
                    place, score, moved = near, other, True
        if not moved:
            step = 0.5 * step
    return score, place, tried


def _placed(task: _Task, place: NDArray[np.float64]) -> Poses:
    """(4, 4) T_cell_board with the middle of the targets at a distance from the base's axis, turned and lifted."""
    T_base_board = inverse(task.cell.T_cell_base) @ task.cell.T_cell_board
    centre = task.targets.T_board_tcp[:, :3, 3].mean(axis=0)
    middle = (T_base_board @ np.append(centre, 1.0))[:3]
    away = np.array([middle[0], middle[1], 0.0])
    length = float(np.linalg.norm(away))
    away = away / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    goal = away * place[0] + np.array([0.0, 0.0, middle[2] + place[2]])
    turned = T_base_board @ pose((0, 0, 0), (0, 0, float(place[1])))
    turned[:3, 3] += goal - (turned @ np.append(centre, 1.0))[:3]
    return task.cell.T_cell_base @ turned


def _score(task: _Task, place: NDArray[np.float64]) -> _Score:
    """Judge a place by the best single configuration."""
    T_cell_board = _placed(task, place)
    found = postures_at(task.cell, T_cell_board, task.targets, _AZIMUTHS)
    collider = None if task.collider is None else with_board_at(task.collider, T_cell_board)
    if collider is not None:
        found = clear_of(task.cell, collider, task.targets, found)
    count = len(task.targets.tool)
    values = measure(task.cell, found.q, task.targets.tool[found.target], task.wish.metric, collider)
    branches = int(found.branch.max(initial=0)) + 1
    best = np.full((branches, count), -np.inf)
    np.maximum.at(best, (found.branch, found.target), values)
    reached = np.isfinite(best)
    scores = [
        _Score(_value(row, task.wish), float(row.min()), float(row.mean()), branch)
        if there.all()
        else _Score(-1.0 - float(np.mean(~there)), -np.inf, -np.inf, branch)
        for branch, (row, there) in enumerate(zip(best, reached, strict=True))
    ]
    return max(scores, key=lambda score: (round(score.value, 12), -score.branch))


def _value(row: NDArray[np.float64], wish: Wish) -> float:
    """Value of a place that reaches everything; negative, but above -1, where a point is worse than the floor."""
    if row.min() < wish.floor:
        return float(row.min() - wish.floor) - 1e-9
    return float(row.min() if wish.criterion == "least" else row.mean())
