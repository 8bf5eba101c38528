"""Each configuration of the arm at a placement by itself: what it reaches, how well, and what it does not."""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Indices, Points, Scalars
from programs.motion.installation import Maker
from robotcell.cell.cell import Cell
from robotcell.cell.installation import branch_of
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
from robotcell.robot.robot import Joints, Poses, Robot, inverse, link_poses, nearest_turns

SHARES = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Of the points, at or below the quantiles of a box plot."""
_SHIFTS = np.concatenate([[0.0], *([each, -each] for each in np.arange(0.002, 0.6, 0.002))])
"""m towards the shoulder and away from it at which a point that is not reached is tried, the nearest first."""
_MOST_SHIFTED = 40
_NAMED_BY = 15
"""Points of a configuration at most by which it is named."""


@dataclass(frozen=True, slots=True, eq=False)
class ConfigurationValues:
    """One configuration (IK branch) at a placement."""

    branch: int
    name: str
    """Such as ``"N U T"``, as its maker has it."""
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
class Struck:
    """Where the jet of each target meets the workpiece."""

    points: Points
    """(k, 3) the workpiece's frame, m; NaN where a jet passes it by."""
    names: tuple[str, ...]
    """Of each, what is met there: a component, or a body of a part."""


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
    struck: Struck | None = None
    """Where the jets meet the workpiece; ``None`` where that is not known."""

    @property
    def values(self) -> Scalars:
        """(k,) at each target, of the branch that reaches it."""
        rows = [each.values for each in self.configurations if each.branch in self.score.branches]
        return values_of(np.stack(rows), self.targets.strokes) if rows else np.full(len(self.targets.tool), -np.inf)

    @property
    def worst(self) -> int:
        """Index of the target with the least value."""
        return int(np.argmin(np.round(self.values, 12)))

    def place_of(self, target: int) -> tuple[Points, str]:
        """Give the point (3,) of the surface that a target sprays, m, and on what; of the orifice where none is met."""
        if self.struck is None or not np.isfinite(self.struck.points[target, 0]):
            return self.targets.T_board_tcp[target, :3, 3], ""
        return self.struck.points[target], self.struck.names[target]

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
    named = Counter(each.name for each in found)
    repeated = {name for name, count in named.items() if count > 1}
    found = [
        replace(each, name=f"{each.name} ({each.branch + 1})") if each.name in repeated else each for each in found
    ]
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
    """Name a configuration (n, dof) as the arm's maker does; of other arms than six turning joints by its number.

    Where the points of a configuration differ, as most of them stand. Joint 5 is counted by the controller, within
    half a turn: its sign alone is stated where the maker's word for the wrist is not known to follow from it.
    """
    robot = cell.robot
    branch_at = branch_of(robot)
    if not len(joints) or branch_at is None or kinematics_of(robot).branches != 8:
        return f"configuration {branch + 1}"
    some = joints[np.linspace(0, len(joints) - 1, min(len(joints), _NAMED_BY)).astype(int)]
    stands = [branch_at(tuple(row)) for row in some.tolist()]
    fifth = [_fifth(robot, row) for row in some]
    front, above, positive = (
        2 * sum(each) > len(some)
        for each in zip(
            *((at.is_front, at.is_above, value >= 0.0) for at, value in zip(stands, fifth, strict=True)), strict=True
        )
    )
    return _words(robot.maker, front, above, positive)


def _fifth(robot: Robot, joints: Scalars) -> float:
    """Give the sine of joint 5 of (6,) as the controller counts it."""
    degrees = np.degrees(joints)
    counted = degrees if robot.convention is None else robot.convention.count(tuple(degrees.tolist()))
    return float(np.round(np.sin(np.radians(counted[4])), 9))


def _words(maker: Maker | None, front: bool, above: bool, positive: bool) -> str:
    """Name by a maker's words where the wrist stands, the elbow, the sign of joint 5; as the exports state them.

    ABB numbers where the wrist's centre is before axis 1 and before the lower arm, and joint 5 (cfx of confdata); KUKA
    has the same as bits (S). Of an arm that reaches backwards with the elbow above, the centre is behind the lower arm.
    """
    forth = front == above
    match maker:
        case "abb":
            return f"cfx {4 * (not front) + 2 * (not forth) + (not positive)}"
        case "kuka":
            return f"S {int(not positive)}{int(forth)}{int(not front)}"
        case "fanuc":
            return f"{'F' if positive else 'N'} {'U' if above else 'D'} {'T' if front else 'B'}"
        case "epson":
            return f"/{'R' if front else 'L'} /{'A' if above else 'B'} /{'F' if positive else 'NF'}"
        case "mitsubishi":
            return f"{'R' if front else 'L'}, {'A' if above else 'B'}, {'N' if positive else 'F'}"
        case "staubli":
            signs = ("positive" if each else "negative" for each in (forth, positive))
            return f"{'righty' if front else 'lefty'}, {', '.join(map(''.join, zip('ew', signs, strict=True)))}"
        case "denso":
            words = "righty" if front else "lefty", "above" if above else "below"
        case "yaskawa":
            words = "front" if front else "back", "upper" if above else "lower"
        case _:
            words = "front" if front else "rear", "up" if above else "down"
    return f"{', '.join(words)}, J5{'+' if positive else '-'}"


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
