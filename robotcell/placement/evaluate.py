"""Evaluation of one placement: every IK branch at every target, bodies checked where that can change the result."""

from dataclasses import dataclass
from itertools import combinations
from typing import Literal, NamedTuple, TypeAlias, assert_never

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import Cell, TableBounds
from robotcell.collision.collision import Collider, with_board_at
from robotcell.placement.reachability import (
    Configurations,
    Metric,
    Targets,
    clear_of,
    configurations_at,
    hits_of,
    measure,
)
from robotcell.robot.robot import Joints, Poses, nearest_turns

Criterion: TypeAlias = Literal["least", "mean", "p5"]
BranchValues: TypeAlias = NDArray[np.float64]
"""(b, k): the metric of k targets in b IK branches; minus infinity where a branch does not reach a target."""

NO_ROOM = -3.0
P5 = 0.05


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
    direction: tuple[float, float] = (0.0, 0.0)
    """rad that it may be carried around the base's axis from where it lies."""
    configurations: Literal[1, 2] = 1
    """IK branches that may share the targets."""
    seed: int = 0
    """Of what is random in the search."""
    table: TableBounds | None = None
    """Where the whole workpiece has to be; anywhere if left out."""


class Score(NamedTuple):
    """The worth of a placement by the branches that reach its targets best."""

    value: float
    """Of the criterion; above -1 but negative if a point is worse than the floor; -1 minus the share of points that are
    not reached; -3 where the board has no room."""
    least: float = -np.inf
    mean: float = -np.inf
    p5: float = -np.inf
    branches: tuple[int, ...] = ()
    """One, or two that share the targets stroke by stroke, as ``values_of`` has it."""


def quantiles(values: Scalars, weight: Scalars, shares: Scalars) -> Scalars:
    """Give the least of the values (k,) that has at least each share (s,) of the weight (k,) at or below it."""
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weight[order])
    at = np.searchsorted(below, shares * below[-1] * (1.0 - 1e-12))
    return values[order[np.minimum(at, len(order) - 1)]]


def score_row(row: Scalars, weight: Scalars, goal: PlacementGoal, branches: tuple[int, ...]) -> Score:
    """Score the values (k,) of one branch, or of two together, with the weight (k,) of each target."""
    missing = ~np.isfinite(row)
    if missing.any():
        return Score(-1.0 - float(np.mean(missing)), branches=branches)
    least, mean = float(row.min()), float(row @ weight / weight.sum())
    p5 = float(quantiles(row, weight, np.array([P5]))[0])
    value = {"least": least, "mean": mean, "p5": p5}[goal.criterion]
    if least < goal.floor:
        value = least - goal.floor - 1e-9
    return Score(value, least, mean, p5, branches)


def score_rows(rows: BranchValues, weight: Scalars, goal: PlacementGoal) -> Scalars:
    """(m,) as ``Score.value`` of the values (m, k) of one branch at m placements; values may be negative."""
    reached = np.isfinite(rows)
    missing = 1.0 - reached.mean(axis=1)
    known = np.where(reached, rows, 0.0)
    least = known.min(axis=1)
    match goal.criterion:
        case "least":
            value = least
        case "mean":
            value = known @ weight / weight.sum()
        case "p5":
            order = np.argsort(known, axis=1)
            below = np.cumsum(weight[order], axis=1)
            rank = np.argmax(below >= P5 * below[:, -1:] * (1.0 - 1e-12), axis=1)
            value = np.take_along_axis(known, order[np.arange(len(rows)), rank][:, None], axis=1)[:, 0]
        case _:
            assert_never(goal.criterion)
    value = np.where(least >= goal.floor, value, least - goal.floor - 1e-9)
    return np.where(missing > 0.0, -1.0 - missing, value)


def values_of(rows: NDArray[np.float64], strokes: Indices) -> NDArray[np.float64]:
    """Give the values (..., k) that one branch or two, rows (1 or 2, ..., k), have together, each stroke in one."""
    return rows[0] if len(rows) == 1 else np.where(second_is_better(rows, strokes), rows[1], rows[0])


def second_is_better(rows: NDArray[np.float64], strokes: Indices) -> NDArray[np.bool_]:
    """(..., k) whether the second of two branches takes the stroke of each target.

    The jet is on along a stroke, and the configuration stays: each stroke goes to the branch that reaches more of its
    targets, of equals to the one whose least value there is greater.

    Args:
        rows: (2, ..., k) values, minus infinity where a target is not reached.
        strokes: (k,) the number of the stroke of each target.
    """
    number, place = np.unique(strokes, return_inverse=True)
    if len(number) == len(strokes):
        return rows[1] > rows[0]
    order = np.argsort(place, kind="stable")
    begins = np.searchsorted(place[order], np.arange(len(number)))
    sorted_rows = rows[..., order]
    reached = np.add.reduceat(np.isfinite(sorted_rows), begins, axis=-1, dtype=np.int64)
    least = np.minimum.reduceat(sorted_rows, begins, axis=-1)
    second = (reached[1] > reached[0]) | ((reached[1] == reached[0]) & (least[1] > least[0]))
    return second[..., place]


def score_branches(values: BranchValues, targets: Targets, goal: PlacementGoal) -> list[Score]:
    """Score each branch, and each pair where two may share the targets; best first, of equals the first."""
    weight, strokes = targets.weights, targets.strokes
    scores = [score_row(row, weight, goal, (number,)) for number, row in enumerate(values)]
    if goal.configurations == 2 and max(score.value for score in scores) < 0.0:
        rows = [number for number, row in enumerate(values) if np.isfinite(row).any()]
        scores += [
            score_row(values_of(values[[one, two]], strokes), weight, goal, (one, two))
            for one, two in combinations(rows, 2)
        ]
    return sorted(scores, key=lambda score: -round(score.value, 12))


_AZIMUTHS = 8
_COAXIAL = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class PlacementTask:
    """What is placed, and by what a placement is evaluated."""

    cell: Cell
    """Its board lies in the direction and at the height that placements are counted from."""
    targets: Targets
    goal: PlacementGoal
    collider: Collider | None
    """Configurations that collide do not count; ``None``: bodies are not looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """The configurations at a placement, whatever collides, and their values."""

    T_cell_board: Poses
    found: Configurations
    value: Scalars
    """(m,) the metric of each."""
    bounds: tuple[Score, ...]
    """Of each branch, or pair, best first: collisions only take configurations away."""


def azimuths_of(task: PlacementTask) -> int:
    """Give how many azimuths are tried about a free jet.

    One, where all jets lie on the last axis: joint 6 turns freely then, and changes neither reach nor manipulability.
    """
    if not task.targets.free.any():
        return 1
    robot, last = task.cell.robot, task.cell.robot.joints[-1]
    turns = last.kind == "revolute" and last.highest - last.lowest >= 2.0 * np.pi - _COAXIAL
    if task.goal.metric != "manipulability" or robot.dof != 6 or not turns:
        return _AZIMUTHS
    turn = robot.T_link_flange[:3, :3]
    for tool in np.unique(task.targets.tool).tolist():
        T_flange_tcp, axis = task.cell.tools[tool].T_flange_tcp, turn.T @ last.axis
        away = T_flange_tcp[:3, 3] + turn.T @ robot.T_link_flange[:3, 3]
        if np.abs([np.cross(axis, T_flange_tcp[:3, 2]), np.cross(axis, away)]).max() >= _COAXIAL:
            return _AZIMUTHS
    return 1


def evaluate(task: PlacementTask, T_cell_board: Poses) -> Evaluation:
    """Solve the kinematics at a placement, and measure; of the metric ``clearance`` what collides is left out."""
    found = configurations_at(task.cell, T_cell_board, task.targets, azimuths_of(task))
    collider = task.collider
    if task.goal.metric == "clearance" and collider is not None:
        collider = with_board_at(collider, T_cell_board)
        found = clear_of(task.cell, collider, task.targets, found)
    value = measure(task.cell, found.q, task.targets.tool[found.target], task.goal.metric, collider)
    values, _ = branch_values(found, value, len(task.targets.tool))
    bounds = score_branches(values, task.targets, task.goal)
    return Evaluation(T_cell_board, found, value, tuple(bounds))


def evaluate_many(task: PlacementTask, T_cell_boards: Poses) -> Scalars:
    """Give the bounds (n,) of n placements (n, 4, 4), as ``evaluate(...).bounds[0].value`` does, all in one.

    But for the metric ``clearance``, whose bodies move with the board.
    """
    goal, one = task.goal, task.targets
    if goal.metric == "clearance":
        return np.array([evaluate(task, each).bounds[0].value for each in T_cell_boards])
    n, k = len(T_cell_boards), len(one.tool)
    every = Targets(
        (T_cell_boards[:, None] @ one.T_board_tcp).reshape(-1, 4, 4), np.tile(one.tool, n), np.tile(one.free, n)
    )
    found = configurations_at(task.cell, np.eye(4), every, azimuths_of(task))
    value = measure(task.cell, found.q, every.tool[found.target], goal.metric)
    rows = branch_values(found, value, n * k)[0].reshape(-1, n, k)
    best = np.max([score_rows(row, one.weights, goal) for row in rows], axis=0)
    if goal.configurations == 2:
        for first, second in combinations(rows, 2):
            both = best < 0.0
            shared = values_of(np.stack([first, second]), one.strokes)
            best[both] = np.maximum(best, score_rows(shared, one.weights, goal))[both]
    return best


def branch_values(found: Configurations, value: Scalars, count: int, least: int = 1) -> tuple[BranchValues, Indices]:
    """Give the best value (b, k) of each branch, at least so many, at each target, and the row of ``found``, or -1."""
    branches = max(int(found.branch.max(initial=0)) + 1, least)
    order = np.argsort(value, kind="stable")
    row = np.full((branches, count), -1, dtype=np.int64)
    row[found.branch[order], found.target[order]] = order  # of those at one place the last stays: the best
    return np.where(row >= 0, value[row] if len(value) else -np.inf, -np.inf), row


def score(task: PlacementTask, at: Evaluation) -> Score:
    """Score a placement by its best branch, with the bodies checked."""
    return score_clear(task, at)[0]


def score_clear(task: PlacementTask, at: Evaluation) -> tuple[Score, "ClearBranches"]:
    """Score a placement as ``score`` does; give also what was found out about its branches."""
    checker = ClearBranches(task, at)
    if task.collider is None or task.goal.metric == "clearance":
        return at.bounds[0], checker
    best = Score(-np.inf)
    for bound in at.bounds:
        if round(bound.value, 12) <= round(best.value, 12):
            break
        values = np.stack([checker.found(branch)[0] for branch in bound.branches])
        scored = score_branches(values, task.targets, task.goal)[0]
        if round(scored.value, 12) > round(best.value, 12):
            best = scored._replace(branches=tuple(bound.branches[each] for each in scored.branches))
    return best, checker


class ClearBranches:
    """Values of branches at a placement without the configurations that collide; each branch is checked once."""

    def __init__(self, task: PlacementTask, at: Evaluation) -> None:
        """Look at a placement; nothing is checked yet."""
        self._task, self._at = task, at
        self._collider = None if task.collider is None else with_board_at(task.collider, at.T_cell_board)
        self._known: dict[int, tuple[Scalars, Joints]] = {}

    def found(self, branch: int) -> tuple[Scalars, Joints]:
        """(k,) values of a branch, minus infinity at targets that it does not reach without a collision.

        And (k, dof) the configurations of these values; NaN at targets that are not reached.
        """
        if branch not in self._known:
            self._known[branch] = self._check(branch)
        return self._known[branch]

    def blocked(self) -> dict[int, float]:
        """Share of the targets that collide, of those that a branch reaches; of the branches that were checked."""
        shares: dict[int, float] = {}
        for branch, (values, _) in self._known.items():
            reached = len(np.unique(self._at.found.target[self._at.found.branch == branch]))
            shares[branch] = 1.0 - float(np.isfinite(values).sum()) / max(reached, 1)
        return shares

    def _check(self, branch: int) -> tuple[Scalars, Joints]:
        """Check the best configuration of each target; where it collides, the next best, as long as there is one."""
        found, task = self._at.found, self._task
        rows = np.flatnonzero(found.branch == branch)
        rows = rows[np.lexsort((-self._at.value[rows], found.target[rows]))]
        values = np.full(len(task.targets.tool), -np.inf)
        joints = np.full((len(values), task.cell.robot.dof), np.nan)
        while len(rows):
            first = rows[np.append(True, np.diff(found.target[rows]) > 0)]
            clear = first[~self._hits(found, first)]
            values[found.target[clear]] = self._at.value[clear]
            joints[found.target[clear]] = found.q[clear]
            waiting = np.isneginf(values[found.target[rows]]) & ~np.isin(rows, first)
            if azimuths_of(task) == 1:
                self._turn_about_jet(found, first, values, joints)
            rows = rows[waiting]
        return values, joints

    def _turn_about_jet(self, found: Configurations, rows: Indices, values: Scalars, joints: Joints) -> None:
        """Turn the last joint where only one azimuth of a free jet was looked at, until nothing collides."""
        for step in range(1, _AZIMUTHS):
            target = found.target[rows]
            rows = rows[np.isneginf(values[target]) & self._task.targets.free[target]]
            if not len(rows):
                return
            q = found.q[rows].copy()
            q[:, -1] += 2.0 * np.pi * step / _AZIMUTHS
            q = nearest_turns(self._task.cell.robot, q, self._task.cell.home)
            turned = found._replace(target=found.target[rows], q=q)
            clear = np.isfinite(q[:, 0])
            clear[clear] = ~self._hits(turned, np.flatnonzero(clear))
            values[turned.target[clear]] = self._at.value[rows[clear]]
            joints[turned.target[clear]] = q[clear]

    def _hits(self, found: Configurations, rows: Indices) -> NDArray[np.bool_]:
        return hits_of(self._task.cell, self._collider, found.q[rows], self._task.targets.tool[found.target[rows]])
