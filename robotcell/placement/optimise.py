"""Optimal placement of a workpiece: the pose from which its points are reached best. Metres, radians.

The value of a placement does not change when it is turned about the base's axis with all that belongs to it (unless
joint limits, bodies or the table's bounds break the symmetry): the search goes over the distance from that axis, the
workpiece's own yaw and its height, and keeps the direction in which it lies as far as there is room.

A grid, shifted within its spacing by the seed, then pattern searches with random directions (Torczon 1997; Audet and
Dennis 2006) from the best of its places that are no neighbours and from the best of each IK branch: the value has a
valley for each branch, and mirrored ones. The starts race: the better one is, the more evaluations it gets.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from robotcell.cell.cell import Cell
from robotcell.collision.collision import Collider
from robotcell.placement.criteria import NO_ROOM, PlacementGoal, Score
from robotcell.placement.evaluate import Evaluation, PlacementTask, azimuths_of, evaluate, score
from robotcell.placement.reachability import Targets, thinned
from robotcell.placement.room import HasRoom
from robotcell.robot.poses import inverse, pose
from robotcell.robot.robot import Poses
from specs.progress import Progress, no_progress

Spot: TypeAlias = NDArray[np.float64]
"""(4,) distance from the base's axis, own yaw, height, direction about the base's axis."""

MOST_EVALUATIONS = 300
_COUNTS = {1: (8, 12, 8), 2: (8, 12, 4), 3: (6, 8, 3)}
"""Places of the grid along distance, yaw, height, by how many of these are searched."""
_FINEST = np.array([1e-3, np.radians(0.5), 1e-3])
"""Steps at which a search ends: distance, yaw, height."""
_STARTS = 6
_RACE = ((6, 0.35), (3, 0.6), (6, 1.0))
"""How many of the starts go on, the best first, and the share of the remaining evaluations that they may use."""
_DIRECTIONS = np.radians(5.0)
_OTHER_DIRECTIONS = 3
_MOST_POSES = 320
"""Poses, azimuths counted, that a search looks at; the result is that of all targets."""
_AGREES = 0.01
_ADDED = 12
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
    space = _Space(task, has_room)
    search = _Search(replace(task, targets=few), space, np.random.default_rng(task.goal.seed), progress)
    whole = len(few.tool) == len(targets.tool)
    most = MOST_EVALUATIONS - _FOUND
    spots = search.run(most if whole else 2 * most // 3)
    while not whole:
        best = evaluate(task, space.pose_at(spots[0]))
        reached, expected = score(task, best), search.value(spots[0])
        near = reached.value >= expected - _AGREES * abs(expected)
        if near or search.spent >= most - _LEAST_LEFT:
            break
        search = search.with_targets(_with_worst(task, search.task.targets, best, reached))
        spots = search.run((search.spent + most) // 2, spots)
    spots = spots[:_FOUND]
    search.spent += 0 if whole else len(spots)
    found = [_placement(task, space, spot, search.spent) for spot in spots]
    progress("places found", 1.0)
    return tuple(sorted(found, key=lambda each: -round(each.value, 9)))


def judge_placement(
    cell: Cell, targets: Targets, goal: PlacementGoal | None = None, collider: Collider | None = None
) -> Placement:
    """Evaluate the place where the cell holds the board; arguments as for ``find_placements``."""
    task = PlacementTask(cell, targets, goal or PlacementGoal(), collider)
    space = _Space(task, None)
    return _placement(task, space, space.here, 1)


def _placement(task: PlacementTask, space: "_Space", spot: Spot, tried: int) -> Placement:
    T_cell_board = space.pose_at(spot)
    scored = score(task, evaluate(task, T_cell_board)) if space.has_room(T_cell_board) else Score(NO_ROOM)
    return Placement(T_cell_board, scored, float(spot[0]), float(spot[1]), float(spot[3]), tried)


def _with_worst(task: PlacementTask, few: Targets, at: Evaluation, reached: Score) -> Targets:
    """Add the worst of all targets at a placement to those that a search looks at; they add no weight."""
    branches = reached.branches or at.bounds[0].branches
    row = np.full(len(task.targets.tool), -np.inf)
    mine = np.isin(at.found.branch, branches)
    np.maximum.at(row, at.found.target[mine], at.value[mine])
    worst = task.targets.taken(np.argsort(row, kind="stable")[:_ADDED])
    return Targets(
        np.concatenate([few.T_board_tcp, worst.T_board_tcp]),
        np.concatenate([few.tool, worst.tool]),
        np.concatenate([few.free, worst.free]),
        np.concatenate([few.weights, np.full(len(worst.tool), 1e-9)]),
    )


class _Space:
    """Placements as four numbers: where they are, and whether there is room."""

    def __init__(self, task: PlacementTask, has_room: HasRoom | None) -> None:
        cell, goal = task.cell, task.goal
        self.has_room: HasRoom = has_room or (lambda _: True)
        self.T_cell_base = cell.T_cell_base
        self._T_base_board = inverse(cell.T_cell_base) @ cell.T_cell_board
        self._centre = np.append(task.targets.T_board_tcp[:, :3, 3].mean(axis=0), 1.0)
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


@dataclass(slots=True)
class _Start:
    """A pattern search under way."""

    spot: Spot
    score: Score
    step: float
    """In spacings of the grid."""


class _Search:
    """A budget of evaluations, and how it is spent."""

    def __init__(
        self, task: PlacementTask, space: _Space, random: np.random.Generator, progress: Progress, spent: int = 0
    ) -> None:
        self.task, self.spent = task, spent
        self._space, self._random, self._progress = space, random, progress
        self._known: dict[bytes, tuple[Score, Spot]] = {}
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

    def run(self, most: int, spots: Sequence[Spot] = ()) -> list[Spot]:
        """Search until so many evaluations are spent; without spots to start from, from a grid and the present place.

        Returns:
            Where it ended, best first.
        """
        starts = [self._start(self._checked(spot)) for spot in spots] or self._first()
        for going_on, share in _RACE:
            starts.sort(key=lambda start: -round(start.score.value, 12))
            budget = self.spent + int(share * (most - self.spent))
            racing = starts[:going_on]
            for number, start in enumerate(racing):
                begun = self.spent + (budget - self.spent) // (len(racing) - number)
                self._climb(start, budget if share == 1.0 else begun)
        starts.sort(key=lambda start: -round(start.score.value, 12))
        found: list[Spot] = []
        for start in starts:
            if not any(self._is_same(start.spot, other) for other in found):
                found.append(start.spot)
        return found

    def _is_same(self, one: Spot, other: Spot) -> bool:
        return bool(np.all(np.abs(one - other)[:3] <= 4.0 * _FINEST))

    def _start(self, at: tuple[Score, Spot]) -> _Start:
        return _Start(at[1], at[0], 0.5)

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
        chosen = self._apart(steps, [number for _, number, _, _ in scored], _STARTS - 2)
        chosen += [number for number in self._best_of_branches(scored) if number not in chosen]
        spots = {number: spot for _, number, _, spot in scored}
        starts = [self._start(self._checked(spots[number])) for number in chosen[:_STARTS]]
        inside = np.all((here[:3] >= self._space.low) & (here[:3] <= self._space.high))
        if inside or not starts:
            starts.append(self._start(self._checked(here)))
        return starts

    def _apart(self, steps: NDArray[np.int64], order: Sequence[int], most: int) -> list[int]:
        """Choose the first places of a grid that are no neighbours."""
        chosen: list[int] = []
        for number in order:
            apart = np.abs(steps[number] - steps[chosen])
            apart[:, 1] = np.minimum(apart[:, 1], self._counts[1] - apart[:, 1])
            if len(chosen) < most and not np.any(np.all(apart <= 1, axis=1)):
                chosen.append(number)
        return chosen

    def _best_of_branches(self, scored: list[tuple[float, int, tuple[Score, ...], Spot]]) -> list[int]:
        """Number of the place that is best in each branch, the best of these first."""
        best: dict[tuple[int, ...], tuple[float, int]] = {}
        for _, number, bounds, _ in scored:
            for bound in bounds:
                value = -round(bound.value, 9)
                if bound.branches not in best or value < best[bound.branches][0]:
                    best[bound.branches] = value, number
        return [number for _, number in sorted(best.values())]

    def _climb(self, start: _Start, most: int) -> None:
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
                better, at = self._checked(self._space.kept(near), start.score.value)
                if better.value > start.score.value + 1e-12:
                    start.score, start.spot, start.step = better, at, min(1.5 * start.step, 1.0)
                    break
            else:
                start.step *= 0.5

    def _evaluate(self, spot: Spot) -> Evaluation:
        self.spent += 1
        return evaluate(self.task, self._space.pose_at(spot))

    def _checked(self, spot: Spot, above: float = -np.inf) -> tuple[Score, Spot]:
        """Score a spot with the bodies checked, unless its bound is no better than a value; in the best direction."""
        if spot.tobytes() in self._known:
            return self._known[spot.tobytes()]
        best = Score(NO_ROOM), spot
        for near in self._space.roomy(spot):
            at = self._evaluate(near)
            bound = at.bounds[0]
            reached = bound if round(bound.value, 12) <= round(above, 12) else score(self.task, at)
            if reached.value > best[0].value:
                best = reached, near
            if round(best[0].value, 12) >= round(bound.value, 12) or self.spent >= self._most:
                break
        self._known[spot.tobytes()] = self._known[best[1].tobytes()] = best
        return best
