"""The worth of a placement: one number for each IK branch, and of the best branch, or the best two.

The paper of Maribor maximises the mean manipulability over a workpiece, eq. (5), and concludes that the mean hides
critical points: the least, or the 5th percentile, do not, and a floor forbids points that are worse.
"""

from dataclasses import dataclass
from itertools import combinations
from typing import Literal, NamedTuple, TypeAlias, assert_never

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.placement.reachability import Metric, Targets
from robotcell.placement.room import TableBounds

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
