"""What would help where a robot cannot do a program: edits of the cell.

Classical mistakes come first, then limits that the cell tightened, then what changes least: the board, a tool's length,
a fixture. A remedy is tried at points, each on its own; then it is checked as a whole, as points do not show the ways
between them.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from boards.board import Workpiece
from geometry.arrays import Indices
from robotcell.cell.cell import Cell
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
from robotcell.diagnosis.changes import AZIMUTHS, FAMILIES, ChangeCase, Remedy, Which, fixtures_moved
from robotcell.diagnosis.reasons import Diagnosis, PathInCell
from robotcell.diagnosis.refusals import DEEP_M
from robotcell.motion.sampled_path import SampledPath
from robotcell.placement.reachability import (
    Configurations,
    Targets,
    clear_of,
    configurations_at,
    measure,
    spread_samples,
)
from robotcell.robot.robot import inverse, limit_share
from specs.finding import Finding
from specs.finding_rules import CELL_REMEDY
from specs.progress import Progress, subprogress

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
    points = sample_points(subject.path, diagnosis.nodes, diagnosis.wrong)
    if not len(points[0].tool):
        return None
    most = _MOST_CHECKED
    if diagnosis.is_refusal:
        most = min(max(_SAMPLES_CHECKED // len(subject.path.times), 1), _MOST_AFTER_REFUSAL)

    def find(count: int) -> tuple[Remedy, ...]:
        cell, through = subject.queries.cell, diagnosis.through_base
        return find_remedies(cell, board, points, loaded, through_base=through, most=count)

    found = find(1 if diagnosis.is_refusal else _MOST_CHECKED)
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


def sample_points(path: SampledPath, nodes: Indices, wrong: Indices) -> tuple[Targets, Targets]:
    """Choose where a changed cell is tried, with the board as the cell holds it.

    Returns:
        Samples that are wrong, and of all, far from one another: they have to be reached and clear, the first of them
        are tried first. And more of them, which have to be reached.
    """
    wrong, nodes = (samples[path.placement[samples] == 0] for samples in (wrong, nodes))
    chosen = [each[spread_samples(path, each, _MOST_TARGETS // 2)] for each in (wrong, nodes) if len(each)]
    at = np.concatenate([*chosen, np.zeros(0, dtype=np.int64)])
    at = at[np.sort(np.unique(at, return_index=True)[1])]
    every = nodes
    if len(nodes):
        every = nodes[np.unique(np.linspace(0, len(nodes) - 1, _MOST_REACHED).astype(np.int64))]
    T_board_base = inverse(path.T_base_board[0])
    first, second = (
        Targets(T_board_base @ path.T_base_tcp[some], path.tool[some], path.free[some]) for some in (at, every)
    )
    return first, second


def find_remedies(
    cell: Cell,
    board: Workpiece | None,
    points: tuple[Targets, Targets],
    loaded: LoadedCell | None = None,
    *,
    through_base: Sequence[str] = (),
    most: int = 1,
) -> tuple[Remedy, ...]:
    """Find changes that make every point reachable and clear; each point is checked on its own.

    Args:
        cell: The cell.
        board: For collisions.
        points: What is to be reached and clear, at least one; and more of it, that is to be reached.
        loaded: The cell's file, for edits; without it tools keep their length and joints their limits.
        through_base: Fixtures that reach into the robot's base: no other change helps then.
        most: How many are looked for; the search ends with them.

    Returns:
        Those in one configuration first; otherwise in the order in which they are tried.
    """
    collider, (targets, every) = build_collider(cell, board), points
    blamed = tuple(through_base)
    if (
        not blamed
    ):  # fixtures that block the least blocked configurations of the targets, those that do most often first
        unmoved = configurations_at(cell, cell.T_cell_board, targets, AZIMUTHS)
        names, met = {body.name for body in cell.fixtures}, Counter[str]()
        for target in np.unique(unmoved.target).tolist()[:_MOST_BLAMING]:
            q, number = unmoved.q[unmoved.target == target], cell.tools[int(targets.tool[target])].number
            rows = np.unique(np.linspace(0, len(q) - 1, _MOST_ROWS).astype(np.int64))
            met.update(touch.other for touch in fewest_obstacles(collider, q[rows], number) if touch.other in names)
        blamed = tuple(sorted(met, key=lambda name: (-met[name], name))[:_MOST_FIXTURES])
    case = ChangeCase(cell, board, targets, every, collider, loaded, blamed)
    families = (fixtures_moved,) if through_base else FAMILIES
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
    return replace(change, in_one=_is_in_one(case, cell, collider, Configurations.joined(clear)))


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
    some = targets.taken(np.arange(begin, min(end, len(targets.tool))))
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


def _is_in_one(case: ChangeCase, cell: Cell, collider: Collider, clear: Configurations) -> bool:
    """Whether one branch reaches every target away from the joints' limits, at some azimuths where they are free.

    And whether straight joint moves lead from home to each of the first targets, in some configuration of it.
    """
    targets, away = case.targets, limit_share(cell.robot, clear.q) >= _FROM_LIMIT
    if cell.robot.dof >= 6:
        away &= measure(cell, clear.q, targets.tool[clear.target], "condition") >= _FROM_SINGULAR
    needed = np.where(targets.free & (cell.robot.dof >= 6), _SPARE_AZIMUTHS, 1)
    branch, target = clear.branch[away], clear.target[away]
    counts = (np.bincount(target[branch == each], minlength=len(needed)) for each in np.unique(branch))
    if not any(bool(np.all(count >= needed)) for count in counts):
        return False
    for first in range(min(_FIRST_TARGETS, len(targets.tool))):
        q = clear.q[clear.target == first]
        q = q[np.argsort(np.round(np.abs(q - cell.home).max(axis=1), 6), kind="stable")[:_MOST_FROM_HOME]]
        number = cell.tools[int(targets.tool[first])].number
        if collides_between(collider, np.repeat(cell.home[None], len(q), axis=0), q, number).all():
            return False
    return True
