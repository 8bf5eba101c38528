"""Remedies for a cell that cannot do a program: edits of its file under which some points of the program are reached.

Classical mistakes come first, then limits that the cell tightened, then what changes least: the board, a tool's length,
a fixture. A remedy is tried at points, each on its own; whether the robot goes from one to the next needs a check.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from boards.board import Workpiece
from geometry.arrays import Indices
from robotcell.cell.cell import Cell
from robotcell.cell.load import LoadedCell
from robotcell.collision.collision import (
    Collider,
    build_collider,
    collides,
    fewest_obstacles,
    fixtures_through_base,
    with_board_at,
    with_fixture_moved,
)
from robotcell.collision.sweep import collides_between
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
from robotcell.motion.sampled_path import SampledPath
from robotcell.placement.reachability import Configurations, Targets, clear_of, configurations_at, measure, spread
from robotcell.robot.poses import inverse
from robotcell.robot.robot import limit_share

_MOST_TARGETS = 48
_FIRST_TARGETS = 6
"""The points tried first: most changes fail at one of them."""
_LEVER_M = 0.1
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
DEEP_M = 0.02
"""m that a fixture may reach into the robot's base: models are no more exact than this."""


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Where a changed cell is tried."""

    chosen: Targets
    """Far from one another; reached and clear. The first of them are tried first."""
    every: Targets
    """More of them; reached."""


def sample_points(path: SampledPath, nodes: Indices, wrong: Indices) -> Points:
    """Choose samples of a path, of those that are wrong and of all; with the board as the cell holds it."""
    chosen: list[Indices] = []
    for samples in (wrong, nodes):
        own = samples[path.placement[samples] == 0]
        if len(own):
            chosen.append(own[spread_samples(path, own, _MOST_TARGETS // 2)])
    at = np.concatenate([*chosen, np.zeros(0, dtype=np.int64)])
    own = nodes[path.placement[nodes] == 0]
    every = own[np.unique(np.linspace(0, len(own) - 1, _MOST_REACHED).astype(np.int64))] if len(own) else own
    return Points(*(_targets_at(path, some) for some in (at[np.sort(np.unique(at, return_index=True)[1])], every)))


def _targets_at(path: SampledPath, samples: Indices) -> Targets:
    return Targets(inverse(path.T_base_board[0]) @ path.T_base_tcp[samples], path.tool[samples], path.free[samples])


def spread_samples(path: SampledPath, samples: Indices, most: int) -> Indices:
    """Choose among samples (k,), the outermost first, poses that are far from one another: indices into them."""
    poses = path.T_base_tcp[samples]
    apart = np.column_stack((path.tool[samples], path.placement[samples])).astype(np.float64)
    return spread(np.hstack((poses[:, :3, 3], _LEVER_M * poses[:, :3, 2], apart)), most)


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
    families = (mistakes, shorter, wider_limits, small_changes, places)
    if through_base:
        families = (fixtures_moved,)
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
    first = _reached(case, cell, "first")
    if first is None:
        return None
    collider, clear = _collider_of(case, cell), list[Configurations]()
    for begin, end in ((0, 1), (1, few), (few, count)):
        found = first if end <= few else _reached(case, cell, "others")
        if found is None:
            return None
        clear.append(clear_of(cell, collider, case.targets, _of_targets(found, begin, end)))
        if len(np.unique(clear[-1].target)) < end - begin:
            return None
    used = (cell.tools[index].number for index in np.unique(case.targets.tool).tolist())
    if any(collides(collider, cell.home[None], number).any() for number in used):
        return None
    if cell.fixtures is not case.cell.fixtures and fixtures_through_base(collider, DEEP_M):
        return None
    if _reached(case, cell, "every") is None:
        return None
    fields = (np.concatenate([getattr(part, name) for part in clear]) for name in Configurations.__slots__)
    whole = Configurations(*fields)
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
    found = replace(solved, target=solved.target + begin) if is_whole else None
    if same:
        case.unmoved[which] = found
    return found


def _is_near_home(cell: Cell, collider: Collider, case: ChangeCase, clear: Configurations) -> bool:
    """Whether straight joint moves lead from home to each of the first targets, in some configuration of it."""
    for target in range(min(_FIRST_TARGETS, len(case.targets.tool))):
        q = clear.q[clear.target == target]
        q = q[np.argsort(np.round(np.abs(q - cell.home).max(axis=1), 6), kind="stable")[:_MOST_FROM_HOME]]
        number = cell.tools[int(case.targets.tool[target])].number
        if collides_between(collider, np.repeat(cell.home[None], len(q), axis=0), q, number).all():
            return False
    return True


def _of_targets(found: Configurations, begin: int, end: int) -> Configurations:
    kept = (found.target >= begin) & (found.target < end)
    return Configurations(found.target[kept], found.branch[kept], found.q[kept])


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


def _fixtures_in_the_way(cell: Cell, collider: Collider, targets: Targets) -> tuple[str, ...]:
    """Name the fixtures that block the least blocked configurations of the targets, those that do most often first."""
    found = configurations_at(cell, cell.T_cell_board, targets, AZIMUTHS)
    names = {body.name for body in cell.fixtures}
    met: dict[str, int] = {}
    for target in np.unique(found.target).tolist()[:_MOST_BLAMING]:
        number = cell.tools[int(targets.tool[target])].number
        q = found.q[found.target == target]
        rows = np.unique(np.linspace(0, len(q) - 1, _MOST_ROWS).astype(np.int64))
        for touch in fewest_obstacles(collider, q[rows], number):
            if touch.other in names:
                met[touch.other] = met.get(touch.other, 0) + 1
    return tuple(sorted(met, key=lambda name: (-met[name], name))[:_MOST_FIXTURES])
