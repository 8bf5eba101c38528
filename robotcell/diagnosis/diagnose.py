"""What keeps a robot from a program, or changes it, and what would help: findings, and edits of the cell.

Classical mistakes come first, then limits that the cell tightened, then what changes least: the board, a tool's length,
a fixture. A remedy is tried at points, each on its own; then it is checked as a whole, as points do not show the ways
between them.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from boards.board import Workpiece
from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import Cell
from robotcell.cell.hold import describe_held, plan_bounds_mm
from robotcell.cell.load import LoadedCell
from robotcell.collision.collision import (
    Collider,
    build_collider,
    collides,
    collides_between,
    fewest_obstacles,
    fixtures_through_base,
    with_board_at,
    with_fixture_moved,
)
from robotcell.diagnosis.changes import (
    AZIMUTHS,
    ChangeCase,
    Remedy,
    Which,
    fixtures_moved,
    mistakes,
    places,
    shorter,
    small_changes,
    wider_limits,
)
from robotcell.diagnosis.plausibility import check_cell
from robotcell.diagnosis.reasons import (
    DEEP_M,
    PathInCell,
    Refusal,
    breaks,
    collisions,
    nearly_singular,
    slowness,
    tilts,
    unreachable,
)
from robotcell.motion.cell_queries import HomeMoves, Reconfiguration
from robotcell.motion.plan_joints import OutOfReach
from robotcell.motion.retime import Retiming
from robotcell.motion.sampled_path import SampledPath
from robotcell.motion.track_attempt import Motion
from robotcell.placement.reachability import (
    Configurations,
    Targets,
    clear_of,
    configurations_at,
    measure,
    spread_samples,
)
from robotcell.robot.robot import flange_poses, inverse, limit_share
from specs.finding import Finding, worst_first
from specs.finding_rules import BOARD_NOT_CHECKED, CELL_REMEDY, HOME_BLOCKED, TOOL_CHANGE_ABOVE_BOARD
from specs.progress import Progress, subprogress

_MM = 1e3
_MOST_TARGETS = 48
_FIRST_TARGETS = 6
"""The points tried first: most changes fail at one of them."""
_FROM_LIMIT = 0.02
"""Share of half a joint's range that a remedy in one configuration keeps from its limits."""
_MOST_FIXTURES = 3
_FROM_SINGULAR = 0.05
"""Inverse condition that it keeps."""
_MOST_FROM_HOME = 8
_SPARE_AZIMUTHS = 4
"""Of those that are tried about a free jet: with fewer the robot may not get from one point to the next."""
_MOST_REACHED = 160
_MOST_SINCE = 40
"""Changes that are tried beyond the first that helps, for one in one configuration."""
_MOST_BLAMING = 8
_MOST_ROWS = 24
"""Targets, and configurations of each, of which the fixtures in the way are counted."""
_MOST_CHECKED = 2
"""Remedies that are checked as a whole after a search."""
_MOST_AFTER_REFUSAL = 4
"""The same after a cheap refusal, in a program of few samples."""
_SAMPLES_CHECKED = 40_000
"""Samples of the path in all these checks."""


class CarriedOut(NamedTuple):
    """How the robot carries a motion out."""

    retiming: Retiming
    condition: Scalars
    """(n,) inverse condition at the samples."""


@dataclass(frozen=True, slots=True, eq=False)
class Diagnosis:
    """What is wrong with a program in a cell, and where."""

    findings: tuple[Finding, ...]
    """Worst first."""
    nodes: Indices
    """Samples of the path at which configurations are chosen."""
    wrong: Indices
    """Those that are not reached, not clear or not in one go; none where no other place of anything would help."""
    refusal: Refusal | None = None
    """Set where a cheap rule refused the cell."""


def diagnose(
    subject: PathInCell,
    board: Workpiece | None,
    outcome: Refusal | OutOfReach | Motion,
    home: HomeMoves | None = None,
    carried_out: CarriedOut | None = None,
) -> Diagnosis:
    """Give the findings on a program in a cell, with their reasons.

    Args:
        subject: The path in the cell; as it is tracked where there is a motion.
        board: With which collisions were checked.
        outcome: Of the search for a motion.
        home: Moves from and to home, if they were looked for.
        carried_out: How the motion is carried out, if it was timed.
    """
    match outcome:
        case Refusal():
            findings, nodes, wrong = [*outcome.findings], outcome.nodes, outcome.wrong
        case OutOfReach():
            nodes, wrong = outcome.nodes.sample, outcome.nodes.sample[outcome.empty]
            findings = [*unreachable(subject, wrong)]
        case Motion():
            nodes, wrong = outcome.nodes.sample, np.union1d(outcome.hits, outcome.broken)
            findings = [*breaks(subject, outcome), *collisions(subject, outcome)]
    if not isinstance(outcome, Motion) or len(outcome.broken):
        findings = [*check_cell(subject.queries.cell, board), *findings]
    elif home is not None:
        findings += _check_home(subject, home)
        if carried_out is not None:
            findings += [*tilts(subject, outcome.tracked)]
            findings += _check_tool_changes(subject, board, outcome.reconfigurations)
            findings += nearly_singular(subject, carried_out.condition)
            findings += [*slowness(subject, carried_out.retiming), *_check_board(subject, board)]
    return Diagnosis(worst_first(findings), nodes, wrong, outcome if isinstance(outcome, Refusal) else None)


def _check_home(subject: PathInCell, home: HomeMoves) -> Iterator[Finding]:
    """Report where the way from home to the beginning, or back from the end, is blocked."""
    last = len(subject.path.times) - 1
    for at, way, text in ((0, home.out, "from home to the beginning"), (last, home.back, "from the end back home")):
        if len(way) < 2:
            message = f"every joint move {text} that was tried collides; choose another home, or move there by hand."
            yield subject.finding(HOME_BLOCKED, message, at)


def _check_tool_changes(
    subject: PathInCell, board: Workpiece | None, moves: Sequence[Reconfiguration]
) -> Iterator[Finding]:
    """Report the first change of a tool whose orifice is above the board, or below it."""
    cell, path = subject.queries.cell, subject.path
    if board is None:
        return
    for move in moves:
        row = move.way[move.change : move.change + 1]
        for sample in (move.begin, move.end) if move.change else ():
            T_base_tcp = flange_poses(cell.robot, row)[0] @ cell.tools[int(path.tool[sample])].T_flange_tcp
            place = np.linalg.inv(path.T_base_board[int(path.placement[sample])]) @ T_base_tcp[:, 3]
            left, front, right, back, _ = plan_bounds_mm(board)
            if left <= _MM * place[0] <= right and front <= _MM * place[1] <= back:
                key = "home_deg_mm" if cell.tool_change is None else "tool_change_deg_mm"
                message = (
                    f"the tool is changed above {board.name}, at {key} of cell {cell.name}: what drips or falls there "
                    "lands on it. State joints beside the board under tool_change_deg_mm."
                )
                yield subject.finding(TOOL_CHANGE_ABOVE_BOARD, message, move.end)
                return


def _check_board(subject: PathInCell, board: Workpiece | None) -> Iterator[Finding]:
    """Report a board that is not known, and what was taken for its place."""
    if board is None:
        name, held_by = subject.queries.program.origin.board, subject.queries.cell.held_by
        message = f"the board {name} was not found: collisions with it were not checked"
        if held_by != "origin":
            point = describe_held(held_by)
            message += f", and the origin of its file was taken for the {point} that the cell holds it by"
        yield Finding(BOARD_NOT_CHECKED, f"{message}. Name it with --board.")


def find_remedy(
    subject: PathInCell,
    board: Workpiece | None,
    diagnosis: Diagnosis,
    loaded: LoadedCell | None,
    is_possible: Callable[[Cell, Progress], bool],
    progress: Progress,
) -> tuple[Remedy | None, Finding] | None:
    """Find the change of a cell with which the robot can do the program, and report it.

    Args:
        subject: The path in the cell.
        board: For collisions.
        diagnosis: What is wrong.
        loaded: The cell's file, for edits.
        is_possible: Checks a cell as a whole.
        progress: Receives the share done.

    Returns:
        ``None`` where no change helps at the points; no remedy, but a finding, where none passes the whole check.
    """
    cell, refusal = subject.queries.cell, diagnosis.refusal
    points = sample_points(subject.path, diagnosis.nodes, diagnosis.wrong)
    if not len(points.chosen.tool):
        return None
    through, most = (), _MOST_CHECKED
    if refusal is not None:
        through = refusal.through_base
        most = min(max(_SAMPLES_CHECKED // len(subject.path.times), 1), _MOST_AFTER_REFUSAL)

    def find(count: int) -> tuple[Remedy, ...]:
        return find_remedies(cell, board, points, loaded, through_base=through, most=count)

    found = find(1 if refusal is not None else _MOST_CHECKED)
    if not found:
        return None
    for number in range(most):
        if number == len(found) == 1:  # others than the first only where that fails
            found = find(most)
        if number >= len(found):
            break
        remedy = found[number]
        if is_possible(remedy.cell, subprogress(progress, number / most, (number + 1) / most)):
            edits = f" Write in the cell: {'; '.join(map(str, remedy.edits))}" if remedy.edits else ""
            text = f"{remedy.text} the robot can do the program, which was checked as a whole.{edits}"
            return remedy, Finding(CELL_REMEDY, text)
    changes = "; ".join(each.text for each in found[:most])
    text = (
        f"no single change was found with which the robot can do the program; checked as a whole, {changes}: each "
        "leaves an error. Clear the space about robot and board, then check again."
    )
    return None, Finding(CELL_REMEDY, text)


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Where a changed cell is tried."""

    chosen: Targets
    """Far from one another; reached and clear. The first of them are tried first."""
    every: Targets
    """More of them; reached."""


def sample_points(path: SampledPath, nodes: Indices, wrong: Indices) -> Points:
    """Choose samples of a path, of those that are wrong and of all; with the board as the cell holds it."""
    wrong, nodes = (samples[path.placement[samples] == 0] for samples in (wrong, nodes))
    chosen = [each[spread_samples(path, each, _MOST_TARGETS // 2)] for each in (wrong, nodes) if len(each)]
    at = np.concatenate([*chosen, np.zeros(0, dtype=np.int64)])
    at = at[np.sort(np.unique(at, return_index=True)[1])]
    every = nodes
    if len(nodes):
        every = nodes[np.unique(np.linspace(0, len(nodes) - 1, _MOST_REACHED).astype(np.int64))]
    T_board_base = inverse(path.T_base_board[0])
    return Points(
        *(Targets(T_board_base @ path.T_base_tcp[some], path.tool[some], path.free[some]) for some in (at, every))
    )


def find_remedies(
    cell: Cell,
    board: Workpiece | None,
    points: Points,
    loaded: LoadedCell | None = None,
    *,
    through_base: Sequence[str] = (),
    most: int = 1,
) -> tuple[Remedy, ...]:
    """Find changes that make every point reachable and clear; each point is checked on its own.

    Args:
        cell: The cell.
        board: For collisions.
        points: What is to be reached, at least one.
        loaded: The cell's file, for edits; without it tools keep their length and joints their limits.
        through_base: Fixtures that reach into the robot's base: no other change helps then.
        most: How many are looked for; the search ends with them.

    Returns:
        Those in one configuration first; otherwise in the order in which they are tried.
    """
    collider, targets = build_collider(cell, board), points.chosen
    blamed = tuple(through_base) or _fixtures_in_the_way(cell, collider, targets)
    case = ChangeCase(cell, board, targets, points.every, collider, loaded, blamed)
    families = (fixtures_moved,) if through_base else (mistakes, shorter, wider_limits, small_changes, places)
    found: list[Remedy] = []
    since = 0
    for change in (each for family in families for each in family(case)):
        tried = _tried(case, change)
        if tried is not None:
            found.append(tried)
        since += len(found) > 0
        if sum(each.in_one for each in found) >= most or since > _MOST_SINCE:
            break
    return tuple(sorted(found, key=lambda each: not each.in_one)[:most])


def _tried(case: ChangeCase, change: Remedy) -> Remedy | None:
    """Try a change at the targets, a few first; ``None`` where one is not reached, or not clear."""
    cell, count = change.cell, len(case.targets.tool)
    few = min(_FIRST_TARGETS, count)
    found = _reached(case, cell, "first")
    if found is None:
        return None
    collider, clear = _collider_of(case, cell), list[Configurations]()
    for begin, end in ((0, 1), (1, few), (few, count)):
        found = found if end <= few else _reached(case, cell, "others")
        if found is None:
            return None
        some = found.taken((found.target >= begin) & (found.target < end))
        clear.append(clear_of(cell, collider, case.targets, some))
        if len(np.unique(clear[-1].target)) < end - begin:
            return None
    used = (cell.tools[index].number for index in np.unique(case.targets.tool).tolist())
    if any(collides(collider, cell.home[None], number).any() for number in used):
        return None
    if cell.fixtures is not case.cell.fixtures and fixtures_through_base(collider, DEEP_M):
        return None
    if _reached(case, cell, "every") is None:
        return None
    whole = Configurations.joined(clear)
    in_one = _reached_in_one(cell, whole, case.targets) and _is_near_home(cell, collider, case, whole)
    return replace(change, in_one=in_one)


def _reached(case: ChangeCase, cell: Cell, which: Which) -> Configurations | None:
    """Give the configurations of some targets in a changed cell; ``None`` where one of them has none.

    They do not depend on fixtures: where only these are moved they are solved once.
    """
    same = cell.fixtures is not case.cell.fixtures
    if same and which in case.unmoved:
        return case.unmoved[which]
    begin = min(_FIRST_TARGETS, len(case.targets.tool)) if which == "others" else 0
    targets = case.every if which == "every" else case.targets
    end = _FIRST_TARGETS if which == "first" else len(targets.tool)
    some = Targets(targets.T_board_tcp[begin:end], targets.tool[begin:end], targets.free[begin:end])
    solved = configurations_at(cell, cell.T_cell_board, some, AZIMUTHS)
    is_whole = len(np.unique(solved.target)) == len(some.tool)
    found = solved._replace(target=solved.target + begin) if is_whole else None
    if same:
        case.unmoved[which] = found
    return found


def _collider_of(case: ChangeCase, cell: Cell) -> Collider:
    """Give the collider of a changed cell; built anew only where more than the board has moved."""
    if cell.tools is case.cell.tools and cell.T_cell_base is case.cell.T_cell_base:
        if cell.fixtures is case.cell.fixtures:
            return with_board_at(case.collider, cell.T_cell_board)
        for now, before in zip(cell.fixtures, case.cell.fixtures, strict=True):
            if now is not before:
                offset = now.T_carrier_shape[:3, 3] - before.T_carrier_shape[:3, 3]
                return with_fixture_moved(case.collider, now.name, offset)
    return build_collider(cell, case.board)


def _reached_in_one(cell: Cell, clear: Configurations, targets: Targets) -> bool:
    """Whether one branch reaches every target away from the joints' limits, at some azimuths where they are free."""
    away = limit_share(cell.robot, clear.q) >= _FROM_LIMIT
    if cell.robot.dof >= 6:
        away &= measure(cell, clear.q, targets.tool[clear.target], "condition") >= _FROM_SINGULAR
    needed = np.where(targets.free & (cell.robot.dof >= 6), _SPARE_AZIMUTHS, 1)
    branch, target = clear.branch[away], clear.target[away]
    return any(
        bool(np.all(np.bincount(target[branch == each], minlength=len(needed)) >= needed)) for each in np.unique(branch)
    )


def _is_near_home(cell: Cell, collider: Collider, case: ChangeCase, clear: Configurations) -> bool:
    """Whether straight joint moves lead from home to each of the first targets, in some configuration of it."""
    for target in range(min(_FIRST_TARGETS, len(case.targets.tool))):
        q = clear.q[clear.target == target]
        q = q[np.argsort(np.round(np.abs(q - cell.home).max(axis=1), 6), kind="stable")[:_MOST_FROM_HOME]]
        number = cell.tools[int(case.targets.tool[target])].number
        if collides_between(collider, np.repeat(cell.home[None], len(q), axis=0), q, number).all():
            return False
    return True


def _fixtures_in_the_way(cell: Cell, collider: Collider, targets: Targets) -> tuple[str, ...]:
    """Name the fixtures that block the least blocked configurations of the targets, those that do most often first."""
    found = configurations_at(cell, cell.T_cell_board, targets, AZIMUTHS)
    names, met = {body.name for body in cell.fixtures}, Counter[str]()
    for target in np.unique(found.target).tolist()[:_MOST_BLAMING]:
        number = cell.tools[int(targets.tool[target])].number
        q = found.q[found.target == target]
        rows = np.unique(np.linspace(0, len(q) - 1, _MOST_ROWS).astype(np.int64))
        met.update(touch.other for touch in fewest_obstacles(collider, q[rows], number) if touch.other in names)
    return tuple(sorted(met, key=lambda name: (-met[name], name))[:_MOST_FIXTURES])
