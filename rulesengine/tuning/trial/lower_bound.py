"""One thing that must not become less: what the least wetted places get, what a surface gets in all, or a time."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cleaning.verdicts.exposed_area import LOW, percentile
from cleaning.verdicts.rules import Rule
from geometry.arrays import Scalars
from rulesengine.tuning.trial.requirements import Spare, Want

Key: TypeAlias = tuple[str, Rule, str]
"""Component, rule and step of a judgement; no step: all of its kind together."""
Kind: TypeAlias = Literal["low", "mean", "time"]
"""The 5th percentile by area, the mean by area (mm of liquid), or how long the steps take (s)."""
_BAND = (0.02, 0.08)
"""Cells around the 5th percentile, which tell who sprays it."""


def key_of(of: Spare | Want) -> Key:
    """Tell judgements apart, from one outcome to the next."""
    return of.component, of.judgement.rule, of.judgement.stage


@dataclass(frozen=True, slots=True, eq=False)
class Need:
    """What must not become less than ``least``."""

    key: Key
    kind: Kind
    least: float
    steps: frozenset[str]
    which: tuple[int, ...]
    """Deposits of these steps."""
    volumes: NDArray[np.float64]
    """(deposits, cells) mm"""
    areas: Scalars
    """(cells,)"""

    def amount(self, times: Scalars, durations: Mapping[str, float]) -> float:
        """Foretell it.

        Args:
            times: (all deposits,) how many times as long each is sprayed.
            durations: Of the steps, s.
        """
        if self.kind == "time":
            return sum(durations[step] for step in self.steps)
        if not len(self.areas):
            return 0.0
        found = times[list(self.which)] @ self.volumes
        if self.kind == "low":
            return percentile(found, self.areas, LOW)
        return float(np.average(found, weights=self.areas))

    def slopes(self, times: Scalars) -> Scalars:
        """(deposits of it,) What each gives near ``times``: with these it comes to the amount."""
        if self.kind == "mean":
            return np.average(self.volumes, axis=1, weights=self.areas)
        found = times[list(self.which)] @ self.volumes
        order = np.argsort(found, kind="stable")
        reached = np.cumsum(self.areas[order]) / self.areas.sum()
        first, last = np.searchsorted(reached, _BAND)
        near = order[first : last + 1]
        mean = float(np.average(found[near], weights=self.areas[near]))
        scale = percentile(found, self.areas, LOW) / mean if mean > 0 else 0.0
        return scale * np.average(self.volumes[:, near], axis=1, weights=self.areas[near])
