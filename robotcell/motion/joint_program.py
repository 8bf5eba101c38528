"""The robot's program: the same instructions at the same places, at the times that the joints need."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Indices, Points, Quaternions, Scalars
from geometry.frames import align_signs
from programs.program import Command, Instruction, MoveTo, TimedProgram, Totals, Wait
from programs.summary import by_function
from robotcell.cell.cell import Cell
from robotcell.motion.cell_queries import HomeMoves, Reconfiguration, time_move
from robotcell.motion.sampled_path import Flags, SampledPath, TrackedPath
from robotcell.robot.robot import Joints, Poses, flange_poses, row_pieces

_SOON_S = 1e-6


@dataclass(frozen=True, slots=True)
class AddedTimes:
    """Seconds of the motions that a program does not have, jet off: the cell's."""

    from_home: float = 0.0
    """From home to the first pose; 0 where no way is clear."""
    tool_changes: float = 0.0
    """To where the tool is changed, and from there."""
    to_home: float = 0.0
    """From the last pose home; 0 where no way is clear."""

    def describe(self) -> str:
        """Give them in words, as a part of the robot's time."""
        changes = f", {self.tool_changes:.1f} s for changes of the tool" if self.tool_changes else ""
        return f"{self.from_home:.1f} s from there, {self.to_home:.1f} s back{changes}; in the time"


@dataclass(frozen=True, slots=True, eq=False)
class RobotProgram:
    """A program as the robot carries it out, and its joints."""

    program: TimedProgram
    joints: Joints
    """(m, dof) one row for each ``MoveTo`` of the program."""
    row_of: Indices
    """(m,) sample of the path that the row is; -1 where it belongs to a joint move."""
    corner: Flags
    """(m,) whether it ends a straight line of the path, or of a joint move."""
    share: Scalars
    """(m,) of a line along which the turning axes go evenly; NaN elsewhere."""
    added: AddedTimes


@dataclass(frozen=True, slots=True, eq=False)
class _Leg:
    """A part of a joint move with one tool."""

    at: Scalars
    """(k,) s since the program began"""
    q: Joints
    """(k, dof)"""
    corner: Flags
    """(k,) whether the robot rests there"""
    tool: int
    placement: int
    leads_to: int
    """Instruction that it comes before."""


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """What becomes moves: (m,) each."""

    times: Scalars
    q: Joints
    tcp: Points
    """(m, 3) board frame, mm."""
    quaternion: Quaternions
    """(m, 4) w, x, y, z in the board frame, of either sign."""
    sample: Indices
    leads_to: Indices
    """Instruction that it is, or comes before."""
    corner: Flags


def build_robot_program(
    program: TimedProgram,
    cell: Cell,
    tracked: TrackedPath,
    lasting: Scalars,
    moves: tuple[Reconfiguration, ...],
    home: HomeMoves,
) -> RobotProgram:
    """Build the program that the robot carries out, from home to home.

    Args:
        program: The program as planned.
        cell: Whose robot it is.
        tracked: The path as the robot tracks it.
        lasting: (n - 1,) s that it takes from sample to sample; unused where joint moves replace the path.
        moves: Joint moves in place of pieces of the path, in order.
        home: Joint moves before and after the path.
    """
    path = tracked.path
    timed = [[time_move(cell.robot, part, cell.tool_point) for part in each.parts] for each in moves]
    spent = lasting.copy()
    for each, parts in zip(moves, timed, strict=True):
        spent[each.begin : each.end] = sum(at[-1] for at, _ in parts) / (each.end - each.begin)
    out_at, out = time_move(cell.robot, home.out, cell.tool_point)
    clock = np.round(path.times[0] + out_at[-1] + np.concatenate(([0.0], np.cumsum(spent))), 9)
    changes = {
        each.end: float(np.round(clock[each.begin] + parts[0][0][-1], 9))
        for each, parts in zip(moves, timed, strict=True)
        if each.change
    }
    others = _others(program, tracked, clock, changes)
    legs = [leg for each, parts in zip(moves, timed, strict=True) for leg in _legs(path, clock, each, parts)]
    if len(out) > 1:
        legs.append(_leg(path, path.times[0] + out_at[:-1], out[:-1], home.out, 0))
    back_at, back = time_move(cell.robot, home.back, cell.tool_point)
    if len(back) > 1:
        rest = max([float(clock[-1]), *(item.time_s for _, item in others)])
        begin = 0 if rest > clock[-1] + _SOON_S else 1  # the last instruction may come after the last move
        last = _leg(path, rest + back_at[begin:], back[begin:], home.back, -1)
        legs.append(replace(last, leads_to=len(program.instructions)))
    rows = _rows(cell, tracked, clock, moves, legs)
    index = np.concatenate((rows.leads_to, np.array([index for index, _ in others], dtype=np.int64)))
    times = np.concatenate((rows.times, np.array([item.time_s for _, item in others], dtype=np.float64)))
    items: list[Instruction] = [*_moves(program, tracked, rows), *(item for _, item in others)]
    instructions = tuple(items[at] for at in np.lexsort((index, times)).tolist())
    by_change = sum(at[-1] for each, parts in zip(moves, timed, strict=True) if each.change for at, _ in parts)
    added = AddedTimes(float(out_at[-1]), float(by_change), float(back_at[-1]))
    share = np.where(rows.sample >= 0, tracked.share[rows.sample], np.nan)
    return RobotProgram(_with_totals(program, instructions), rows.q, rows.sample, rows.corner, share, added)


def _legs(
    path: SampledPath, clock: Scalars, move: Reconfiguration, parts: list[tuple[Scalars, Joints]]
) -> Iterator[_Leg]:
    """Give the rows of a joint move between its ends; where the tool is changed, with the one and with the other."""
    begin, end = clock[move.begin], move.end
    if move.change:
        (at, q), parts = parts[0], parts[1:]
        yield _leg(path, begin + at[1:], q[1:], move.way, move.begin)
        begin += at[-1]
    at, q = parts[0]
    inner = slice(0, -1) if path.changed[end] else slice(1, -1)
    yield _leg(path, begin + at[inner], q[inner], move.way, end)


def _leg(path: SampledPath, at: Scalars, q: Joints, way: Joints, sample: int) -> _Leg:
    """Give a leg with the tool and the placement of a sample, among the rows (k, dof) of the way that it rests at."""
    rests = np.array([np.abs(way - row).max(axis=1).min() < 1e-9 for row in q], dtype=np.bool_)
    return _Leg(at, q, rests, int(path.tool[sample]), int(path.placement[sample]), int(path.instruction[sample]))


def _rows(
    cell: Cell, tracked: TrackedPath, clock: Scalars, moves: tuple[Reconfiguration, ...], legs: list[_Leg]
) -> _Rows:
    """Put samples and joint moves together; samples at which nothing new is reached are left out."""
    path = tracked.path
    kept = np.ones(len(path.times), dtype=np.bool_)
    kept[1:] = ~path.dwelling[:-1] | path.exact[1:]
    for each in moves:
        kept[each.begin + 1 : each.end] = False
    own = np.flatnonzero(kept)
    T_board_base = np.linalg.inv(path.T_base_board)
    tcp, quaternion = np.empty((len(own), 3)), np.empty((len(own), 4))
    for rows in row_pieces(len(own)):
        some = own[rows]
        tcp[rows], quaternion[rows] = _in_board(T_board_base[path.placement[some]] @ tracked.T_base_tcp[some])
    parts = [_Rows(clock[own], tracked.q[own], tcp, quaternion, own, path.instruction[own], path.corner[own])]
    for leg in legs:
        poses = flange_poses(cell.robot, leg.q) @ cell.tools[leg.tool].T_flange_tcp
        places = _in_board(T_board_base[leg.placement] @ poses)
        none, leads_to = np.full(len(poses), -1), np.full(len(poses), leg.leads_to)
        parts.append(_Rows(np.round(leg.at, 9), leg.q, *places, none, leads_to, leg.corner))
    fields = [np.concatenate([getattr(part, name) for part in parts]) for name in _Rows.__slots__]
    order = np.lexsort((np.where(fields[4] < 0, 1, 0), fields[5], fields[0]))
    return _Rows(*(field[order] for field in fields))


def _in_board(T_board_tcp: Poses) -> tuple[Points, Quaternions]:
    """Places (n, 3), mm, and quaternions (n, 4) of poses."""
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_matrix(T_board_tcp[:, :3, :3])
    return T_board_tcp[:, :3, 3] * 1e3, np.asarray(turns.as_quat(scalar_first=True))


def _moves(program: TimedProgram, tracked: TrackedPath, rows: _Rows) -> Iterator[MoveTo]:
    """Write the rows as moves in the board's frame; a pose that is reached as programmed keeps its own numbers."""
    tcp = np.round(rows.tcp, 6) + 0.0
    turn = np.round(align_signs(rows.quaternion), 10) + 0.0
    unchanged = (np.abs(tracked.azimuth) < 1e-12) & (np.abs(tracked.tilt).max(axis=1) < 1e-12) & tracked.path.exact
    for row in np.flatnonzero((rows.sample >= 0) & unchanged[rows.sample]).tolist():
        move = program.instructions[int(tracked.path.instruction[rows.sample[row]])]
        if isinstance(move, MoveTo):
            tcp[row], turn[row] = move.position, move.quaternion
    length = np.concatenate(([0.0], np.linalg.norm(np.diff(tcp, axis=0), axis=1)))
    lasting = np.concatenate(([0.0], np.diff(rows.times)))
    speed = np.round(np.where(lasting > 1e-9, length / np.maximum(lasting, 1e-9), 0.0), 6)
    for some in row_pieces(len(tcp)):
        for at, (x, y, z), (w, i, j, k), v, index in zip(
            rows.times[some].tolist(),
            tcp[some].tolist(),
            turn[some].tolist(),
            speed[some].tolist(),
            rows.leads_to[some].tolist(),
            strict=True,
        ):
            made_by = program.instructions[min(index, len(program.instructions) - 1)].made_by
            yield MoveTo(at, (x, y, z), (w, i, j, k), v, made_by)


def _others(
    program: TimedProgram, tracked: TrackedPath, clock: Scalars, changed_at: Mapping[int, float]
) -> list[tuple[int, Instruction]]:
    """Give every other instruction its new time, with its index.

    What stands with a turn of the board happens when the robot leaves for it, what stands with a change of the tool
    where that is changed, and what the program begins with at home. A wait, the jet, or a loop that comes after the
    change, and what follows on that, happens when the robot is there.

    Args:
        program: The program as planned.
        tracked: The path as the robot tracks it.
        clock: (n,) s when the robot is at each sample.
        changed_at: s at which the tool is changed before a sample.
    """
    path = tracked.path
    timed: list[tuple[int, Instruction]] = []
    begins, left_for, changed_for, there = True, -1, -1, -1
    for index, item in enumerate(program.instructions):
        if isinstance(item, MoveTo):
            continue
        following = int(np.searchsorted(path.instruction, index, side="left"))
        at = _time_at(path.times, clock, following, item.time_s)
        begins &= following == 0 and isinstance(item, Command) and item.keyword != "REPEAT"
        if begins:
            at = float(path.times[0])
        elif following < len(path.times) and path.changed[following]:
            word = item.keyword if isinstance(item, Command) else ""
            is_later = word in ("", "REPEAT") or item.time_s > path.times[following] + 1e-9
            there = following if left_for == following and is_later else there
            left_for = following if word in ("NOZZLE", "CALL") else left_for
            changed_for = following if word not in ("", "REPEAT", "ENDREPEAT") else changed_for
            leaves = float(clock[following - 1])
            waits = changed_for == following and (word != "" or left_for == following)  # the jet goes off before
            at_change = changed_at.get(following, leaves) if waits else leaves
            at = max(float(clock[following]), at) if there == following else at_change
        timed.append((index, replace(item, time_s=at)))
    return timed


def _time_at(times: Scalars, clock: Scalars, following: int, time_s: float) -> float:
    """Give the robot's time for a time of the program, just before a sample or later."""
    begin = max(following - 1, 0)
    while begin < len(times) - 1 and times[begin + 1] < time_s - 1e-9:
        begin += 1
    end = min(begin + 1, len(times) - 1)
    if time_s <= times[begin] + 1e-9:
        return float(clock[begin])
    if time_s >= times[end] - 1e-9:
        return float(clock[end] + (time_s - times[end] if end == len(times) - 1 else 0.0))
    share = (time_s - times[begin]) / (times[end] - times[begin])
    return float(np.round(clock[begin] + share * (clock[end] - clock[begin]), 9))


def _with_totals(program: TimedProgram, instructions: tuple[Instruction, ...]) -> TimedProgram:
    """Add up the totals anew; litres grow with the time for which each function sprays."""
    last = instructions[-1]
    bare = replace(program, instructions=instructions, findings=())
    before, after = by_function(program), by_function(bare)
    sprayed: dict[str, tuple[float, float]] = {}
    for old, new in zip(before, after, strict=True):
        a, b = sprayed.get(old.function, (0.0, 0.0))
        sprayed[old.function] = (a + old.spray_s, b + new.spray_s)
    grown = {name: new / old if old > 0 else 1.0 for name, (old, new) in sprayed.items()}
    totals = Totals(
        duration_s=last.time_s + (last.duration_s if isinstance(last, Wait) else 0.0),
        spray_s=sum(each.spray_s for each in after),
        travel_mm=sum(each.travel_mm for each in after),
        moves=sum(isinstance(item, MoveTo) for item in instructions),
        liquid_l=tuple((name, litres * grown.get(name, 1.0)) for name, litres in program.totals.liquid_l),
    )
    return replace(bare, totals=totals)
