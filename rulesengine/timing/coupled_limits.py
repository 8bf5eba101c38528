"""Runs where limits couple, through toppra: many runs in one call.

Import this module late: toppra takes half a second to import.
"""

import logging
from dataclasses import replace
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from toppra.algorithm import TOPPRA
from toppra.constraint.linear_constraint import LinearConstraint

from geometry.arrays import Scalars
from rulesengine.timing.limit_intervals import Profile, Stages, cautious, highest_between, join

# toppra reports failures through its result too, which is what counts here.
logging.getLogger("toppra").addHandler(logging.NullHandler())

_FACETS = 3
"""Sides of the polygon that stands for a quarter of the disc of accelerations: at worst 3.4 % inside it."""
_RAMP_STAGES = 4
"""Stages to a ramp up to the highest speed of a stage of the envelope."""
_MOST_STAGES = 4
"""A stage of the envelope is never cut into more,"""
_LEAST = 1e-3
"""nor into shorter ones than this: mm or radians."""
_BATCH_STAGES = 4000
_LESS = 0.99
"""Of the highest squared speeds of a run that toppra cannot solve at first: half a per cent of the speed."""
_GAP = 1.0
"""Length of the stage at rest between two runs of a batch."""

Spans: TypeAlias = list[tuple[int, int]]
"""First stage of each run, and the one after its last."""


class _StageLimits(LinearConstraint):
    """Limits of stages as rows ``a u + b x <= 1`` for the acceleration u and the squared speed x they begin with."""

    def __init__(self, a: NDArray[np.float64], b: NDArray[np.float64], highest: Scalars) -> None:
        super().__init__()
        self.identical = True
        self.dof = 1
        self._a, self._b = a, b
        self._bounds = np.stack((np.zeros_like(highest), highest), axis=1)

    def get_dof(self) -> int:
        """Give the number of joints."""
        return self.dof

    def compute_constraint_params(self, path: Any, gridpoints: Any, *_: Any, **__: Any) -> tuple[Any, ...]:
        """Give a, b, c, F, g and the bounds of u and x, in toppra's order."""
        rows = self._a.shape[1]
        return self._a, self._b, np.zeros_like(self._a), np.eye(rows), np.ones(rows), None, self._bounds


class _Line:
    """The path parameter itself, which is all of the path that toppra needs."""

    dof = 1

    def __init__(self, length: float) -> None:
        self.path_interval = np.array([0.0, length])


def parametrise_coupled(envelope: Profile, turn_acceleration: float) -> Profile:
    """Find the fastest profile of runs whose limits couple, on a grid that refines the grid of their envelope.

    Runs that are alike are solved once. A run without a solution gets the cautious profile.
    """
    stages = refine(envelope)
    runs = spans_of(stages)
    rounded = _rounded(stages)
    seen: dict[bytes, int] = {}
    names = ("length", "curvature", "turn", "turn_change", "cap", "first", "last")
    keys = np.stack([getattr(rounded, name) for name in names], axis=1)
    twins = [seen.setdefault(keys[a:b].tobytes(), run) for run, (a, b) in enumerate(runs)]
    solutions: dict[int, Scalars | None] = {}
    batch: list[int] = []
    size, distinct = 0, sorted(seen.values())
    for run in distinct:
        batch.append(run)
        size += runs[run][1] - runs[run][0]
        if size > _BATCH_STAGES or run == distinct[-1]:
            solved = solve_runs(rounded, [runs[each] for each in batch], turn_acceleration)
            solutions.update(zip(batch, solved, strict=True))
            batch, size = [], 0
    begin, end = np.zeros(len(keys)), np.zeros(len(keys))
    unsolved = np.zeros(len(keys), dtype=np.bool_)
    for twin, (a, b) in zip(twins, runs, strict=True):
        squared = solutions[twin]
        unsolved[a:b] = squared is None
        if squared is not None:
            begin[a:b], end[a:b] = squared[:-1], squared[1:]
    fastest = Profile(stages, begin, end)
    if not unsolved.any():
        return fastest
    careful = cautious(stages.pick(np.flatnonzero(unsolved)), turn_acceleration)
    return join(fastest.pick(np.flatnonzero(~unsolved)), careful)


def spans_of(stages: Stages) -> Spans:
    """First stage of each run, and the one after its last."""
    edges = np.concatenate(([0], np.flatnonzero(np.diff(stages.run)) + 1, [len(stages.run)]))
    return list(pairwise(edges.tolist()))


def refine(envelope: Profile) -> Stages:
    """Cut stages so that speed can follow a ramp anywhere that one may be needed.

    A long stage is cut finely for two ramps from its ends and left whole between: the envelope is no faster there.
    """
    stages = envelope.stages
    ramp = 0.5 * stages.cap / stages.push
    long = (stages.length > 5.0 * ramp) & (stages.turn_change == 0.0) & (stages.curvature == 0.0)
    near = np.where(long, 2.0 * ramp, stages.length)
    parts = np.stack((near, stages.length - 2.0 * near, near), axis=1)
    counts = np.ceil(parts * (_RAMP_STAGES / ramp)[:, None] - 1e-6)
    counts = np.clip(counts, 1, np.clip(parts // _LEAST, 1, _MOST_STAGES)).astype(np.int64)
    counts[long, 1] = 1
    counts[~long, 1:] = 0
    parent = np.repeat(np.arange(len(ramp)), counts.sum(axis=1))
    length = np.repeat((parts / np.maximum(counts, 1)).ravel(), counts.ravel())
    before = np.cumsum(length) - length
    first = np.searchsorted(parent, np.arange(len(ramp)))
    start = stages.start[parent] + before - before[first][parent]
    return stages.cut(parent, start, length)


def _rounded(stages: Stages) -> Stages:
    """Round off what a motion of the whole board leaves in the last digits, so that equal runs are the same."""

    def digits(values: Scalars) -> Scalars:
        scale = 10.0 ** (7.0 - np.ceil(np.log10(np.where(values > 0.0, values, 1.0))))
        return np.round(values * scale) / scale

    return replace(
        stages,
        length=np.maximum(np.round(stages.length, 6), 1e-6),
        curvature=digits(stages.curvature),
        turn=digits(stages.turn),
        turn_change=digits(stages.turn_change),
        cap=digits(stages.cap),
        first=digits(stages.first),
        last=digits(stages.last),
    )


def solve_runs(stages: Stages, spans: Spans, turn_acceleration: float, share: float = 1.0) -> list[Scalars | None]:
    """Squared speeds at the borders of the stages of each run; ``None`` where toppra finds none.

    All runs go to toppra in one call; where that fails, each goes on its own, and then with a share of its highest
    squared speeds: rounding may end toppra where many of its rows meet.
    """
    # One more stage after each run, at rest from end to end, keeps the limits of neighbouring runs apart.
    index = np.concatenate([np.append(np.arange(a, b), b - 1) for a, b in spans])
    sizes = np.array([b - a + 1 for a, b in spans])
    ends = np.cumsum(sizes) - 1
    starts = ends - sizes + 1
    chosen = stages.pick(index)
    length = chosen.length.copy()
    length[ends] = _GAP
    a, b = limit_rows(chosen, length, turn_acceleration)
    highest = share * np.concatenate(([0.0], highest_between(chosen)))
    highest[starts] = highest[ends] = 0.0
    grid = np.concatenate(([0.0], np.cumsum(length)[:-1]))
    solver = TOPPRA(
        [_StageLimits(a, b, highest)],
        _Line(float(grid[-1])),
        gridpoints=grid,
        solver_wrapper="seidel",
        parametrizer="ParametrizeConstAccel",
    )
    solver.compute_parameterization(0.0, 0.0)
    speeds = solver.problem_data.sd_vec
    squared = np.full(len(grid), np.nan) if speeds is None else np.asarray(speeds, dtype=np.float64) ** 2
    parts = [squared[first : last + 1] for first, last in zip(starts.tolist(), ends.tolist(), strict=True)]
    if all(len(part) > 2 and np.all(np.isfinite(part)) and np.all(part[1:-1] > 0.0) for part in parts):
        return list(parts)
    if len(spans) > 1:
        return [solve_runs(stages, [span], turn_acceleration)[0] for span in spans]
    return solve_runs(stages, spans, turn_acceleration, _LESS) if share == 1.0 else [None]


def limit_rows(
    stages: Stages, length: Scalars, turn_acceleration: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rows (m, k) of ``a u + b x <= 1`` that hold at both ends of each stage.

    x grows by 2 u length along a stage. A polygon inside the disc of accelerations stands for it, with corners
    where all of it is tangential and where all of it is centripetal.
    """
    step = 0.5 * np.pi / _FACETS
    facets = (np.arange(_FACETS) + 0.5) * step
    reach = np.cos(0.5 * step)
    a, b = [], []
    for sign in (1.0, -1.0):
        for facet in facets:
            a.append(sign * np.cos(facet) / (stages.grip * reach))
            b.append(np.sin(facet) * stages.curvature / (stages.grip * reach))
        a.append(sign * stages.turn / turn_acceleration)
        b.append(stages.turn_change / turn_acceleration)
    at_begin, slope = np.stack(a, axis=1), np.stack(b, axis=1)
    return np.hstack((at_begin, at_begin + 2.0 * length[:, None] * slope)), np.hstack((slope, slope))
