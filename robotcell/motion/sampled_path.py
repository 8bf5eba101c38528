"""The course of the TCP through a program, dense enough for the joints. Metres, seconds, board frame."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Quaternions, Scalars
from geometry.frames import rotation_angles, slerp
from programs.playback import Timeline, build_timeline
from programs.program import Command, MoveTo, TimedProgram, Wait
from robotcell.cell.cell import Cell
from robotcell.errors import CellError
from robotcell.robot.robot import Poses

Flags: TypeAlias = NDArray[np.bool_]

STEP_M = 5e-3
"""Samples are never farther apart than this,"""
STEP_RAD = np.radians(3.0)
"""nor turned by more than this,"""
STEP_S = 0.1
"""nor, while the TCP moves, apart in time by more than this."""
_TURNS = ("flip_to_top", "flip_to_bottom")
"""What a plan calls when the side changes; the cell holds the board with its top up."""


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """The moves of a program, both ends of its waits, and what was put between them: n samples in order."""

    times: Scalars
    """(n,) the program's own clock, s."""
    T_base_tcp: Poses
    """(n, 4, 4) as the program asks for it, seen from the robot's base."""
    T_base_board: Poses
    """(p, 4, 4) where the board may be: as the cell holds it, and turned over."""
    placement: Indices
    """(n,) which of these holds."""
    instruction: Indices
    """(n,) the move or wait that the sample is, or leads to; ascending."""
    exact: Flags
    """(n,) whether it is the pose of that ``MoveTo`` itself."""
    tool: Indices
    """(n,) index into the cell's tools."""
    changed: Flags
    """(n,) whether the tool was changed, or the board turned, since the sample before it."""
    wet: Flags
    """(n,) whether the jet is on just before or just after it."""
    free: Flags
    """(n,) whether the azimuth about the jet may be anything: the jet is off, or it is round."""
    held: Flags
    """(n,) whether the TCP rests from this sample to the next."""


def course_of(
    program: TimedProgram, cell: Cell, round_nozzles: frozenset[str], placements: Mapping[str, Poses]
) -> Course:
    """Lay out where the TCP goes.

    Args:
        program: The program; it has at least one move.
        cell: Whose tools the program names.
        round_nozzles: Names of nozzles whose jet is the same all around its axis.
        placements: T_cell_board (4, 4) after ``CALL name``, by that name.

    Raises:
        CellError: The program asks for a tool or a turn of the board that the cell does not know.
        ProgramError: The program has no move.
    """
    timeline = build_timeline(program)
    owner, exact = _owners(program)
    states = _states(program, cell, round_nozzles, placements)
    keys, state, fresh, jump = _string(owner, states)
    laid = _fill(timeline, keys, fresh | jump)
    parent = laid.parent
    wet = _wet(timeline, laid.times)
    T_base_cell = np.linalg.inv(cell.T_cell_base)
    T_base_board = T_base_cell @ np.stack((cell.T_cell_board, *placements.values()))
    placement = states.placement[state][parent]
    return Course(
        times=laid.times,
        T_base_tcp=T_base_board[placement] @ _matrices(laid.tcp, laid.quaternion),
        T_base_board=T_base_board,
        placement=placement,
        instruction=np.where(fresh, state, owner[keys])[parent],
        exact=laid.is_key & (exact[keys] & ~fresh)[parent],
        tool=states.tool[state][parent],
        changed=laid.is_key & (fresh | jump)[parent],
        wet=wet,
        free=~wet | states.is_round[state][parent],
        held=laid.held,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _States:
    """What holds while each instruction runs: one row for each."""

    tool: Indices
    placement: Indices
    is_round: Flags
    turning: Flags
    """Whether it moves around the board's edge while the board is turned over: the robot waits for that."""


@dataclass(frozen=True, slots=True, eq=False)
class _Laid:
    """Key poses and what lies between them."""

    times: Scalars
    tcp: NDArray[np.float64]
    quaternion: Quaternions
    parent: Indices
    """(n,) the key pose that each sample is or leads to."""
    is_key: Flags
    held: Flags


def _owners(program: TimedProgram) -> tuple[Indices, Flags]:
    """Give the instruction of each key pose of the timeline, and whether it is the pose of a move."""
    moves = [at for at, item in enumerate(program.instructions) if isinstance(item, MoveTo)]
    waits = [at for at, item in enumerate(program.instructions) if isinstance(item, Wait)]
    owner = np.sort(np.array([*moves, *waits, *waits], dtype=np.int64))
    return owner, np.isin(owner, np.array(moves, dtype=np.int64))


def _states(
    program: TimedProgram, cell: Cell, round_nozzles: frozenset[str], placements: Mapping[str, Poses]
) -> _States:
    if not cell.tools:
        raise CellError(f"cell {cell.name} has no tool. Add one.", path="tools")
    tool, placement, is_round, turned_by = 0, 0, False, None
    rows: list[tuple[int, int, bool, bool]] = []
    for item in program.instructions:
        if item.made_by != turned_by:
            turned_by = None
        if isinstance(item, Command) and item.keyword == "NOZZLE":
            tool, is_round = _tool_of(item, cell), item.arguments[0] in round_nozzles
        elif isinstance(item, Command) and item.keyword == "CALL" and _turns_board(item, placements):
            placement, turned_by = _placement_of(item, cell, placements), item.made_by
        rows.append((tool, placement, is_round, turned_by is not None and isinstance(item, MoveTo)))
    table = np.array(rows, dtype=np.int64)
    return _States(table[:, 0], table[:, 1], table[:, 2] > 0, table[:, 3] > 0)


def _tool_of(item: Command, cell: Cell) -> int:
    name, number = item.arguments[0], int(item.arguments[2])
    for index, tool in enumerate(cell.tools):
        if tool.number == number:
            return index
    known = ", ".join(str(tool.number) for tool in cell.tools)
    raise CellError(
        f"the program asks for tool {number} (nozzle {name}, {item.made_by}), and cell {cell.name} has {known}. "
        "Add the tool to the cell, or change the nozzle's tool in the recipe.",
        path="tools",
    )


def _turns_board(item: Command, placements: Mapping[str, Poses]) -> bool:
    return item.arguments[0] in placements or item.arguments[0] in _TURNS


def _placement_of(item: Command, cell: Cell, placements: Mapping[str, Poses]) -> int:
    name = item.arguments[0]
    if name in placements:
        return 1 + list(placements).index(name)
    if name == _TURNS[0]:
        return 0
    raise CellError(
        f"the program turns the board over (CALL {name}, {item.made_by}), and cell {cell.name} does not say where the "
        f"board is then. Add it under placements.{name}.",
        path="placements",
    )


def _string(owner: Indices, states: _States) -> tuple[Indices, Indices, Flags, Flags]:
    """Choose the key poses that the robot goes to: their index, the instruction whose state holds, and what is new.

    The last two tell which are the pose before with another tool, and which are reached by turning the board over.
    """
    turning = states.turning[owner]
    kept = np.flatnonzero(~(turning & np.concatenate((turning[1:], [False]))))
    state = owner[kept]
    jump = np.concatenate(([False], np.diff(states.placement[state]) != 0))
    other = np.flatnonzero(np.concatenate(([False], np.diff(states.tool[state]) != 0)) & ~jump)
    keys = np.insert(kept, other, kept[other - 1])
    fresh = np.insert(np.zeros(len(kept), dtype=np.bool_), other, True)
    return keys, np.insert(state, other, state[other]), fresh, np.insert(jump, other, False)


def _fill(timeline: Timeline, keys: Indices, apart: Flags) -> _Laid:
    """Put samples between the key poses, straight in position and by slerp, where they are far apart."""
    times, tcp, quaternion = timeline.times[keys], timeline.tcp[keys], timeline.quaternion[keys]
    lengths = np.linalg.norm(np.diff(tcp, axis=0), axis=1) * 1e-3
    angles = rotation_angles(quaternion[:-1], quaternion[1:])
    lasting = np.diff(times)
    moves = (lengths > 1e-9) | (angles > 1e-9)
    wanted = np.maximum(np.maximum(lengths / STEP_M, angles / STEP_RAD), lasting / STEP_S)
    parts = np.where(moves & ~apart[1:], np.maximum(np.ceil(np.round(wanted, 6)), 1), 1).astype(np.int64)
    parts = np.concatenate(([1], parts))
    parent = np.repeat(np.arange(len(keys)), parts)
    number = np.arange(len(parent)) - (np.cumsum(parts) - parts)[parent] + 1
    share = number / parts[parent]
    before = np.maximum(parent - 1, 0)
    is_key = number == parts[parent]
    still = np.concatenate((~moves & ~apart[1:], [False]))
    return _Laid(
        times=np.where(is_key, times[parent], times[before] + share * (times[parent] - times[before])),
        tcp=np.where(is_key[:, None], tcp[parent], tcp[before] + share[:, None] * (tcp[parent] - tcp[before])),
        quaternion=slerp(quaternion[before], quaternion[parent], share),
        parent=parent,
        is_key=is_key,
        held=is_key & still[parent],
    )


def _wet(timeline: Timeline, times: Scalars) -> Flags:
    before = timeline.switched_on[np.searchsorted(timeline.switch_times, times, side="left")]
    after = timeline.switched_on[np.searchsorted(timeline.switch_times, times, side="right")]
    return before | after


def _matrices(tcp: NDArray[np.float64], quaternion: Quaternions) -> Poses:
    """(n, 4, 4), metres, of positions in millimetres and orientations."""
    from scipy.spatial.transform import Rotation

    poses = np.zeros((len(tcp), 4, 4))
    poses[:, :3, :3] = Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
    poses[:, :3, 3] = tcp * 1e-3
    poses[:, 3, 3] = 1.0
    return poses


def denser(course: Course, parts: Indices) -> tuple[Course, Indices]:
    """Cut intervals (n - 1,) into parts; give the new course and where each old sample is in it."""
    from scipy.spatial.transform import Rotation

    parts = np.concatenate(([1], parts))
    parent = np.repeat(np.arange(len(parts)), parts)
    number = np.arange(len(parent)) - (np.cumsum(parts) - parts)[parent] + 1
    share, is_old, before = number / parts[parent], number == parts[parent], np.maximum(parent - 1, 0)
    turn = np.asarray(Rotation.from_matrix(course.T_base_tcp[:, :3, :3]).as_quat(scalar_first=True))
    poses = course.T_base_tcp[parent].copy()
    new = ~is_old
    mixed = slerp(turn[before[new]], turn[parent[new]], share[new])
    poses[new, :3, :3] = Rotation.from_quat(mixed, scalar_first=True).as_matrix()
    come, go = course.T_base_tcp[before[new], :3, 3], course.T_base_tcp[parent[new], :3, 3]
    poses[new, :3, 3] = come + share[new, None] * (go - come)
    times = course.times[before] + share * (course.times[parent] - course.times[before])
    return (
        Course(
            times=np.where(is_old, course.times[parent], times),
            T_base_tcp=poses,
            T_base_board=course.T_base_board,
            placement=course.placement[parent],
            instruction=course.instruction[parent],
            exact=course.exact[parent] & is_old,
            tool=course.tool[parent],
            changed=course.changed[parent] & is_old,
            wet=np.where(is_old, course.wet[parent], course.wet[parent] & course.wet[before]),
            free=np.where(is_old, course.free[parent], course.free[parent] | course.free[before]),
            held=course.held[parent] & is_old,
        ),
        np.flatnonzero(is_old),
    )
