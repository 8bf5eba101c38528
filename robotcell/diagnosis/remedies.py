"""Remedies for a cell that cannot do a program: edits of its file under which some points of the program are reached.

Classical mistakes come first, then limits that the cell tightened, then what changes least: the board, a tool's length,
a fixture. A remedy is tried at points, each on its own; whether the robot goes from one to the next needs a check.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from geometry.arrays import Indices
from robotcell.cell.cell import Cell, Tool
from robotcell.cell.cell_edits import (
    CellEdit,
    base_edit,
    board_edit,
    lengthened_tool,
    moved_body_edits,
    place_of,
    tcp_edit,
    tool_edits,
)
from robotcell.cell.load import LoadedCell, build_tool
from robotcell.cell.shapes import place_pose
from robotcell.collision.collision import (
    Collider,
    build_collider,
    fewest_obstacles,
    fixtures_through_base,
    with_board_at,
    with_fixture_moved,
)
from robotcell.diagnosis.plausibility import corners_of
from robotcell.motion.sampled_path import SampledPath
from robotcell.placement.reachability import Configurations, Targets, clear_of, configurations_at, spread
from robotcell.robot.poses import inverse, pose
from robotcell.robot.robot import Joints, Poses, flange_poses, limit_share

_AZIMUTHS = 8
_SHIFTS_MM = (20.0, 50.0, 100.0, 200.0, 300.0, 400.0, 600.0, 800.0, 1200.0, 1600.0)
_LENGTHS_MM = (30.0, 60.0, 100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0, 450.0, 500.0, 600.0, 800.0)
_YAWS_DEG = (30.0, 60.0, 90.0, 180.0)
_RADII_M = np.arange(0.1, 1.6, 0.05)
_LIFTS_M = (0.0, 0.1, -0.1, 0.2, -0.2, 0.3, -0.3)
_MOST_TARGETS = 48
_FIRST_TARGETS = 6
"""The points tried first: most changes fail at one of them."""
_FARTHEST_M = 20.0
"""No board or orifice is farther away."""
_LEVER_M = 0.1
_FROM_LIMIT = 0.02
"""Share of half a joint's range that a remedy in one configuration keeps from its limits."""
_MOST_FIXTURES = 3
_SPARE_AZIMUTHS = 4
"""Of those that are tried about a free jet: with fewer the robot may not get from one point to the next."""
_LONG_M = 0.4
"""Tools for boards are hardly ever longer: their length is looked at first then."""
_LONGER = 4.0
"""A longer tool bends and swings more: another place of the board is better, unless it is that much farther."""
_MOST_REACHED = 160
_MOST_SINCE = 40
"""Changes that are tried beyond the first that helps, for one in one configuration."""
_SPARE_DEG = 5.0
_MOST_BLAMING = 8
_MOST_ROWS = 24
"""Targets, and configurations of each, of which the fixtures in the way are counted."""
DEEP_M = 0.02
"""m that a fixture may reach into the robot's base: models are no more exact than this."""


@dataclass(frozen=True, slots=True, eq=False)
class Remedy:
    """A cell that differs in one thing."""

    text: str
    """The change, as a condition: ``"with the TCP turned ..."``."""
    cell: Cell
    edits: tuple[CellEdit, ...] = ()
    """The same in the cell's file; none where the cell was not read from one."""
    in_one: bool = False
    """Whether one configuration reaches all points that were tried, clear, away from limits, and at some azimuths."""


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Where a changed cell is tried."""

    chosen: Targets
    """Far from one another; reached and clear. The first of them are tried first."""
    every: Targets
    """More of them; reached."""


@dataclass(frozen=True, slots=True, eq=False)
class _Case:
    """A cell that is to be changed, and where it is tried."""

    cell: Cell
    board: Board | None
    targets: Targets
    first: Targets
    """Those that are tried first."""
    every: Targets
    collider: Collider
    loaded: LoadedCell | None
    blamed: tuple[str, ...]
    """Fixtures that are in the way, most first."""


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
    board: Board | None,
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
    case = _Case(cell, board, targets, _some(targets, _FIRST_TARGETS), points.every, collider, loaded, blamed)
    families = (_mistakes, _shorter, _wider_limits, _small_changes, _places)
    if through_base:
        families = (_fixtures_moved,)
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


def share_reached(cell: Cell, targets: Targets) -> float:
    """Give the share of the targets that some configuration within the limits reaches."""
    found = configurations_at(cell, cell.T_cell_board, targets, _AZIMUTHS)
    return len(np.unique(found.target)) / len(targets.tool)


def _some(targets: Targets, most: int) -> Targets:
    return Targets(targets.T_board_tcp[:most], targets.tool[:most], targets.free[:most])


def _tried(case: _Case, change: Remedy) -> Remedy | None:
    """Try a change at the targets; ``None`` where one is not reached, or not clear."""
    for targets in (case.first, case.every, case.targets):
        found = configurations_at(change.cell, change.cell.T_cell_board, targets, _AZIMUTHS)
        if len(np.unique(found.target)) < len(targets.tool):
            return None
    collider, count = _collider_of(case, change.cell), len(case.targets.tool)
    for begin, end in ((0, 1), (1, _FIRST_TARGETS), (_FIRST_TARGETS, count)):
        some = _of_targets(found, begin, min(end, count))
        if len(np.unique(clear_of(change.cell, collider, case.targets, some).target)) < min(end, count) - begin:
            return None
    if change.cell.fixtures is not case.cell.fixtures and fixtures_through_base(collider, DEEP_M):
        return None
    clear = clear_of(change.cell, collider, case.targets, found)
    return replace(change, in_one=_reached_in_one(change.cell, clear, case.targets))


def _of_targets(found: Configurations, begin: int, end: int) -> Configurations:
    kept = (found.target >= begin) & (found.target < end)
    return Configurations(found.target[kept], found.branch[kept], found.q[kept])


def _collider_of(case: _Case, cell: Cell) -> Collider:
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
    needed = np.where(targets.free & (cell.robot.dof >= 6), _SPARE_AZIMUTHS, 1)
    branch, target = clear.branch[away], clear.target[away]
    return any(
        bool(np.all(np.bincount(target[branch == each], minlength=len(needed)) >= needed)) for each in np.unique(branch)
    )


def _fixtures_in_the_way(cell: Cell, collider: Collider, targets: Targets) -> tuple[str, ...]:
    """Name the fixtures that block the least blocked configurations of the targets, those that do most often first."""
    found = configurations_at(cell, cell.T_cell_board, targets, _AZIMUTHS)
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


def _mistakes(case: _Case) -> Iterator[Remedy]:
    """Give the cell with each classical mistake undone."""
    cell = case.cell
    for axis, turn in (("X", (np.pi, 0.0, 0.0)), ("Y", (0.0, np.pi, 0.0))):
        turned = tuple(replace(tool, T_flange_tcp=tool.T_flange_tcp @ pose((0, 0, 0), turn)) for tool in cell.tools)
        yield from _with_tools(case, turned, f"turned by 180 degrees about its own {axis}")
    for axis, turn in (("X", (np.pi, 0.0, 0.0)), ("Y", (0.0, np.pi, 0.0))):
        text = f"with the board turned over about its own {axis} (it may be upside down)"
        yield _with_board(case, cell.held_pose @ pose((0, 0, 0), turn), text)
    for factor, text in ((1000.0, "metres were written for millimetres"), (1e-3, "millimetres were taken for metres")):
        moved = _scaled(cell.held_pose, factor)
        if np.abs(moved[:3, 3]).max() <= _FARTHEST_M:
            yield _with_board(case, moved, f"with the board's place times {factor:g} ({text})")
        scaled = tuple(replace(tool, T_flange_tcp=_scaled(tool.T_flange_tcp, factor)) for tool in cell.tools)
        if max(float(np.abs(tool.T_flange_tcp[:3, 3]).max()) for tool in scaled) <= _FARTHEST_M:
            yield from _with_tools(case, scaled, f"{factor:g} times as far from the flange ({text})")
    for degrees in (180.0, 90.0, -90.0):
        turned = cell.T_cell_base @ pose((0, 0, 0), (0, 0, np.radians(degrees)))
        edits = () if case.loaded is None else (base_edit(turned),)
        text = f"with the robot's base turned by {degrees:g} degrees about its axis"
        yield Remedy(text, replace(cell, T_cell_base=turned), edits)


def _wider_limits(case: _Case) -> Iterator[Remedy]:
    """Give the cell with limits that it tightens as wide as the targets need: of each such joint alone, then of all."""
    if case.loaded is None:
        return
    robot, own = case.cell.robot, case.loaded.unlimited
    tightened = [
        index
        for index, (now, wide) in enumerate(zip(robot.joints, own.joints, strict=True))
        if now.lowest > wide.lowest + 1e-9 or now.highest < wide.highest - 1e-9
    ]
    groups = [[index] for index in tightened] + ([tightened] if len(tightened) > 1 else [])
    for group in groups:
        yield from _widened(case, group)


def _widened(case: _Case, group: list[int]) -> Iterator[Remedy]:
    """Give the cell with the limits of some joints as wide as one configuration needs, narrowest first."""
    if case.loaded is None:
        return
    robot, own = case.cell.robot, case.loaded.unlimited
    free = list(robot.joints)
    for index in group:
        free[index] = replace(free[index], lowest=own.joints[index].lowest, highest=own.joints[index].highest)
    wide = replace(case.cell, robot=replace(robot, joints=tuple(free)))
    found = configurations_at(wide, wide.T_cell_board, case.targets, _AZIMUTHS)
    clear = clear_of(wide, case.collider, case.targets, found)
    ways: list[tuple[float, int, NDArray[np.float64]]] = []
    for branch in np.unique(clear.branch).tolist():
        mine = clear.branch == branch
        if len(np.unique(clear.target[mine])) == len(case.targets.tool):
            spans = _needed(clear.q[mine], clear.target[mine], robot.lowest, robot.highest)
            ways.append((float(np.sum(spans[1][group] - spans[0][group])), branch, spans))
    for _, _, (low, high) in sorted(ways, key=lambda way: way[:2]):
        joints, edits, words = list(robot.joints), list[CellEdit](), list[str]()
        for index in group:
            joint = joints[index]
            unit, key, name = (
                (1e3, "position_mm", "mm") if joint.kind == "prismatic" else (180 / np.pi, "position_deg", "degrees")
            )
            lowest = max(_SPARE_DEG * np.floor(unit * low[index] / _SPARE_DEG - 1.0), unit * own.joints[index].lowest)
            highest = min(_SPARE_DEG * np.ceil(unit * high[index] / _SPARE_DEG + 1.0), unit * own.joints[index].highest)
            span = [round(min(lowest, unit * joint.lowest), 4), round(max(highest, unit * joint.highest), 4)]
            joints[index] = replace(joint, lowest=span[0] / unit, highest=span[1] / unit)
            edits.append(CellEdit(("joints", joint.name, key), span))
            words.append(f"{joint.name} from {span[0]:g} to {span[1]:g} {name}")
        cell = replace(case.cell, robot=replace(robot, joints=tuple(joints)))
        yield Remedy(f"with the limits of {', '.join(words)}", cell, tuple(edits))


def _needed(q: Joints, target: Indices, lowest: Joints, highest: Joints) -> NDArray[np.float64]:
    """Give (2, dof) the span that some configuration of every target lies in, next to the present limits."""
    excess = np.maximum(np.maximum(lowest - q, q - highest), 0.0).max(axis=1)
    rows = [np.flatnonzero(target == each) for each in np.unique(target)]
    chosen = q[[int(row[np.argmin(np.round(excess[row], 9))]) for row in rows]]
    return np.stack((chosen.min(axis=0), chosen.max(axis=0)))


def _small_changes(case: _Case) -> Iterator[Remedy]:
    """Give the cell with the board, a tool's orifice or a fixture elsewhere, the smallest change first."""
    steps = [*_shifts(case), *_lengths(case), *_fixture_shifts(case)]
    for _, _, change in sorted(steps, key=lambda step: step[:2]):
        yield change


def _fixtures_moved(case: _Case) -> Iterator[Remedy]:
    """Give the cell with a fixture moved: first so that the robot stands on it, then the least move first."""
    for _, _, change in _fixture_shifts(case):
        yield change


def _shifts(case: _Case) -> Iterator[tuple[float, int, Remedy]]:
    """Give size, rank and the cell with the board moved along an axis, or turned."""
    for size, (axis, name), sign in product(_SHIFTS_MM, enumerate("xyz"), (1.0, -1.0)):
        T_cell_held = case.cell.held_pose.copy()
        T_cell_held[axis, 3] += sign * size * 1e-3
        text = f"with the board moved by {sign * size:+g} mm along the cell's {name}"
        yield size, 0, _with_board(case, T_cell_held, text)
    for degrees, sign in product(_YAWS_DEG, (1.0, -1.0)):
        turned = case.cell.held_pose @ pose((0, 0, 0), (0, 0, sign * np.radians(degrees)))
        text = f"with the board turned by {sign * degrees:+g} degrees about its own z"
        yield 2.0 * degrees, 1, _with_board(case, turned, text)


def _lengths(case: _Case) -> Iterator[tuple[float, int, Remedy]]:
    """Give size, rank and the cell with the tools that the targets need longer or shorter, all by as much."""
    if case.loaded is None:
        return
    numbers = [case.cell.tools[index].number for index in np.unique(case.targets.tool).tolist()]
    for size, (sign, word, weight) in product(_LENGTHS_MM, ((-1.0, "shorter", 1.0), (1.0, "longer", _LONGER))):
        tools, edits = list(case.cell.tools), list[CellEdit]()
        for number in numbers:
            before = case.loaded.spec.tools[number]
            after = lengthened_tool(before, sign * size)
            if after is None:
                break
            index = next(at for at, tool in enumerate(tools) if tool.number == number)
            tools[index] = build_tool(number, after, case.loaded.root)
            edits += tool_edits(number, before, after)
        else:
            names = " and ".join(f"tool {number} ({case.loaded.spec.tools[number].name})" for number in numbers)
            yield (
                weight * size,
                2,
                Remedy(f"with {names} {size:g} mm {word}", replace(case.cell, tools=tuple(tools)), tuple(edits)),
            )


def _shorter(case: _Case) -> Iterator[Remedy]:
    """Give the cell with its tools shorter, where one that the targets need is unusually long."""
    tools = [case.cell.tools[index] for index in np.unique(case.targets.tool).tolist()]
    if max(float(np.linalg.norm(tool.T_flange_tcp[:3, 3])) for tool in tools) >= _LONG_M:
        yield from (change for _, _, change in _lengths(case) if "shorter" in change.text)


def _fixture_shifts(case: _Case) -> Iterator[tuple[float, int, Remedy]]:
    """Give size, rank and the cell with a fixture that is in the way moved along an axis."""
    ways = [(name, *way) for way in product(_SHIFTS_MM, enumerate("xyz"), (-1.0, 1.0)) for name in case.blamed]
    for name in case.blamed:
        top = max(float(corners_of(body)[:, 2].max()) for body in case.cell.fixtures if body.name == name)
        size = round(1e3 * (top - float(case.cell.T_cell_base[2, 3])), 1)
        if size > 0.0:
            ways.insert(0, (name, size, (2, "z"), -1.0))  # so that the robot stands on it
    for name, size, (axis, letter), sign in ways:
        offset = np.zeros(3)
        offset[axis] = sign * size
        edits = ()
        if case.loaded is not None:
            edits = moved_body_edits(("fixtures", name), case.loaded.spec.fixtures[name], offset.tolist())
        moved = pose((1e-3 * offset).tolist(), (0, 0, 0))
        fixtures = tuple(
            replace(body, T_carrier_shape=moved @ body.T_carrier_shape) if body.name == name else body
            for body in case.cell.fixtures
        )
        text = f"with {name} moved by {sign * size:+g} mm along the cell's {letter}"
        yield size, 3, Remedy(text, replace(case.cell, fixtures=fixtures), edits)


def _places(case: _Case) -> Iterator[Remedy]:
    """Give the cell with the board at places before the robot, nearest to the present one first."""
    cell, base = case.cell, case.cell.T_cell_base
    centre = case.targets.T_board_tcp[:, :3, 3].mean(axis=0)
    middle = (inverse(base) @ cell.T_cell_board @ np.append(centre, 1.0))[:3]
    tip = _tip_at_home(cell, int(case.targets.tool[0]))
    offsets: list[NDArray[np.float64]] = []
    for toward, radius, lift, height in product((middle, tip), _RADII_M, _LIFTS_M, (middle[2], tip[2])):
        length = float(np.linalg.norm(toward[:2]))
        ahead = toward[:2] / length if length > 1e-6 else np.array([1.0, 0.0])
        offsets.append(base[:3, :3] @ (np.array([*(radius * ahead), height + lift]) - middle))
    for offset in sorted(offsets, key=lambda each: round(float(np.linalg.norm(each)), 6)):
        T_cell_held = cell.held_pose.copy()
        T_cell_held[:3, 3] += np.round(offset, 2)
        x, y, z = (1e3 * (T_cell_held - cell.held_pose)[:3, 3]).tolist()
        yield _with_board(case, T_cell_held, f"with the board moved by {x:+.0f}, {y:+.0f}, {z:+.0f} mm in the cell")


def _tip_at_home(cell: Cell, tool: int) -> NDArray[np.float64]:
    """(3,) where a tool's orifice is at home, base frame."""
    return (flange_poses(cell.robot, cell.home[None])[0] @ cell.tools[tool].T_flange_tcp)[:3, 3]


def _with_board(case: _Case, T_cell_held: Poses, text: str) -> Remedy:
    """Give the cell with the board held elsewhere, as it is written."""
    place = place_of(T_cell_held)
    edits = () if case.loaded is None else (board_edit(case.loaded.spec.board, place),)
    return Remedy(text, case.cell.with_held_at(place_pose(place)), edits)


def _with_tools(case: _Case, others: tuple[Tool, ...], text: str) -> Iterator[Remedy]:
    """Give the cell with all tools changed, and with each of several changed alone."""

    def edits_of(tools: Iterable[Tool]) -> tuple[CellEdit, ...]:
        return () if case.loaded is None else tuple(tcp_edit(tool.number, tool.T_flange_tcp) for tool in tools)

    yield Remedy(f"with the TCP {text}", replace(case.cell, tools=others), edits_of(others))
    for index, other in enumerate(others if len(others) > 1 else ()):
        tools = (*case.cell.tools[:index], other, *case.cell.tools[index + 1 :])
        name = f"with the TCP of tool {other.number} ({other.name}) {text}"
        yield Remedy(name, replace(case.cell, tools=tools), edits_of([other]))


def _scaled(T: Poses, factor: float) -> Poses:
    scaled = T.copy()
    scaled[:3, 3] *= factor
    return scaled
