"""What the nozzle does at any moment of a program: the only place that interprets its instructions."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Directions, Indices, Points, Quaternions, Scalars
from programs.columns import columns_of
from programs.errors import ProgramError
from programs.program import Command, TimedProgram


@dataclass(frozen=True, slots=True, eq=False)
class Naming:
    """A name that holds from one command to the next, such as the function. The first, empty one is "none yet"."""

    times: Scalars
    """(k,) when each name begins to hold; the first at minus infinity."""
    codes: Indices
    """(k,) which name it is."""
    names: tuple[str, ...]

    def at(self, times: Scalars) -> Indices:
        """(n,) indices into ``names``."""
        return self.codes[np.searchsorted(self.times, times, side="right") - 1]


@dataclass(frozen=True, slots=True, eq=False)
class Timeline:
    """A program laid out for quick questions; build it once and ask it 60 times a second.

    The clock of motion stands still while a WAIT holds the pose; m moves, w waits, s switches. Board frame, mm, s.
    """

    move_clock: Scalars
    """(m,) reading of the clock of motion at each move."""
    move_at: Indices
    """(m,) which instruction each move is."""
    tcp: Points
    quaternion: Quaternions
    """(m, 4) unit length."""
    speed: Scalars
    """(m,) of the segment that ends at each move; 0 for the first."""
    wait_start: Scalars
    """(w,)"""
    wait_length: Scalars
    """(w,)"""
    wait_at: Indices
    """(w,) which instruction each wait is."""
    held_before: Scalars
    """(w + 1,) seconds held before each wait, and altogether."""
    switch_times: Scalars
    """(s,)"""
    switched_on: NDArray[np.bool_]
    """(s + 1,) the jet before each switch, and after the last."""
    function: Naming
    nozzle: Naming
    solution: Naming
    last_instruction: int
    maker_of: Indices
    """(instructions,) index into ``makers``."""
    makers: tuple[str, ...]
    end_s: float
    """When the last move has arrived and the last wait is over."""


@dataclass(frozen=True, slots=True, eq=False)
class ToolStates:
    """The nozzle at n moments. Board frame, mm, s."""

    times: Scalars
    """(n,) as they were asked for."""
    tcp: Points
    """(n, 3)"""
    quaternion: Quaternions
    """(n, 4) w, x, y, z of T_board_tool."""
    approach: Directions
    """(n, 3) unit vectors along the jet."""
    speed: Scalars
    """(n,) of the orifice, mm/s; 0 while it is held and outside the program."""
    spraying: NDArray[np.bool_]
    """(n,) whether the jet is wanted."""
    function: Indices
    """(n,) index into ``functions``; 0 is none yet."""
    nozzle: Indices
    """(n,) index into ``nozzles``; 0 is none yet."""
    solution: Indices
    """(n,) index into ``solutions``; 0 is none yet."""
    instruction: Indices
    """(n,) the instruction that runs: the move under way or the wait that holds."""
    made_by: Indices
    """(n,) index into ``makers``: who asked for that instruction."""
    functions: tuple[str, ...]
    nozzles: tuple[str, ...]
    solutions: tuple[str, ...]
    makers: tuple[str, ...]


def playback(program: TimedProgram, times_s: Scalars) -> ToolStates:
    """Say where the nozzle is and what it does at each of (n,) times, in any order.

    Before its first move and after its last instruction the program stands still. At the moment of an instruction it
    counts as done: at the time of a SPRAY ON the jet is on, at the time of a move the next one is under way.

    Raises:
        ProgramError: the program has no move, so that there is no pose.
    """
    return play(build_timeline(program), times_s)


def build_timeline(program: TimedProgram) -> Timeline:
    """Lay a program out for many calls of ``play``.

    Raises:
        ProgramError: the program has no move, so that there is no pose.
    """
    columns = columns_of(program)
    if not len(columns.moves):
        raise ProgramError("the program has no MOVE; there is nothing to play.")
    wait_start = columns.times[columns.wait_at]
    held_before = np.concatenate([[0.0], np.cumsum(columns.waits)])
    clock = _moving_clock(columns.times[columns.move_at], wait_start, columns.waits, held_before)
    clock = np.maximum.accumulate(clock)  # a wait may overlap the next move by the last digit of the file
    tcp = columns.moves[:, :3]
    lasting = np.diff(clock)
    lengths = np.linalg.norm(np.diff(tcp, axis=0), axis=1)
    speed = np.divide(lengths, lasting, out=np.zeros_like(lengths), where=lasting > 0)
    makers = tuple(dict.fromkeys(item.made_by for item in program.instructions))
    code = {made_by: index for index, made_by in enumerate(makers)}
    ends = [*columns.times[-1:], *(wait_start[-1:] + columns.waits[-1:])]
    return Timeline(
        move_clock=clock,
        move_at=columns.move_at,
        tcp=tcp,
        quaternion=columns.moves[:, 3:7] / np.linalg.norm(columns.moves[:, 3:7], axis=1, keepdims=True),
        speed=np.concatenate([[0.0], speed]),
        wait_start=wait_start,
        wait_length=columns.waits,
        wait_at=columns.wait_at,
        held_before=held_before,
        switch_times=columns.times[columns.spray_at],
        switched_on=np.concatenate([[False], columns.spray]),
        function=_naming(program, "FUNCTION"),
        nozzle=_naming(program, "NOZZLE"),
        solution=_naming(program, "SOLUTION"),
        last_instruction=len(program.instructions) - 1,
        maker_of=np.array([code[item.made_by] for item in program.instructions], dtype=np.int64),
        makers=makers,
        end_s=float(max(ends)),
    )


def play(timeline: Timeline, times_s: Scalars) -> ToolStates:
    """Say where the nozzle is and what it does at each of (n,) times, in any order; see ``playback``."""
    times = np.asarray(times_s, dtype=np.float64)
    clock = _moving_clock(times, timeline.wait_start, timeline.wait_length, timeline.held_before)
    move = np.searchsorted(timeline.move_clock, clock, side="right")  # the move under way; 0 before the first
    last = len(timeline.move_clock) - 1
    come_from, go_to = np.clip(move - 1, 0, last), np.clip(move, 0, last)
    begin, lasting = timeline.move_clock[come_from], timeline.move_clock[go_to] - timeline.move_clock[come_from]
    done = np.divide(clock - begin, lasting, out=np.zeros_like(clock), where=lasting > 0)
    tcp = timeline.tcp[come_from] + done[:, None] * (timeline.tcp[go_to] - timeline.tcp[come_from])
    quaternion = _slerp(timeline.quaternion[come_from], timeline.quaternion[go_to], done)
    wait, held = _waiting(timeline, times)
    moving = (move > 0) & (move <= last) & ~held
    instruction = np.select(
        [held, move == 0, move > last], [wait, 0, timeline.last_instruction], timeline.move_at[go_to]
    )
    return ToolStates(
        times=times,
        tcp=tcp,
        quaternion=quaternion,
        approach=_jet_directions(quaternion),
        speed=np.where(moving, timeline.speed[go_to], 0.0),
        spraying=timeline.switched_on[np.searchsorted(timeline.switch_times, times, side="right")],
        function=timeline.function.at(times),
        nozzle=timeline.nozzle.at(times),
        solution=timeline.solution.at(times),
        instruction=instruction,
        made_by=timeline.maker_of[instruction],
        functions=timeline.function.names,
        nozzles=timeline.nozzle.names,
        solutions=timeline.solution.names,
        makers=timeline.makers,
    )


def _moving_clock(times: Scalars, wait_start: Scalars, wait_length: Scalars, held_before: Scalars) -> Scalars:
    """Read the clock of motion: the time less all that has been waited until then."""
    if not len(wait_start):
        return times
    wait = np.searchsorted(wait_start, times, side="right") - 1
    latest = np.maximum(wait, 0)
    passed = np.clip(times - wait_start[latest], 0.0, wait_length[latest])
    return times - held_before[latest] - passed


def _waiting(timeline: Timeline, times: Scalars) -> tuple[Indices, NDArray[np.bool_]]:
    """Say which instruction waited last at each time, and whether it still holds."""
    if not len(timeline.wait_at):
        return np.zeros(len(times), dtype=np.int64), np.zeros(len(times), dtype=np.bool_)
    wait = np.searchsorted(timeline.wait_start, times, side="right") - 1
    latest = np.maximum(wait, 0)
    return timeline.wait_at[latest], (wait >= 0) & (times < (timeline.wait_start + timeline.wait_length)[latest])


def _naming(program: TimedProgram, keyword: str) -> Naming:
    changes = [
        (item.time_s, item.arguments[0])
        for item in program.instructions
        if isinstance(item, Command) and item.keyword == keyword and item.arguments
    ]
    names = tuple(dict.fromkeys(["", *(name for _, name in changes)]))
    return Naming(
        times=np.array([-np.inf, *(time_s for time_s, _ in changes)]),
        codes=np.array([0, *(names.index(name) for _, name in changes)], dtype=np.int64),
        names=names,
    )


def _jet_directions(quaternions: Quaternions) -> Directions:
    """Tool +Z of (n, 4) orientations: the third column of the rotation matrix."""
    w, x, y, z = quaternions.T
    return np.column_stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


def _slerp(start: Quaternions, end: Quaternions, done: Scalars) -> Quaternions:
    """Turn at constant speed the short way round (Shoemake 1985), each of (n,) pairs by its own part."""
    end = np.where(np.sum(start * end, axis=1, keepdims=True) < 0, -end, end)
    angle = 2 * np.arctan2(np.linalg.norm(end - start, axis=1), np.linalg.norm(end + start, axis=1))
    sine = np.sin(angle)
    is_small = sine < 1e-6  # the chord is as good as the arc
    sine = np.where(is_small, 1.0, sine)
    weight_start = np.where(is_small, 1 - done, np.sin((1 - done) * angle) / sine)
    weight_end = np.where(is_small, done, np.sin(done * angle) / sine)
    turned = weight_start[:, None] * start + weight_end[:, None] * end
    return turned / np.linalg.norm(turned, axis=1, keepdims=True)
