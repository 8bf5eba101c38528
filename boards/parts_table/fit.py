"""The map that lays the positions of a table onto a board: mirrored, turned and shifted, as programs write them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from geometry.arrays import Points2

NEAR_MM = 1.0
"""A position fits a component whose centre is as near as this, or within whose outline it lies."""

_VOTERS = 150
"""Rows that vote for a shift; more would not change it."""

_CELL_MM = 0.5
"""Shifts nearer to each other than this are one vote."""

_LINEAR: tuple[tuple[str, tuple[tuple[float, float], tuple[float, float]]], ...] = (
    ("", ((1.0, 0.0), (0.0, 1.0))),
    ("turned by 90°", ((0.0, -1.0), (1.0, 0.0))),
    ("turned by 180°", ((-1.0, 0.0), (0.0, -1.0))),
    ("turned by 270°", ((0.0, 1.0), (-1.0, 0.0))),
    ("mirrored in x", ((-1.0, 0.0), (0.0, 1.0))),
    ("mirrored in y", ((1.0, 0.0), (0.0, -1.0))),
    ("mirrored in x and turned by 90°", ((0.0, -1.0), (-1.0, 0.0))),
    ("mirrored in x and turned by 270°", ((0.0, 1.0), (1.0, 0.0))),
)
"""What is done to the table to lay it on the board, the likeliest first."""


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """The map from the table onto the board."""

    words: str
    """Empty if the axes agree."""
    linear: NDArray[np.float64]
    """(2, 2)"""
    shift_mm: NDArray[np.float64]
    """(2,)"""
    error_mm: float
    """Median distance between the mapped positions and the centres they belong to."""

    def apply(self, points: Points2) -> Points2:
        """Map positions of the table ``(n, 2)`` onto the board."""
        return points @ self.linear.T + self.shift_mm

    def then(self, other: "Fit") -> "Fit":
        """This map, and another after it."""
        words = " and ".join(filter(None, (self.words, other.words)))
        return Fit(words, other.linear @ self.linear, other.linear @ self.shift_mm + other.shift_mm, 0.0)

    def describe(self) -> str:
        """Words for what is done to the table; empty if nothing is."""
        moved = float(np.hypot(self.shift_mm[0], self.shift_mm[1])) > NEAR_MM
        shift = f"shifted by ({self.shift_mm[0]:.3f}, {self.shift_mm[1]:.3f}) mm" if moved else ""
        return " and ".join(text for text in (self.words, shift) if text)


def fit_pairs(table: Points2, centres: Points2) -> Fit:
    """Best map for positions whose components are known ``(n, 2)``, the untouched table first.

    The shift is the median of the differences, so that some parts in a wrong place do not move the others.
    """
    stay = np.hypot(*(centres - table).T)
    if float(np.median(stay)) <= NEAR_MM:
        return Fit("", np.eye(2), np.zeros(2), float(np.median(stay)))
    fits: list[Fit] = []
    for words, rows in _LINEAR:
        linear = np.array(rows)
        apart = centres - table @ linear.T
        shift = np.median(apart, axis=0)
        fits.append(Fit(words, linear, shift, float(np.median(np.hypot(*(apart - shift).T)))))
    return min(fits, key=lambda fit: round(fit.error_mm, 2))


def fit_points(table: Points2, centres: Points2) -> Fit | None:
    """Best map for positions whose components are not known, by voting.

    Returns:
        ``None`` if fewer than half of the positions (or of the components) find a partner, or if the arrangement is
        so symmetric that several maps fit alike.
    """
    tree = KDTree(centres)
    stay = Fit("", np.eye(2), np.zeros(2), 0.0)
    found = [(_count(stay, table, tree), stay)]
    for words, rows in _LINEAR:
        linear = np.array(rows)
        turned = table @ linear.T
        counted: list[tuple[int, Fit]] = []
        for shift in _vote(turned, centres):
            far, nearest = tree.query(turned + shift)
            near = np.asarray(far) <= NEAR_MM
            if near.any():  # refined by the median of what the nearest centres are away
                shift = shift + np.median(centres[np.asarray(nearest)[near]] - turned[near] - shift, axis=0)
            fit = Fit(words, linear, shift, 0.0)
            counted.append((_count(fit, table, tree), fit))
        found.append(max(counted, key=lambda pair: pair[0]))
    most = max(count for count, _ in found)
    best = [fit for count, fit in found if count == most]
    if 2 * most < min(len(table), len(centres)) or (
        best[0] is not stay and (most < 3 or (best[0].words and len(best) > 1))
    ):
        return None
    return best[0]


def _count(fit: Fit, table: Points2, tree: KDTree) -> int:
    return len(set(np.asarray(tree.query(fit.apply(table), distance_upper_bound=NEAR_MM)[1]).tolist()) - {tree.n})


def _vote(table: Points2, centres: Points2) -> list[NDArray[np.float64]]:
    """The shifts that most pairs of a position and a centre agree on within half a millimetre, the first three."""
    voters = table[np.linspace(0, len(table) - 1, min(len(table), _VOTERS)).astype(np.int64)]
    shifts = (centres[None, :, :] - voters[:, None, :]).reshape(-1, 2)
    # Counted from the first shift, so that moving the board or the table does not change the cells.
    cells = np.floor(np.round((shifts - shifts[0]) / _CELL_MM, 6) + 0.25).astype(np.int64)
    keys = cells[:, 0] * 4_000_037 + cells[:, 1]
    unique, counts = np.unique(keys, return_counts=True)
    leading = unique[np.argsort(-counts, kind="stable")[:3]]
    return [np.median(shifts[keys == key], axis=0) for key in leading]
