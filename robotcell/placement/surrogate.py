"""Which places are worth an evaluation, predicted from those that were evaluated: radial basis functions.

The least of many values has ridges and narrow peaks; the value of one target in one IK branch has neither, and its
square passes smoothly through zero where the arm is stretched. So the square of each is interpolated, and the
criterion applied to what is predicted, as in composite optimisation (Larson, Menickelly
and Wild 2019).
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.placement.criteria import BranchValues, PlacementGoal, score_rows
from robotcell.placement.search_space import Spots

LEVER = 0.1
"""m to which a radian of yaw corresponds."""
_LEAST_KNOWN = 12
_BLOCKED = 0.022
"""m around a spot where the best branches collide that are taken to be no better."""
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
        clear: NDArray[np.bool_],
        branches: Sequence[BranchValues],
        weight: Scalars,
        goal: PlacementGoal,
    ) -> None:
        """Fit the functions of each branch.

        Args:
            known: (n, 4) that were evaluated.
            clear: (n,) whether the best of the branches was found without a collision there.
            branches: Of each branch (n, k) values of the targets, minus infinity where one is not reached: a spot
                counts for the branches that reach all targets.
            weight: (k,) of the targets.
            goal: What is maximised.
        """
        self._points, self._clear = embed(known), clear
        self._weight, self._goal = weight, goal
        self._varied = np.ptp(self._points, axis=0) > 0.0  # a coordinate that is not searched determines nothing
        self._fitted = [each for each in map(self._fit, branches) if each is not None]

    def _fit(self, values: BranchValues) -> Callable[[Any], Any] | None:
        from scipy.interpolate import RBFInterpolator

        whole = np.isfinite(values).all(axis=1)
        if np.sum(whole) < _LEAST_KNOWN:
            return None
        return RBFInterpolator(
            self._points[whole][:, self._varied], values[whole] ** 2, kernel="cubic", smoothing=1e-12
        )

    def predict(self, spots: Spots) -> Scalars:
        """(m,) the criterion of the best branch; beyond reach it is negative, minus infinity where nothing is known."""
        at, best = embed(spots)[:, self._varied], np.full(len(spots), -np.inf)
        for fitted in self._fitted:
            squares = fitted(at)
            rows = np.sign(squares) * np.sqrt(np.abs(squares))
            best = np.maximum(best, score_rows(rows, self._weight, self._goal))
        return best

    def most_promising(self, spots: Spots, new: float, apart: float, most: int) -> Spots:
        """Give the spots of which most is predicted, best first.

        Args:
            spots: (m, 4) to choose from; those close to a known spot that collides are left out.
            new: m at least to every known spot.
            apart: m at least between two of them.
            most: How many.
        """
        value = self.predict(spots)
        order = np.argsort(-value, kind="stable")
        order: Indices = order[np.isfinite(value[order])]
        away = np.linalg.norm(embed(spots[order])[:, None] - self._points[None], axis=2)
        free = (away > np.where(self._clear, new, max(new, _BLOCKED))).all(axis=1)
        kept = spots[order[free][:_MOST_COMPARED]]
        return kept[choose_apart(kept, apart, most)]
