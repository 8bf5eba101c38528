"""The program as the robot does it: the same instructions at the same places, at the robot's times."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from geometry.frames import align_signs
from programs.program import Command, Instruction, MoveTo, TimedProgram, Totals, Wait
from programs.summary import by_function
from robotcell.cell.cell import Cell
from robotcell.motion.joint_move import JointMove, time_move
from robotcell.motion.track_branch import Followed
from robotcell.robot.robot import Joints, Poses, flange_poses


@dataclass(frozen=True, slots=True, eq=False)
class Told:
    """Moves in the order of time: m rows. Board frame, mm."""

    program: TimedProgram
    joints: Joints
    """(m, dof) one row for each ``MoveTo`` of the program."""
    row_of: Indices
    """(m,) sample of the course that the row is; -1 where it belongs to a joint move."""


@dataclass(frozen=True, slots=True, eq=False)
class Leap:
    """A joint move in place of a piece of the course."""

    begin: int
    """Sample before it,"""
    end: int
    """and after it."""
    move: JointMove


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """What becomes moves: (m,) each."""

    times: Scalars
    q: Joints
    T_base_tcp: Poses
    sample: Indices
    leads_to: Indices
    """Instruction that it is, or comes before."""
    placement: Indices


def retell(program: TimedProgram, cell: Cell, done: Followed, lasting: Scalars, leaps: list[Leap]) -> Told:
    """Give the program that the robot carries out.

    Args:
        program: As it was asked for.
        cell: Whose robot it is.
        done: What the robot does.
        lasting: (n - 1,) s that it takes from sample to sample; of leaps it is not asked.
        leaps: In order.
    """
    timed = [time_move(cell.robot, leap.move) for leap in leaps]
    spent = lasting.copy()
    for leap, (at, _) in zip(leaps, timed, strict=True):
        spent[leap.begin : leap.end] = at[-1] / (leap.end - leap.begin)
    clock = np.round(done.course.times[0] + np.concatenate(([0.0], np.cumsum(spent))), 9)
    rows = _rows(cell, done, clock, leaps, timed)
    moves, joints, sample = _moves(program, done, rows)
    others = _others(program, done, clock)
    return Told(_summed(program, _merge(moves, rows, others)), joints, sample)


def _rows(cell: Cell, done: Followed, clock: Scalars, leaps: list[Leap], timed: list[tuple[Scalars, Joints]]) -> _Rows:
    """Put samples and joint moves together; samples at which nothing new is reached are left out."""
    course = done.course
    n = len(course.times)
    kept = np.ones(n, dtype=np.bool_)
    kept[1:] = ~course.held[:-1] | course.exact[1:]
    for leap in leaps:
        kept[leap.begin + 1 : leap.end] = False
    own = np.flatnonzero(kept)
    parts = [_Rows(clock[own], done.q[own], done.T_base_tcp[own], own, course.instruction[own], course.placement[own])]
    for leap, (at, q) in zip(leaps, timed, strict=True):
        inner = slice(0, -1) if course.changed[leap.end] else slice(1, -1)
        tool = cell.tools[int(course.tool[leap.end])]
        count = len(at[inner])
        parts.append(
            _Rows(
                clock[leap.begin] + at[inner],
                q[inner],
                flange_poses(cell.robot, q[inner]) @ tool.T_flange_tcp,
                np.full(count, -1),
                np.full(count, course.instruction[leap.end]),
                np.full(count, course.placement[leap.end]),
            )
        )
    fields = [np.concatenate([getattr(part, name) for part in parts]) for name in _Rows.__slots__]
    order = np.lexsort((np.where(fields[3] < 0, 1, 0), fields[4], fields[0]))
    return _Rows(*(field[order] for field in fields))


def _moves(program: TimedProgram, done: Followed, rows: _Rows) -> tuple[list[MoveTo], Joints, Indices]:
    """Write the rows as moves in the board's frame; what was asked exactly keeps its own numbers."""
    from scipy.spatial.transform import Rotation

    T_board_base = np.linalg.inv(done.course.T_base_board)
    poses = T_board_base[rows.placement] @ rows.T_base_tcp
    tcp = np.round(poses[:, :3, 3] * 1e3, 6) + 0.0
    turn = np.asarray(Rotation.from_matrix(poses[:, :3, :3]).as_quat(scalar_first=True))
    turn = np.round(align_signs(turn), 10) + 0.0
    _keep_asked(program, done, rows, tcp, turn)
    length = np.concatenate(([0.0], np.linalg.norm(np.diff(tcp, axis=0), axis=1)))
    lasting = np.concatenate(([0.0], np.diff(rows.times)))
    speed = np.round(np.where(lasting > 1e-9, length / np.maximum(lasting, 1e-9), 0.0), 6)
    makers = [program.instructions[index].made_by for index in rows.leads_to.tolist()]
    moves = [
        MoveTo(at, (x, y, z), (w, i, j, k), v, made_by)
        for at, (x, y, z), (w, i, j, k), v, made_by in zip(
            rows.times.tolist(), tcp.tolist(), turn.tolist(), speed.tolist(), makers, strict=True
        )
    ]
    return moves, rows.q, rows.sample


def _keep_asked(
    program: TimedProgram, done: Followed, rows: _Rows, tcp: NDArray[np.float64], turn: NDArray[np.float64]
) -> None:
    """Put back what the program itself says where the robot does just that."""
    as_asked = (np.abs(done.azimuth) < 1e-12) & (np.abs(done.lean).max(axis=1) < 1e-12) & done.course.exact
    for row in np.flatnonzero((rows.sample >= 0) & as_asked[rows.sample]).tolist():
        move = program.instructions[int(done.course.instruction[rows.sample[row]])]
        if isinstance(move, MoveTo):
            tcp[row], turn[row] = move.position, move.quaternion


def _others(program: TimedProgram, done: Followed, clock: Scalars) -> list[tuple[int, Instruction]]:
    """Give every other instruction its new time, with its index.

    What stands with a change of the tool, or a turn of the board, is told when the robot leaves for it. A wait, or the
    jet, that comes after the change, and what follows on that, is told when the robot is there.
    """
    course = done.course
    told: list[tuple[int, Instruction]] = []
    last = len(course.times) - 1
    left_for, there = -1, -1
    for index, item in enumerate(program.instructions):
        if isinstance(item, MoveTo):
            continue
        following = min(int(np.searchsorted(course.instruction, index, side="left")), last)
        at = _time_at(course.times, clock, following, item.time_s)
        if course.changed[following]:
            is_later = not isinstance(item, Command) or item.time_s > course.times[following] + 1e-9
            there = following if left_for == following and is_later else there
            left_for = following if isinstance(item, Command) and item.keyword in ("NOZZLE", "CALL") else left_for
            at = max(float(clock[following]), at) if there == following else float(clock[following - 1])
        told.append((index, replace(item, time_s=at)))
    return told


def _time_at(times: Scalars, clock: Scalars, following: int, asked: float) -> float:
    """Give the robot's time of something that the program does at a time of its own, just before a sample or later."""
    begin = max(following - 1, 0)
    while begin < len(times) - 1 and times[begin + 1] < asked - 1e-9:
        begin += 1
    end = min(begin + 1, len(times) - 1)
    if asked <= times[begin] + 1e-9:
        return float(clock[begin])
    if asked >= times[end] - 1e-9:
        return float(clock[end] + (asked - times[end] if end == len(times) - 1 else 0.0))
    share = (asked - times[begin]) / (times[end] - times[begin])
    return float(np.round(clock[begin] + share * (clock[end] - clock[begin]), 9))


def _merge(moves: list[MoveTo], rows: _Rows, others: list[tuple[int, Instruction]]) -> tuple[Instruction, ...]:
    """Put moves and other instructions into one order: by time, then as the program has them."""
    told: list[tuple[float, int, Instruction]] = [
        (move.time_s, index, move) for move, index in zip(moves, rows.leads_to.tolist(), strict=True)
    ]
    told += [(item.time_s, index, item) for index, item in others]
    told.sort(key=lambda entry: entry[:2])
    return tuple(item for _, _, item in told)


def _summed(program: TimedProgram, instructions: tuple[Instruction, ...]) -> TimedProgram:
    """Add up anew; litres grow with the time for which each function sprays."""
    last = instructions[-1]
    end_s = last.time_s + (last.duration_s if isinstance(last, Wait) else 0.0)
    bare = replace(program, instructions=instructions, findings=())
    before, after = by_function(program), by_function(bare)
    sprayed: dict[str, tuple[float, float]] = {}
    for old, new in zip(before, after, strict=True):
        a, b = sprayed.get(old.function, (0.0, 0.0))
        sprayed[old.function] = (a + old.spray_s, b + new.spray_s)
    grown = {name: new / old if old > 0 else 1.0 for name, (old, new) in sprayed.items()}
    totals = Totals(
        duration_s=end_s,
        spray_s=sum(each.spray_s for each in after),
        travel_mm=sum(each.travel_mm for each in after),
        moves=sum(isinstance(item, MoveTo) for item in instructions),
        liquid_l=tuple((name, litres * grown.get(name, 1.0)) for name, litres in program.totals.liquid_l),
    )
    return replace(bare, totals=totals)
