"""Runs where limits couple, through toppra: many runs in one call.

Import this module late: toppra takes half a second to import.
"""

import logging
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from toppra.algorithm import TOPPRA
from toppra.constraint.linear_constraint import LinearConstraint

from geometry.arrays import Scalars
from rulesengine.profile import Profile, Stages, cautious, join, take

# toppra also says what went wrong through its result; that is what we look at.
logging.getLogger("toppra").addHandler(logging.NullHandler())

_FACETS = 3
"""Sides of the polygon that stands for a quarter of the disc of accelerations: at worst 3.4 % inside it."""
_RAMP_STAGES = 8
"""Stages to a ramp up to the speed asked."""
_MOST_STAGES = 16
"""At most so many from one kink of the envelope to the next."""
_BATCH_STAGES = 4000
_GAP = 1.0
"""Length of the stage at rest between two runs of a batch."""

Squared = dict[int, Scalars | None]
"""Squared speeds at the borders of the stages by run; ``None`` where there is no solution."""


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
    """The path parameter itself, which is all that toppra needs to know of the path."""

    dof = 1

    def __init__(self, length: float) -> None:
        self.path_interval = np.array([0.0, length])


def parametrise_coupled(envelope: Profile, turn_acceleration: float) -> Profile:
    """Find the fastest profile of runs whose limits couple, on a grid that refines the grid of their envelope.

    Runs that are alike are solved once. A run without a solution gets the cautious profile.
    """
    stages = refine(envelope)
    edges = np.concatenate(([0], np.flatnonzero(np.diff(stages.run)) + 1, [len(stages.run)]))
    runs = list(pairwise(edges.tolist()))
    rounded = _rounded(stages)
    seen: dict[bytes, int] = {}
    keys = np.stack((rounded.length, rounded.curvature, rounded.turn, rounded.turn_change, rounded.cap), axis=1)
    twins = [seen.setdefault(keys[a:b].tobytes(), run) for run, (a, b) in enumerate(runs)]
    solutions: Squared = {}
    for batch in _batches(sorted(seen.values()), runs):
        solutions |= _solve(rounded, [runs[run] for run in batch], batch, turn_acceleration)
    begin, end = np.zeros(len(keys)), np.zeros(len(keys))
    unsolved = np.zeros(len(keys), dtype=np.bool_)
    for twin, (a, b) in zip(twins, runs, strict=True):
        squared = solutions[twin]
        unsolved[a:b] = squared is None
        if squared is not None:
            begin[a:b], end[a:b] = squared[:-1], squared[1:]
    solved = Profile(stages, begin, end)
    if not unsolved.any():
        return solved
    careful = cautious(stages.pick(np.flatnonzero(unsolved)), turn_acceleration)
    return join(take(solved, np.flatnonzero(~unsolved)), careful)


def refine(envelope: Profile) -> Stages:
    """Cut stages so that speed can follow a ramp anywhere that one may be needed.

    A long stage is cut finely for two ramps from its ends and left whole between: the envelope is no faster there.
    """
    stages = envelope.stages
    ramp = 0.5 * stages.cap / stages.push
    reach = np.where(stages.length > 5.0 * ramp, 2.0 * ramp, stages.length / 3.0)
    parts = np.stack((reach, stages.length - 2.0 * reach, reach), axis=1)
    counts = np.clip(np.ceil(parts * (_RAMP_STAGES / ramp)[:, None] - 1e-6), 1, _MOST_STAGES).astype(np.int64)
    plain = (stages.length > 5.0 * ramp) & (stages.turn_change == 0.0) & (stages.curvature == 0.0)
    counts[:, 1] = np.where(plain, 1, counts[:, 1])
    total = counts.ravel()
    parent = np.repeat(np.repeat(np.arange(len(ramp)), 3), total)
    length = np.repeat(parts.ravel() / total, total)
    before = np.cumsum(length) - length
    first = np.searchsorted(parent, np.arange(len(ramp)))
    return stages.pick(parent).cut(stages.start[parent] + before - before[first][parent], length)


def _rounded(stages: Stages) -> Stages:
    """Round off what a motion of the whole board leaves in the last digits, so that alike runs are the same."""

    def digits(values: Scalars) -> Scalars:
        scale = 10.0 ** (7.0 - np.ceil(np.log10(np.where(values > 0.0, values, 1.0))))
        return np.round(values * scale) / scale

    return Stages(
        start=stages.start,
        length=np.maximum(np.round(stages.length, 6), 1e-6),
        run=stages.run,
        segment=stages.segment,
        curvature=digits(stages.curvature),
        turn=digits(stages.turn),
        turn_change=digits(stages.turn_change),
        cap=digits(stages.cap),
        push=stages.push,
        grip=stages.grip,
    )


def _batches(distinct: list[int], runs: list[tuple[int, int]]) -> Iterator[list[int]]:
    """Group runs so that a call is neither tiny nor huge."""
    batch: list[int] = []
    size = 0
    for run in distinct:
        batch.append(run)
        size += runs[run][1] - runs[run][0]
        if size > _BATCH_STAGES:
            yield batch
            batch, size = [], 0
    if batch:
        yield batch


def _solve(stages: Stages, spans: list[tuple[int, int]], names: list[int], turn_acceleration: float) -> Squared:
    """Solve runs together; where that fails, each on its own."""
    # One more stage at rest after each run: without limits of its own, it keeps the runs apart.
    index = np.concatenate([np.append(np.arange(a, b), b - 1) for a, b in spans])
    sizes = np.array([b - a + 1 for a, b in spans])
    ends = np.cumsum(sizes) - 1
    starts = ends - sizes + 1
    chosen = stages.pick(index)
    length = chosen.length.copy()
    length[ends] = _GAP
    a, b = limit_rows(chosen, length, turn_acceleration)
    a[ends], b[ends] = 0.0, 0.0
    highest = np.minimum(chosen.cap, np.concatenate(([0.0], chosen.cap[:-1])))
    highest[starts] = highest[ends] = 0.0
    grid = np.concatenate(([0.0], np.cumsum(length)[:-1]))
    squared = _call_toppra(a, b, highest, grid)
    solved: Squared = {}
    for name, first, last in zip(names, starts.tolist(), ends.tolist(), strict=True):
        part = squared[first : last + 1]
        moving = bool(np.all(np.isfinite(part)) and np.all(part[1:-1] > 0.0))
        solved[name] = part if moving else None
    failed = [(span, name) for span, name in zip(spans, names, strict=True) if solved[name] is None]
    if len(spans) > 1:
        for span, name in failed:
            solved |= _solve(stages, [span], [name], turn_acceleration)
    return solved


def limit_rows(
    stages: Stages, length: Scalars, turn_acceleration: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Give rows (m, k) of ``a u + b x <= 1`` that hold at both ends of each stage.

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


def _call_toppra(a: NDArray[np.float64], b: NDArray[np.float64], highest: Scalars, grid: Scalars) -> Scalars:
    """Squared speeds at the grid, from rest to rest; not finite where there are none."""
    solver = TOPPRA(
        [_StageLimits(a, b, highest)],
        _Line(float(grid[-1])),
        gridpoints=grid,
        solver_wrapper="seidel",
        parametrizer="ParametrizeConstAccel",
    )
    solver.compute_parameterization(0.0, 0.0)
    speeds = solver.problem_data.sd_vec
    return np.full(len(grid), np.nan) if speeds is None else np.asarray(speeds, dtype=np.float64) ** 2
