"""Changes of a cell that may help: a mistake undone, wider limits, the board, a tool or a fixture elsewhere."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from robotcell.cell.cell import Cell, Tool, corners_of, place_pose
from robotcell.cell.cell_edits import (
    CellEdit,
    board_edit,
    lengthened_tool,
    moved_body_edits,
    place_of,
    pose_edit,
    tool_edits,
)
from robotcell.cell.load import LoadedCell, build_tool
from robotcell.collision.collision import Collider
from robotcell.placement.reachability import Configurations, Targets, clear_of, configurations_at
from robotcell.robot.robot import Joint, Joints, Poses, flange_poses, inverse, pose

Which: TypeAlias = Literal["first", "others", "every"]
"""Targets that are tried: a few first, the others of them, and more that need only be reached."""
AZIMUTHS = 8
"""Tried about a free jet."""
_SHIFTS_MM = (20.0, 50.0, 100.0, 200.0, 300.0, 400.0, 600.0, 800.0, 1200.0, 1600.0)
_LENGTHS_MM = (30.0, 60.0, 100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0, 450.0, 500.0, 600.0, 800.0)
_YAWS_DEG = (30.0, 60.0, 90.0, 180.0)
_RADII_M = np.arange(0.1, 1.6, 0.05)
_COARSE = 3
"""Of so many radii one is tried first, without a lift."""
_LIFTS_M = (0.0, 0.1, -0.1, 0.2, -0.2, 0.3, -0.3)
_FARTHEST_M = 20.0
"""No board or orifice is farther away."""
_LONG_M = 0.4
"""Tools for boards are hardly ever longer: their length is looked at first then."""
_USUAL_M = 0.3
"""Tried first then: straight lances that are much shorter lead some wrists through their singular configurations."""
_LONGER = 4.0
"""A longer tool bends and swings more: another place of the board is better, unless it is that much farther."""
_SPARE_DEG = 5.0
_FLIPS = {"X": pose((0, 0, 0), (np.pi, 0.0, 0.0)), "Y": pose((0, 0, 0), (0.0, np.pi, 0.0))}


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
class ChangeCase:
    """A cell that is to be changed, and where it is tried."""

    cell: Cell
    board: Workpiece | None
    targets: Targets
    every: Targets
    """More of them; only whether they are reached counts."""
    collider: Collider
    loaded: LoadedCell | None
    blamed: tuple[str, ...]
    """Fixtures that are in the way, most first."""
    unmoved: dict[Which, Configurations | None] = field(default_factory=dict["Which", "Configurations | None"])
    """Configurations of targets with robot, tools and board as they are; ``None`` where a target has none."""


def mistakes(case: ChangeCase) -> Iterator[Remedy]:
    """Give the cell with each classical mistake undone."""
    yield from _lowered_floors(case)
    cell = case.cell
    for axis, flip in _FLIPS.items():
        turned = tuple(replace(tool, T_flange_tcp=tool.T_flange_tcp @ flip) for tool in cell.tools)
        yield from _with_tools(case, turned, f"turned by 180 degrees about its own {axis}")
    for axis, flip in _FLIPS.items():
        text = f"with the board turned over about its own {axis} (it may be upside down)"
        yield _with_board(case, cell.held_pose @ flip, text)
    for factor, text in ((1000.0, "metres were written for millimetres"), (1e-3, "millimetres were taken for metres")):
        moved = _scaled(cell.held_pose, factor)
        if np.abs(moved[:3, 3]).max() <= _FARTHEST_M:
            yield _with_board(case, moved, f"with the board's place times {factor:g} ({text})")
        scaled = tuple(replace(tool, T_flange_tcp=_scaled(tool.T_flange_tcp, factor)) for tool in cell.tools)
        if max(float(np.abs(tool.T_flange_tcp[:3, 3]).max()) for tool in scaled) <= _FARTHEST_M:
            yield from _with_tools(case, scaled, f"{factor:g} times as far from the flange ({text})")
    for degrees in (180.0, 90.0, -90.0):
        base = cell.T_cell_base @ pose((0, 0, 0), (0, 0, np.radians(degrees)))
        edits = () if case.loaded is None else (pose_edit(("base",), base),)
        text = f"with the robot's base turned by {degrees:g} degrees about its axis"
        yield Remedy(text, replace(cell, T_cell_base=base), edits)


def wider_limits(case: ChangeCase) -> Iterator[Remedy]:
    """Give the cell with limits that it tightens as wide as the targets need: of each such joint alone, then of all."""
    if case.loaded is None:
        return
    own = case.loaded.unlimited.joints
    tightened = [
        index
        for index, (now, wide) in enumerate(zip(case.cell.robot.joints, own, strict=True))
        if now.lowest > wide.lowest + 1e-9 or now.highest < wide.highest - 1e-9
    ]
    groups = [[index] for index in tightened] + ([tightened] if len(tightened) > 1 else [])
    for group in groups:
        yield from _widened(case, group, own)


def _widened(case: ChangeCase, group: list[int], own: tuple[Joint, ...]) -> Iterator[Remedy]:
    """Give the cell with the limits of some joints as wide as one configuration needs, narrowest first."""
    robot = case.cell.robot
    free = list(robot.joints)
    for index in group:
        free[index] = replace(free[index], lowest=own[index].lowest, highest=own[index].highest)
    wide = replace(case.cell, robot=replace(robot, joints=tuple(free)))
    found = configurations_at(wide, wide.T_cell_board, case.targets, AZIMUTHS)
    clear = clear_of(wide, case.collider, case.targets, found)
    spans: list[tuple[Joints, Joints]] = []
    for branch in np.unique(clear.branch).tolist():
        q, target = clear.q[clear.branch == branch], clear.target[clear.branch == branch]
        rows = [np.flatnonzero(target == each) for each in np.unique(target)]
        if len(rows) == len(case.targets.tool):  # of each target the configuration next to the present limits
            excess = np.round(np.maximum(np.maximum(robot.lowest - q, q - robot.highest), 0.0).max(axis=1), 9)
            chosen = q[[int(row[np.argmin(excess[row])]) for row in rows]]
            spans.append((chosen.min(axis=0), chosen.max(axis=0)))
    for low, high in sorted(spans, key=lambda span: float(np.sum(span[1][group] - span[0][group]))):
        joints, edits, words = list(robot.joints), list[CellEdit](), list[str]()
        for index in group:
            joint, unit = joints[index], joints[index].unit.per_si
            lowest = max(_SPARE_DEG * np.floor(unit * low[index] / _SPARE_DEG - 1.0), unit * own[index].lowest)
            highest = min(_SPARE_DEG * np.ceil(unit * high[index] / _SPARE_DEG + 1.0), unit * own[index].highest)
            span = [round(min(lowest, unit * joint.lowest), 4), round(max(highest, unit * joint.highest), 4)]
            joints[index] = replace(joint, lowest=span[0] / unit, highest=span[1] / unit)
            edits.append(CellEdit(("joints", joint.name, f"position_{joint.unit.key}"), span))
            words.append(f"{joint.name} from {span[0]:g} to {span[1]:g} {joint.unit.word}")
        cell = replace(case.cell, robot=replace(robot, joints=tuple(joints)))
        yield Remedy(f"with the limits of {', '.join(words)}", cell, tuple(edits))


def small_changes(case: ChangeCase) -> Iterator[Remedy]:
    """Give the cell with the board, a tool's orifice or a fixture elsewhere, the smallest change first."""
    steps = [*_shifts(case), *_lengths(case), *_fixture_shifts(case)]
    for _, _, change in sorted(steps, key=lambda step: step[:2]):
        yield change


def fixtures_moved(case: ChangeCase) -> Iterator[Remedy]:
    """Give the cell with a fixture moved: first so that the robot stands on it, then the least move first."""
    yield from _lowered_floors(case)
    for _, _, change in _fixture_shifts(case):
        yield change


def _lowered_floors(case: ChangeCase) -> Iterator[Remedy]:
    """Give the cell with a fixture in the way lowered so that the robot stands on it, if it is under the base."""
    x, y, z = case.cell.T_cell_base[:3, 3].tolist()
    for name in case.blamed:
        corners = np.concatenate([corners_of(body) for body in case.cell.fixtures if body.name == name])
        low, high = corners.min(axis=0), corners.max(axis=0)
        size = round(1e3 * (float(high[2]) - z), 1)
        if low[0] < x < high[0] and low[1] < y < high[1] and size > 0.0:
            yield _with_fixture_moved(case, name, (2, "z"), -size)


def _shifts(case: ChangeCase) -> Iterator[tuple[float, int, Remedy]]:
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


def _lengths(case: ChangeCase) -> Iterator[tuple[float, int, Remedy]]:
    """Give size, rank and the cell with tools that the targets need longer or shorter: those of one length, or all."""
    if case.loaded is None:
        return
    tools = case.cell.tools  # as long as each that the targets need, then all these where they differ
    lengths = sorted({round(_length(tools[index]), 4) for index in np.unique(case.targets.tool).tolist()})
    groups = [[tool.number for tool in tools if abs(_length(tool) - length) < 1e-4] for length in lengths]
    groups += [sorted({number for group in groups for number in group})] if len(groups) > 1 else []
    ways = product(_LENGTHS_MM, ((-1.0, "shorter", 1.0), (1.0, "longer", _LONGER)), groups)
    for size, (sign, word, weight), numbers in ways:
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
            text = f"with {names} {size:g} mm {word}"
            yield weight * size, 2, Remedy(text, replace(case.cell, tools=tuple(tools)), tuple(edits))


def shorter(case: ChangeCase) -> Iterator[Remedy]:
    """Give the cell with its tools shorter where one of them is unusually long: the usual length first."""
    used = np.unique(case.targets.tool).tolist()

    def longest(cell: Cell) -> float:
        return max(_length(cell.tools[index]) for index in used)

    if longest(case.cell) >= _LONG_M:
        changes = [change for _, _, change in _lengths(case) if longest(change.cell) < longest(case.cell) - 1e-6]
        yield from sorted(changes, key=lambda each: round(abs(longest(each.cell) - _USUAL_M), 6))


def _length(tool: Tool) -> float:
    return float(np.linalg.norm(tool.T_flange_tcp[:3, 3]))


def _fixture_shifts(case: ChangeCase) -> Iterator[tuple[float, int, Remedy]]:
    """Give size, rank and the cell with a fixture that is in the way moved along an axis."""
    for size, axis, sign in product(_SHIFTS_MM, enumerate("xyz"), (-1.0, 1.0)):
        for name in case.blamed:
            yield size, 3, _with_fixture_moved(case, name, axis, sign * size)


def _with_fixture_moved(case: ChangeCase, name: str, axis: tuple[int, str], by_mm: float) -> Remedy:
    """Give the cell with a fixture moved along an axis of the cell."""
    offset = np.zeros(3)
    offset[axis[0]] = by_mm
    edits = ()
    if case.loaded is not None:
        edits = moved_body_edits(("fixtures", name), case.loaded.spec.fixtures[name], offset.tolist())
    moved = pose((1e-3 * offset).tolist(), (0, 0, 0))
    fixtures = tuple(
        replace(body, T_carrier_shape=moved @ body.T_carrier_shape) if body.name == name else body
        for body in case.cell.fixtures
    )
    text = f"with {name} moved by {by_mm:+g} mm along the cell's {axis[1]}"
    return Remedy(text, replace(case.cell, fixtures=fixtures), edits)


def places(case: ChangeCase) -> Iterator[Remedy]:
    """Give the cell with the board at places before the robot, some far apart first, each time the nearest first."""
    cell, base = case.cell, case.cell.T_cell_base
    middle = (inverse(base) @ cell.T_cell_board @ case.targets.middle)[:3]
    tool = cell.tools[int(case.targets.tool[0])]
    tip = (flange_poses(cell.robot, cell.home[None])[0] @ tool.T_flange_tcp)[:3, 3]
    offsets: list[tuple[bool, NDArray[np.float64]]] = []
    ways = product((middle, tip), enumerate(_RADII_M), _LIFTS_M, (middle[2], tip[2]))
    for toward, (number, radius), lift, height in ways:
        length = float(np.linalg.norm(toward[:2]))
        ahead = toward[:2] / length if length > 1e-6 else np.array([1.0, 0.0])
        offset = base[:3, :3] @ (np.array([*(radius * ahead), height + lift]) - middle)
        offsets.append((number % _COARSE != 0 or lift != 0.0, offset))
    for _, offset in sorted(offsets, key=lambda each: (each[0], round(float(np.linalg.norm(each[1])), 6))):
        T_cell_held = cell.held_pose.copy()
        T_cell_held[:3, 3] += np.round(offset, 2)
        x, y, z = (1e3 * (T_cell_held - cell.held_pose)[:3, 3]).tolist()
        yield _with_board(case, T_cell_held, f"with the board moved by {x:+z.0f}, {y:+z.0f}, {z:+z.0f} mm in the cell")


def _with_board(case: ChangeCase, T_cell_held: Poses, text: str) -> Remedy:
    """Give the cell with the board held elsewhere, as it is written."""
    place = place_of(T_cell_held)
    edits = () if case.loaded is None else (board_edit(case.loaded.spec.board, place),)
    return Remedy(text, case.cell.with_held_at(place_pose(place)), edits)


def _with_tools(case: ChangeCase, others: tuple[Tool, ...], text: str) -> Iterator[Remedy]:
    """Give the cell with all tools changed, and with each of several changed alone."""

    def edits_of(tools: Iterable[Tool]) -> tuple[CellEdit, ...]:
        return (
            ()
            if case.loaded is None
            else tuple(pose_edit(("tools", str(tool.number), "tcp"), tool.T_flange_tcp) for tool in tools)
        )

    yield Remedy(f"with the TCP {text}", replace(case.cell, tools=others), edits_of(others))
    for index, other in enumerate(others if len(others) > 1 else ()):
        tools = (*case.cell.tools[:index], other, *case.cell.tools[index + 1 :])
        name = f"with the TCP of tool {other.number} ({other.name}) {text}"
        yield Remedy(name, replace(case.cell, tools=tools), edits_of([other]))


def _scaled(T: Poses, factor: float) -> Poses:
    scaled = T.copy()
    scaled[:3, 3] *= factor
    return scaled


FAMILIES = (mistakes, shorter, wider_limits, small_changes, places)
"""In the order in which they are tried."""
