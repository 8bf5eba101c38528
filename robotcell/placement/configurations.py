"""Each configuration of the arm at a placement by itself: what it reaches, how well, and what it does not."""

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import Cell
from robotcell.collision.collision import Collider
from robotcell.kinematics.inverse import kinematics_of, solve
from robotcell.placement.evaluate import (
    ClearBranches,
    PlacementGoal,
    PlacementTask,
    Score,
    evaluate,
    quantiles,
    score_branches,
    score_row,
    second_is_better,
    values_of,
)
from robotcell.placement.reachability import Targets
from robotcell.robot.robot import Joints, Poses, inverse, link_poses, nearest_turns

SHARES = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Of the points, at or below the quantiles of a box plot."""
_SHIFTS = np.concatenate([[0.0], *([each, -each] for each in np.arange(0.002, 0.6, 0.002))])
"""m towards the shoulder and away from it at which a point that is not reached is tried, the nearest first."""
_MOST_SHIFTED = 40


@dataclass(frozen=True, slots=True, eq=False)
class ConfigurationValues:
    """One configuration (IK branch) at a placement."""

    branch: int
    name: str
    """Such as ``"front, up, flip"``."""
    score: Score
    values: Scalars
    """(k,) the metric at each target; minus infinity where it is not reached, or not without a collision."""
    joints: Joints
    """(k, dof); NaN where it is not reached."""
    weight: Scalars
    """(k,) how much each target counts."""

    @property
    def reached(self) -> float:
        """Share of the targets that are reached."""
        return float(np.mean(np.isfinite(self.values)))

    @property
    def box(self) -> Scalars:
        """(5,) quantiles of ``SHARES`` over the targets that are reached; NaN where none is."""
        there = np.isfinite(self.values)
        if not there.any():
            return np.full(len(SHARES), np.nan)
        return quantiles(self.values[there], self.weight[there], np.array(SHARES))

    @property
    def worst(self) -> int:
        """Index of the target with the least value; of one that is not reached, if there are any."""
        return int(np.argmin(np.round(self.values, 12)))


@dataclass(frozen=True, slots=True, eq=False)
class FailingPoint:
    """A target that is not reached, or worse than the floor."""

    target: int
    branch: int
    value: float
    """Of the metric; minus infinity where it is not reached."""
    missing: float
    """m that it would have to be nearer to the shoulder (farther, if negative) to be reached, whatever collides: 0
    where only a collision is in the way; NaN if that does not help, or is not known. Of a point that is reached, how
    far its value is below the floor."""


@dataclass(frozen=True, slots=True, eq=False)
class PlacementDetails:
    """What every configuration reaches at one placement, with the bodies checked."""

    cell: Cell
    """With the board there."""
    targets: Targets
    goal: PlacementGoal
    score: Score
    configurations: tuple[ConfigurationValues, ...]
    """Those that reach a target, in the order of the branches."""
    region: Indices
    """(k,) which of the branches of the score reaches each target, -1 for none."""
    failing: tuple[FailingPoint, ...]
    """Targets that keep the placement from being feasible, the worst first."""

    @property
    def values(self) -> Scalars:
        """(k,) at each target, of the branch that reaches it."""
        rows = [each.values for each in self.configurations if each.branch in self.score.branches]
        return values_of(np.stack(rows), self.targets.strokes) if rows else np.full(len(self.targets.tool), -np.inf)

    @property
    def worst(self) -> int:
        """Index of the target with the least value."""
        return int(np.argmin(np.round(self.values, 12)))

    @property
    def joints(self) -> Joints:
        """(k, dof) of the branch that reaches each target; NaN where none does."""
        chosen = np.full((len(self.targets.tool), self.cell.robot.dof), np.nan)
        for each in self.configurations:
            mine = self.region == each.branch
            chosen[mine] = each.joints[mine]
        return chosen


def describe_placement(
    cell: Cell, targets: Targets, goal: PlacementGoal, collider: Collider | None = None
) -> PlacementDetails:
    """Evaluate every configuration where the cell holds the board; arguments as for ``find_placements``."""
    task = PlacementTask(cell, targets, goal, collider)
    at = evaluate(task, cell.T_cell_board)
    checked, weight = ClearBranches(task, at), targets.weights
    found: list[ConfigurationValues] = []
    for branch in np.unique(at.found.branch).tolist():
        values, joints = checked.found(branch)
        clear = joints[np.isfinite(values)]  # where everything collides the arm still stands in some way
        name = name_configuration(cell, clear if len(clear) else at.found.q[at.found.branch == branch], branch)
        score = score_row(values, weight, goal, (branch,))
        found.append(ConfigurationValues(branch, name, score, values, joints, weight))
    best, region = _best(found, goal, targets)
    details = PlacementDetails(cell, targets, goal, best, tuple(found), region, ())
    return replace(details, failing=_failing(details))


def _best(found: list[ConfigurationValues], goal: PlacementGoal, targets: Targets) -> tuple[Score, Indices]:
    """Score the best branch, or pair, and give which branch reaches each target.

    The branch that does more keeps all strokes that it does well enough: the fewest points change the configuration.
    """
    count = len(targets.tool)
    region = np.full(count, -1, dtype=np.int64)
    if not found:
        return Score(-2.0), region
    values = np.stack([each.values for each in found])
    best = score_branches(values, targets, goal)[0]
    more, *others = sorted(best.branches, key=lambda row: -int(np.sum(values[row] >= goal.floor)))
    region[:] = more
    for other in others:
        lacking = np.isin(targets.strokes, targets.strokes[values[more] < goal.floor])
        region[lacking & second_is_better(values[[more, other]], targets.strokes)] = other
    region[~np.isfinite(values[region, np.arange(count)])] = -1
    branches = np.array([each.branch for each in found])
    named = best._replace(branches=tuple(int(branches[row]) for row in best.branches))
    return named, np.where(region >= 0, branches[region], -1)


def name_configuration(cell: Cell, joints: Joints, branch: int) -> str:
    """Name a configuration by its shoulder, elbow and wrist, as controllers do; of other arms by its number.

    The shoulder is in front where the flange is on the side to which joint 1 points the arm (branches 0 to 3 of the
    closed forms); the elbow is up if it is above the line from shoulder to wrist; a wrist is flipped where joint 5 is
    negative within half a turn.
    """
    if not len(joints) or cell.robot.dof != 6 or kinematics_of(cell.robot).branches != 8:
        return f"configuration {branch + 1}"
    links = link_poses(cell.robot, joints)[:, :, :3, 3]
    up = cell.T_cell_base[2, :3]
    shoulder, elbow, wrist = links[:, 2], links[:, 3], links[:, 4]
    share = np.einsum("ni,ni->n", elbow - shoulder, wrist - shoulder)
    share /= np.maximum(np.einsum("ni,ni->n", wrist - shoulder, wrist - shoulder), 1e-12)
    above = (elbow - shoulder - share[:, None] * (wrist - shoulder)) @ up
    words = (
        "rear" if branch >= 4 else "front",
        "up" if np.median(above) > 0.0 else "down",
        "flip" if np.median(np.sin(joints[:, 4])) < 0.0 else "no flip",
    )
    return ", ".join(words)


def _failing(details: PlacementDetails) -> tuple[FailingPoint, ...]:
    """Give the targets that are not reached, by how much, and those that are worse than the floor."""
    values, floor = details.values, details.goal.floor
    branches = details.score.branches or (0,)
    unreached = np.flatnonzero(~np.isfinite(values))
    shifts = _shifts(details, unreached[:_MOST_SHIFTED], branches)
    found = [
        FailingPoint(int(target), branches[0], -np.inf, shifts.get(int(target), np.nan))
        for target in unreached.tolist()
    ]
    below = np.flatnonzero(np.isfinite(values) & (values < floor))
    below = below[np.argsort(values[below], kind="stable")]
    found += [
        FailingPoint(int(target), int(details.region[target]), float(values[target]), floor - float(values[target]))
        for target in below.tolist()
    ]
    return tuple(found)


def _shifts(details: PlacementDetails, targets: Indices, branches: tuple[int, ...]) -> dict[int, float]:
    """Give the least shift towards the shoulder, or away from it, at which branches reach targets, m."""
    cell, shifts = details.cell, dict[int, float]()
    shoulder = link_poses(cell.robot, cell.home[None])[0, min(2, cell.robot.dof), :3, 3]
    for target in targets.tolist():
        T_flange_tcp = cell.tools[int(details.targets.tool[target])].T_flange_tcp
        pose = (
            inverse(cell.T_cell_base) @ cell.T_cell_board @ details.targets.T_board_tcp[target] @ inverse(T_flange_tcp)
        )
        towards = shoulder - pose[:3, 3]
        poses: Poses = np.tile(pose, (len(_SHIFTS), 1, 1))
        poses[:, :3, 3] += _SHIFTS[:, None] * towards / max(float(np.linalg.norm(towards)), 1e-9)
        solved = solve(cell.robot, poses, T_flange_tcp=T_flange_tcp)
        mine = [each for each in branches if each < solved.q.shape[1]]
        reached = np.isfinite(nearest_turns(cell.robot, solved.q, cell.home)[:, mine, 0]).any(axis=1)
        if reached.any():
            shifts[target] = float(_SHIFTS[int(np.argmax(reached))])
    return shifts
