"""Optimal placement of a workpiece: the pose from which its points are reached best. Metres, radians.

The value of a placement does not change when it is turned about the base's axis with all that belongs to it (unless
joint limits, bodies or the table's bounds break the symmetry): the search goes over the distance from that axis, the
workpiece's own yaw and its height, and keeps the direction in which it lies as far as there is room.

A grid, shifted within its spacing by the seed, then pattern searches with random directions (Torczon 1997; Audet and
Dennis 2006) from the best of its places that are no neighbours and from the best of each IK branch: the value has a
peak for each branch, and mirrored ones. Then a ring of yaws at the best distance, and the places of which a surrogate
predicts most, drawn all around and beside the best. All starts race: the better one is, the more evaluations it gets.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from robotcell.cell.cell import Cell, HasRoom
from robotcell.collision.collision import Collider
from robotcell.placement.evaluate import (
    NO_ROOM,
    Evaluation,
    PlacementGoal,
    PlacementTask,
    Score,
    azimuths_of,
    branch_values,
    evaluate,
    score,
    score_clear,
    values_of,
)
from robotcell.placement.reachability import Targets, thinned
from robotcell.placement.search_space import LEVER, SearchSpace, Spot, Spots, Surrogate, choose_apart
from robotcell.robot.robot import Poses
from specs.progress import Progress, no_progress

MOST_EVALUATIONS = 300
_COUNTS = {1: (8, 12, 8), 2: (8, 12, 4), 3: (6, 8, 3)}
"""Places of the grid along distance, yaw, height, by how many of these are searched."""
_FINEST = np.array([1e-3, np.radians(0.5), 1e-3])
"""Steps at which a search ends: distance, yaw, height."""
_STARTS = 6
_FIRST_RACE, _PREDICTED = 0.25, 0.7
"""Shares of the remaining evaluations for the first starts, then for the ring and the surrogate's places."""
_RACE = ((3, 0.6), (6, 1.0))
"""How many of the starts go on, the best first, and the share of the remaining evaluations that they may use."""
_RING = 24
_WIDE, _DRAWN, _WIDE_NEW, _WIDE_BATCH = 0.03, 1500, 4e-3, 4
"""Places drawn at all yaws: within so many m of the best distance and height, how many, m to each
known place, how many are chosen."""
_NARROW, _DRAWN_NEAR, _NARROW_NEW, _NARROW_BATCH = (8e-3, 2e-3), 100, 5e-4, 2
"""The same beside each of the best."""
_WIDE_AMONG_BODIES, _APART_AMONG_BODIES = 0.2, 0.04
_PEAKS, _BEST = 3, 20
_MODELLED = 0.08
"""m from the best distance: known places that the surrogate is fitted to."""
_PROBED, _PROBES = 8, 10
"""Targets at most, and one in how many, at which a place is looked at first."""
_WORST = 3
"""Of a place that was evaluated, that are looked at first from then on."""
_DRAWN_FOR_ONE = 6
"""Promising places that are looked at among bodies for each that is evaluated."""
_APART = 0.01
"""m between places that are chosen together."""
_SURE_STEP = 0.05
_MOST_POSES = 320
"""Poses, azimuths counted, that a search looks at; the result is that of all targets."""
_AGREES = 0.01
_ADDED = 12
_TAIL = 0.15
"""Share of the targets, the worst at a place, that a search for the 5th percentile looks at from then on."""
_LEAST_LEFT = 24
_FOUND = 4
"""Places that are evaluated at all targets in the end."""


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """A place that was found, evaluated at all targets."""

    T_cell_board: Poses
    score: Score
    distance: float
    """m from the base's axis to the middle of the targets."""
    yaw: float
    """rad, from how the board lay to how it lies as seen from the base's axis."""
    direction: float
    """rad about the base's axis, from where the board lay."""
    tried: int
    """Places that were evaluated."""

    @property
    def value(self) -> float:
        """Of the criterion, as in ``Score``."""
        return self.score.value

    @property
    def least(self) -> float:
        """At the worst point; minus infinity where a point is not reached."""
        return self.score.least

    @property
    def mean(self) -> float:
        """Of all points; minus infinity where a point is not reached."""
        return self.score.mean


def find_placements(
    cell: Cell,
    targets: Targets,
    goal: PlacementGoal | None = None,
    collider: Collider | None = None,
    *,
    has_room: HasRoom | None = None,
    progress: Progress = no_progress,
) -> tuple[Placement, ...]:
    """Search placements; the same seed gives the same result, after at most ``MOST_EVALUATIONS``.

    The place where the cell holds the board is one of the starts, if it is within the goal's bounds. Many targets are
    thinned for the search; where all together are worth less, the worst of them are added and the search goes on.

    Args:
        cell: The cell; its board lies in the direction and at the height that placements are counted from.
        targets: What is to be reached, all of it in one IK branch, or two.
        goal: What is maximised, and where.
        collider: If given, configurations that collide do not count.
        has_room: Whether the board has room at a T_cell_board (4, 4); everywhere if left out.
        progress: Receives the stage and the share done.

    Returns:
        One to four, best first, none twice.
    """
    task = PlacementTask(cell, targets, goal or PlacementGoal(), collider)
    few = thinned(targets, _MOST_POSES // azimuths_of(task))
    space = SearchSpace(task, has_room)
    search = _Search(replace(task, targets=few), space, np.random.default_rng(task.goal.seed), progress)
    whole = len(few.tool) == len(targets.tool)
    most, tail = MOST_EVALUATIONS - _FOUND, np.zeros(len(targets.tool), dtype=np.bool_)
    spots = search.run(most if whole else 2 * most // 3)
    while not whole:
        best = evaluate(task, space.pose_at(spots[0]))
        reached, expected = score(task, best), search.value(spots[0])
        off = expected - reached.value
        is_near = (abs(off) if task.goal.criterion == "p5" else off) <= _AGREES * abs(expected)
        if is_near or search.spent >= most - _LEAST_LEFT:
            break
        row = _values_at(task, best, reached)
        if task.goal.criterion == "p5":
            tail |= row <= np.quantile(row, _TAIL, method="lower")
            search = search.with_targets(_with_tail(targets, few, tail))
        else:
            worst = targets.taken(np.argsort(row, kind="stable")[:_ADDED])  # they add no weight
            worst = replace(worst, weight=np.full(len(worst.tool), 1e-9))
            search = search.with_targets(search.task.targets.joined(worst))
        spots = search.run((search.spent + most) // 2, spots)
    spots = spots[:_FOUND]
    search.spent += 0 if whole else len(spots)
    found = [_placement(task, space, spot, int(np.ceil(search.spent))) for spot in spots]
    progress("places found", 1.0)
    return tuple(sorted(found, key=lambda each: -round(each.value, 9)))


def judge_placement(
    cell: Cell, targets: Targets, goal: PlacementGoal | None = None, collider: Collider | None = None
) -> Placement:
    """Evaluate the place where the cell holds the board; arguments as for ``find_placements``."""
    task = PlacementTask(cell, targets, goal or PlacementGoal(), collider)
    space = SearchSpace(task, None)
    return _placement(task, space, space.here, 1)


def _placement(task: PlacementTask, space: SearchSpace, spot: Spot, tried: int) -> Placement:
    T_cell_board = space.pose_at(spot)
    scored = score(task, evaluate(task, T_cell_board)) if space.has_room(T_cell_board) else Score(NO_ROOM)
    return Placement(T_cell_board, scored, float(spot[0]), float(spot[1]), float(spot[3]), tried)


def _values_at(task: PlacementTask, at: Evaluation, reached: Score) -> Scalars:
    """(k,) the best value at each of all targets in the branches of a score."""
    rows, _ = branch_values(at.found, at.value, len(task.targets.tool))
    return values_of(rows[list(reached.branches or at.bounds[0].branches)], task.targets.strokes)


def _with_tail(targets: Targets, few: Targets, tail: NDArray[np.bool_]) -> Targets:
    """Give some of the targets (k,) whole, as they are near the percentile, and of the rest as many as before."""
    rest = thinned(targets.taken(np.flatnonzero(~tail)), len(few.tool))
    return targets.taken(np.flatnonzero(tail)).joined(rest)


@dataclass(slots=True)
class _Start:
    """A pattern search under way."""

    spot: Spot
    score: Score
    step: float
    """In spacings of the grid."""


@dataclass(slots=True)
class _Evaluated:
    """A spot that was evaluated."""

    spot: Spot
    evaluation: Evaluation
    blocked: dict[int, float] = field(default_factory=dict[int, float])
    """Share of the targets that collide, by branch; of those that were checked."""


class _Search:
    """A budget of evaluations, and how it is spent."""

    def __init__(
        self,
        task: PlacementTask,
        space: SearchSpace,
        random: np.random.Generator,
        progress: Progress,
        spent: float = 0.0,
    ) -> None:
        self.task, self.spent = task, spent
        self._space, self._random, self._progress = space, random, progress
        self._known: dict[bytes, tuple[Score, Spot]] = {}
        self._hardest = np.empty(0, dtype=np.int64)
        self._evaluated: dict[bytes, _Evaluated] = {}
        self._most = MOST_EVALUATIONS - _FOUND
        spans = space.high - space.low
        counts = np.array(_COUNTS[max(len(space.searched), 1)])
        self._counts = np.where(spans > 0, counts, 1)
        self._spacing = np.where(spans > 0, spans / self._counts, 0.0)

    def with_targets(self, targets: Targets) -> "_Search":
        """Give a search for other targets that goes on counting."""
        return _Search(replace(self.task, targets=targets), self._space, self._random, self._progress, self.spent)

    def value(self, spot: Spot) -> float:
        """Give the value of a spot that was evaluated."""
        return self._known[spot.tobytes()][0].value

    def run(self, most: float, spots: Sequence[Spot] = ()) -> list[Spot]:
        """Search until so many evaluations are spent; without spots to start from, from a grid and the present place.

        Returns:
            Where it ended, best first.
        """
        starts = [self._start(spot) for spot in spots]
        if not starts:
            starts = self._first()
            self._race(starts, _STARTS, self.spent + int(_FIRST_RACE * (most - self.spent)))
            starts += self._predicted(self.spent + int(_PREDICTED * (most - self.spent)))
        for going_on, share in _RACE:
            self._race(starts, going_on, self.spent + int(share * (most - self.spent)), last=share == 1.0)
        starts.sort(key=lambda start: -round(start.score.value, 12))
        found: list[Spot] = []
        for start in starts:
            if not any(np.all(np.abs(start.spot - other)[:3] <= 4.0 * _FINEST) for other in found):
                found.append(start.spot)
        return found

    def _race(self, starts: list[_Start], going_on: int, budget: float, *, last: bool = False) -> None:
        """Let the best starts walk uphill, each with its part of what is left; in the last race as far as it gets."""
        starts.sort(key=lambda start: -round(start.score.value, 12))
        racing = starts[:going_on]
        for number, start in enumerate(racing):
            part = self.spent + (budget - self.spent) // (len(racing) - number)
            self._climb(start, budget if last else part)

    def _predicted(self, most: float) -> list[_Start]:
        """Evaluate a ring of yaws at the best place, then places that the surrogate predicts to be best.

        Returns:
            The best of them that are no neighbours.
        """
        if 1 not in self._space.searched:
            return []
        ring = np.tile(self._best(1)[0], (_RING, 1))
        ring[:, 1] += 2.0 * np.pi * (np.arange(_RING) + 0.5) / _RING
        looked, chosen = list[tuple[Score, Spot]](), ring
        while len(chosen) and self.spent < most:
            for spot in chosen:
                self._progress("improving places", 0.4 + 0.6 * self.spent / MOST_EVALUATIONS)
                looked.append(self._checked(self._space.kept(spot)))
            chosen = self._most_promising()
        looked.sort(key=lambda each: -round(each[0].value, 12))
        kept = choose_apart(np.stack([spot for _, spot in looked]), _APART, _STARTS) if looked else []
        return [_Start(looked[number][1], looked[number][0], _SURE_STEP) for number in kept]

    def _best(self, most: int) -> Spots:
        """(n, 4) the best of the places that were checked, best first."""
        checked = sorted(self._known.values(), key=lambda each: -round(each[0].value, 12))
        return np.stack([spot for _, spot in checked[:most]])

    def _most_promising(self) -> Spots:
        """Draw places at all yaws near the best distance, and beside the best places; give the best by prediction."""
        best = self._best(_BEST)
        # Bodies may forbid the best distance without them: then other distances are as promising.
        bare = self.task.collider is None
        within, modelled = (_WIDE, _MODELLED) if bare else (_WIDE_AMONG_BODIES, np.inf)
        near = [at for at in self._evaluated.values() if abs(at.spot[0] - best[0, 0]) < modelled]
        branches = sorted({branch for at in near for branch in at.evaluation.bounds[0].branches})
        count, least = len(self.task.targets.tool), max(branches, default=0) + 1
        rows = [branch_values(at.evaluation.found, at.evaluation.value, count, least)[0] for at in near]
        surrogate = Surrogate(
            np.stack([at.spot for at in near]),
            np.array([[at.blocked.get(branch, np.nan) for at in near] for branch in branches]),
            [np.stack([row[branch] for row in rows]) for branch in branches],
            self.task.targets.weights,
            self.task.goal,
        )
        wide = self._drawn(best[0], np.array([within, np.pi, _WIDE]), _DRAWN)
        beside = [
            self._drawn(best[peak], np.array([within, within / LEVER, within]), _DRAWN_NEAR)
            for peak in choose_apart(best, _APART if bare else _APART_AMONG_BODIES, _PEAKS)
            for within in _NARROW
        ]
        near_by = np.concatenate(beside)
        worth = surrogate.predict(wide)
        if not bare:  # a clear place among blocked ones is sought where it would be better than what is known
            gain = surrogate.expected_gain(wide, max(self.value(best[0]), 0.0))
            worth = gain if gain.any() else worth
        beside_best = surrogate.choose(near_by, surrogate.predict(near_by), _NARROW_NEW, _APART, _NARROW_BATCH)
        return np.concatenate([self._chosen(surrogate, wide, worth), beside_best])

    def _chosen(self, surrogate: Surrogate, wide: Spots, worth: Scalars) -> Spots:
        """Choose spots that are worth most; among bodies those that hold at the targets that decided last."""
        if self.task.collider is None:
            return surrogate.choose(wide, worth, _WIDE_NEW, _APART, _WIDE_BATCH)
        chosen = surrogate.choose(wide, worth, _WIDE_NEW, _APART, _WIDE_BATCH * _DRAWN_FOR_ONE)
        above = max(self.value(self._best(1)[0]), 0.0)
        kept: list[Spot] = []
        for spot in chosen:
            if len(kept) < _WIDE_BATCH and not self._is_worse(spot, above):
                kept.append(spot)
        return np.stack(kept) if kept else chosen[:1]

    def _drawn(self, spot: Spot, within: Scalars, count: int) -> Spots:
        """(n, 4) random spots within distance, yaw and height of a spot."""
        axes, spots = self._space.searched, np.tile(spot, (count, 1))
        spots[:, axes] += self._random.uniform(-1.0, 1.0, (count, len(axes))) * within[axes]
        return np.stack([self._space.kept(each) for each in spots])

    def _start(self, spot: Spot) -> _Start:
        reached, at = self._checked(spot)
        return _Start(at, reached, 0.5)

    def _first(self) -> list[_Start]:
        """Evaluate a grid without the bodies; give the best places that are no neighbours, and the present one."""
        low, here = self._space.low, self._space.here
        shift = self._random.uniform(0.0, 1.0, 3)
        steps = np.stack(np.unravel_index(np.arange(int(self._counts.prod())), self._counts), axis=-1)
        scored: list[tuple[float, int, tuple[Score, ...], Spot]] = []
        for number, step in enumerate(steps):
            self._progress("evaluating places of the board", 0.4 * number / len(steps))
            spot = self._space.kept(np.append(low + self._spacing * (step + shift), 0.0))
            roomy = self._space.roomy(spot)
            if roomy:
                bounds = self._evaluate(roomy[0]).bounds
                scored.append((-round(bounds[0].value, 9), number, bounds, roomy[0]))
        scored.sort(key=lambda each: each[:2])
        order = self._clear_first([(number, spot) for _, number, _, spot in scored])
        chosen: list[int] = []  # of the grid, no neighbours
        for number in order:
            apart = np.abs(steps[number] - steps[chosen])
            apart[:, 1] = np.minimum(apart[:, 1], self._counts[1] - apart[:, 1])
            if len(chosen) < _STARTS - 2 and not np.any(np.all(apart <= 1, axis=1)):
                chosen.append(number)
        best: dict[tuple[int, ...], tuple[float, int]] = {}  # of each branch
        for _, number, bounds, _ in scored:
            for bound in bounds:
                value = -round(bound.value, 9), number
                best[bound.branches] = min(best.get(bound.branches, value), value, key=lambda each: each[0])
        chosen += [number for _, number in sorted(best.values()) if number not in chosen]
        spots = {number: spot for _, number, _, spot in scored}
        starts = [self._start(spots[number]) for number in chosen[:_STARTS]]
        inside = np.all((here[:3] >= self._space.low) & (here[:3] <= self._space.high))
        if inside or not starts:
            starts.append(self._start(here))
        return starts

    def _clear_first(self, places: list[tuple[int, Spot]]) -> list[int]:
        """Order the numbers of evaluated places, best first, with the bodies checked until enough are feasible."""
        if self.task.collider is None or self.task.goal.metric == "clearance":
            return [number for number, _ in places]
        checked: list[tuple[float, int]] = []
        for number, spot in places:
            at = self._evaluated[spot.tobytes()]
            value = self._score(at).value
            checked.append((-round(value, 12), number))
            if sum(value <= 0.0 for value, _ in checked) == _STARTS:
                break
        rest = [number for number, _ in places[len(checked) :]]
        return [number for _, number in sorted(checked)] + rest

    def _climb(self, start: _Start, most: float) -> None:
        """Walk uphill along random directions; halve the steps where no neighbour is better."""
        axes = self._space.searched
        while self.spent < most and np.any(start.step * self._spacing[axes] > _FINEST[axes]):
            self._progress("improving places", 0.4 + 0.6 * self.spent / MOST_EVALUATIONS)
            turned = np.linalg.qr(self._random.normal(size=(len(axes), len(axes))))[0]
            for way in np.vstack((turned, -turned)):
                if self.spent >= most:
                    return
                near = start.spot.copy()
                near[axes] += start.step * self._spacing[axes] * way
                near = self._space.kept(near)
                if start.score.value >= 0.0 and self._is_worse(near, start.score.value):
                    continue
                better, at = self._checked(near, start.score.value)
                if better.value > start.score.value + 1e-12:
                    start.score, start.spot, start.step = better, at, min(1.5 * start.step, 1.0)
                    break
            else:
                start.step *= 0.5

    def _evaluate(self, spot: Spot) -> Evaluation:
        self.spent += 1
        at = evaluate(self.task, self._space.pose_at(spot))
        self._evaluated[spot.tobytes()] = _Evaluated(spot, at)
        return at

    def _score(self, at: _Evaluated) -> Score:
        """Score an evaluated spot with the bodies checked, and keep which targets decided.

        First those that collide or are not reached, then the worst; without a clear branch, of the bound.
        """
        reached, checker = score_clear(self.task, at.evaluation)
        at.blocked = checker.blocked()
        rows = np.stack([checker.found(branch)[0] for branch in reached.branches])
        worst = np.argsort(values_of(rows, self.task.targets.strokes), kind="stable")[:_WORST]
        rest = self._hardest[~np.isin(self._hardest, worst)]
        most = min(_PROBED, len(self.task.targets.tool) // _PROBES)
        self._hardest = np.concatenate([worst, rest])[:most]
        return reached

    def _is_worse(self, spot: Spot, above: float) -> bool:
        """Whether the targets that decided last are enough to know that a spot is no better than a value of at least 0.

        They cost their share of an evaluation. Nothing better is missed: what they lack, all targets lack.
        """
        goal, few = self.task.goal, self._hardest
        conclusive = goal.criterion == "least" or self.task.collider is not None  # few points bound no mean
        single = len(self._space.directions) == 1 and goal.configurations == 1  # another may do what this one cannot
        if not len(few) or not conclusive or not single or not self._space.has_room(self._space.pose_at(spot)):
            return False
        self.spent += len(few) / len(self.task.targets.tool)
        probed = replace(self.task, targets=self.task.targets.taken(few), goal=replace(goal, criterion="least"))
        reached = score(probed, evaluate(probed, self._space.pose_at(spot))).value
        return reached < 0.0 or (goal.criterion == "least" and round(reached, 12) <= round(above, 12))

    def _checked(self, spot: Spot, above: float = -np.inf) -> tuple[Score, Spot]:
        """Score a spot with the bodies checked, unless its bound is no better than a value; in the best direction."""
        if spot.tobytes() in self._known:
            return self._known[spot.tobytes()]
        best = Score(NO_ROOM), spot
        for near in self._space.roomy(spot):
            at = self._evaluate(near)
            bound = at.bounds[0]
            reached = bound
            if round(bound.value, 12) > round(above, 12):
                reached = self._score(self._evaluated[near.tobytes()])
            if reached.value > best[0].value:
                best = reached, near
            if round(best[0].value, 12) >= round(bound.value, 12) or self.spent >= self._most:
                break
        self._known[spot.tobytes()] = self._known[best[1].tobytes()] = best
        return best
