"""Placements as four numbers: their poses, where there is room, and which are worth an evaluation. Metres, radians.

What is worth one is predicted from those that were evaluated, by radial basis functions. The least of many values has
ridges and narrow peaks; the value of one target in one IK branch has neither, and its square passes smoothly through
zero where the arm is stretched. So the square of each is interpolated, and the criterion applied to what is predicted,
as in composite optimisation (Larson, Menickelly and Wild 2019).
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import HasRoom
from robotcell.placement.evaluate import BranchValues, PlacementGoal, PlacementTask, score_rows
from robotcell.robot.robot import Poses, inverse, pose

Spot: TypeAlias = NDArray[np.float64]
"""(4,) distance from the base's axis, own yaw, height, direction about the base's axis."""
Spots: TypeAlias = NDArray[np.float64]
"""(n, 4)"""

_DIRECTIONS = np.radians(5.0)
_OTHER_DIRECTIONS = 3


class SearchSpace:
    """Placements as four numbers: where they are, and whether there is room."""

    def __init__(self, task: PlacementTask, has_room: HasRoom | None) -> None:
        cell, goal = task.cell, task.goal
        self.has_room: HasRoom = has_room or (lambda _: True)
        self.T_cell_base = cell.T_cell_base
        self._T_base_board = inverse(cell.T_cell_base) @ cell.T_cell_board
        self._centre = task.targets.middle
        self._middle = (self._T_base_board @ self._centre)[:3]
        self.here: Spot = np.array([float(np.linalg.norm(self._middle[:2])), 0.0, 0.0, 0.0])
        spans = np.array([goal.distance, goal.yaw, goal.height])
        self.low, self.high = spans[:, 0], spans[:, 1]
        self.searched = np.flatnonzero(self.high > self.low)
        low, high = goal.direction
        count = int(np.floor((high - low) / _DIRECTIONS + 1e-9)) + 1
        around = np.append(low + _DIRECTIONS * np.arange(count), 0.0) if count > 1 else np.array([low])
        self.directions = np.unique(np.clip(around, low, high))
        self._around = np.stack([cell.T_cell_base @ pose((0, 0, 0), (0, 0, each)) for each in self.directions])

    def pose_at(self, spot: Spot) -> Poses:
        """(4, 4) T_cell_board with the middle of the targets at a distance from the base's axis, turned and lifted."""
        return self.T_cell_base @ pose((0, 0, 0), (0, 0, float(spot[3]))) @ self._ahead(spot)

    def _ahead(self, spot: Spot) -> Poses:
        """(4, 4) T_base_board of a spot, in the direction in which the board lies."""
        away = np.array([self._middle[0], self._middle[1], 0.0])
        length = float(np.linalg.norm(away))
        away = away / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
        target = away * spot[0] + np.array([0.0, 0.0, self._middle[2] + spot[2]])
        turned = self._T_base_board @ pose((0, 0, 0), (0, 0, float(spot[1])))
        turned[:3, 3] += target - (turned @ self._centre)[:3]
        return turned

    def turns_of(self, T_cell_board: Poses) -> tuple[float, float]:
        """Give the own yaw of a pose and its direction about the base's axis, rad within half a turn."""
        T_base_board = inverse(self.T_cell_base) @ T_cell_board
        middle, held = T_base_board @ self._centre, self._middle
        direction = float(np.arctan2(middle[1], middle[0]) - np.arctan2(held[1], held[0]))
        turned = self._T_base_board[:3, :3].T @ pose((0, 0, 0), (0, 0, -direction))[:3, :3] @ T_base_board[:3, :3]
        yaw = float(np.arctan2(turned[1, 0], turned[0, 0]))
        return yaw, float(np.mod(direction + np.pi, 2.0 * np.pi) - np.pi)

    def kept(self, spot: Spot) -> Spot:
        """Bring a spot into the bounds; a whole turn of yaw has none."""
        inside = spot.copy()
        inside[:3] = np.clip(spot[:3], self.low, self.high)
        if self.high[1] - self.low[1] > 2.0 * np.pi - 1e-9:
            inside[1] = self.low[1] + np.mod(spot[1] - self.low[1], 2.0 * np.pi)
        return inside

    def roomy(self, spot: Spot) -> list[Spot]:
        """Give a spot in the directions in which there is room: the nearest to its own, then some far from that."""
        order = np.argsort(np.round(np.abs(self.directions - spot[3]), 9), kind="stable")
        poses = self._around[order] @ self._ahead(spot)
        roomy = order[[self.has_room(each) for each in poses]]
        found = [np.append(spot[:3], direction) for direction in self.directions[roomy].tolist()]
        if len(found) <= 1 + _OTHER_DIRECTIONS:
            return found
        others = np.linspace(0, len(found) - 1, 1 + _OTHER_DIRECTIONS).round().astype(int)[1:]
        return [found[0], *(found[each] for each in others.tolist())]


_UNKNOWN = 0.15
"""m to the nearest known spot at which nothing is known of collisions."""
Interpolated: TypeAlias = Callable[[Any], Any]

LEVER = 0.1
"""m to which a radian of yaw corresponds."""
_LEAST_KNOWN = 12
_LIKELY = 0.5
"""Of the interpolated collision, 0 where a branch is clear and 1 where it is not."""
_MOST_COMPARED = 400


def embed(spots: Spots) -> NDArray[np.float64]:
    """Give points (n, 4), m, of spots: their distances do not jump where the yaw has gone once around."""
    yaw = spots[:, 1]
    return np.column_stack([spots[:, 0], LEVER * np.cos(yaw), LEVER * np.sin(yaw), spots[:, 2]])


def choose_apart(spots: Spots, least: float, most: int) -> list[int]:
    """Choose the first spots that are no nearer to one another than ``least``, m."""
    chosen: list[int] = []
    points = embed(spots)
    for number, point in enumerate(points):
        if len(chosen) < most and np.all(np.linalg.norm(points[chosen] - point, axis=1) > least):
            chosen.append(number)
    return chosen


class Surrogate:
    """Predicts the criterion at spots from the values of each target at spots that were evaluated."""

    def __init__(
        self,
        known: Spots,
        blocked: NDArray[np.float64],
        branches: Sequence[BranchValues],
        weight: Scalars,
        goal: PlacementGoal,
    ) -> None:
        """Fit the functions of each branch.

        Args:
            known: (n, 4) that were evaluated.
            blocked: (b, n) share of the targets that collide in each branch; NaN where it was not checked.
            branches: Of each branch (n, k) values of the targets, minus infinity where one is not reached: a spot
                counts for the branches that reach all targets.
            weight: (k,) of the targets.
            goal: What is maximised.
        """
        self._points = embed(known)
        self._weight, self._goal = weight, goal
        self._varied = np.ptp(self._points, axis=0) > 0.0  # a coordinate that is not searched determines nothing
        self._fitted: list[tuple[Interpolated, Interpolated | None]] = []
        for values, share in zip(branches, blocked, strict=True):
            whole: NDArray[np.bool_] = np.all(np.isfinite(values), axis=1)
            value = self._fit(whole, values**2, "cubic")
            # Whether a branch collides, 0 or 1, and the share of its targets that do: both jump.
            collides = np.column_stack([share > 0.0, share]).astype(np.float64)
            if value is not None:
                some = (share > 0.0).any()
                self._fitted.append((value, self._fit(np.isfinite(share), collides, "linear") if some else None))

    def _fit(self, known: NDArray[np.bool_], values: NDArray[np.float64], kernel: str) -> Interpolated | None:
        """Interpolate values (n, m) where they are known (n,); ``None`` where too few are."""
        from scipy.interpolate import RBFInterpolator

        if np.sum(known) < _LEAST_KNOWN:
            return None
        points = self._points[known][:, self._varied]
        return RBFInterpolator(points, values[known], kernel=kernel, smoothing=1e-12)

    def predict(self, spots: Spots) -> Scalars:
        """(m,) the criterion of the best branch; beyond reach it is negative, minus infinity where nothing is known.

        Of a branch that is likely to collide it is -1 minus the share of the targets that do.
        """
        best = np.full(len(spots), -np.inf)
        for value, likely, share in self._branches(spots):
            best = np.maximum(best, np.where(likely < _LIKELY, value, -1.0 - share))
        return best

    def expected_gain(self, spots: Spots, above: float) -> Scalars:
        """(m,) by how much a branch exceeds a value, times how likely it is clear.

        Far from every known spot it may be clear, however likely a collision is by interpolation.
        """
        away = np.linalg.norm(embed(spots)[:, None] - self._points[None], axis=2).min(axis=1)
        best = np.zeros(len(spots))
        for value, likely, _ in self._branches(spots):
            clear = np.clip(1.0 - likely + away / _UNKNOWN, 0.0, 1.0)
            best = np.maximum(best, np.maximum(value - above, 0.0) * clear)
        return best

    def _branches(self, spots: Spots) -> Iterator[tuple[Scalars, Scalars, Scalars]]:
        """Give the criterion (m,) of each branch without collisions, how likely one is, the share of its targets."""
        at = embed(spots)[:, self._varied]
        for fitted, collides in self._fitted:
            squares = fitted(at)
            rows = np.sign(squares) * np.sqrt(np.abs(squares))
            likely, share = np.zeros((2, len(spots))) if collides is None else collides(at).T
            yield score_rows(rows, self._weight, self._goal), likely, np.clip(share, 0.0, 1.0)

    def choose(self, spots: Spots, worth: Scalars, new: float, apart: float, most: int) -> Spots:
        """Give the spots that are worth most, best first.

        Args:
            spots: (m, 4) to choose from.
            worth: (m,) of each; those of minus infinity are left out.
            new: m at least to every known spot.
            apart: m at least between two of them.
            most: How many.
        """
        order = np.argsort(-worth, kind="stable")
        order: Indices = order[np.isfinite(worth[order])]
        away = np.linalg.norm(embed(spots[order])[:, None] - self._points[None], axis=2)
        kept = spots[order[(away > new).all(axis=1)][:_MOST_COMPARED]]
        return kept[choose_apart(kept, apart, most)]
