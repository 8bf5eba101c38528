"""State of the nozzle at any moment of a program: the only place that interprets its instructions."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Directions, Indices, Points, Quaternions, Scalars
from geometry.frames import slerp
from programs.errors import ProgramError
from programs.program import Columns, Command, TimedProgram, columns_of
from specs.source import Source

# What takes less is a jump: no program writes such times, and a division by them has no speed.
_JUMP_S = 1e-9


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
    """A program laid out for fast look-ups; built once and evaluated 60 times a second.

    k key poses in the order of time: one for each move, one for the beginning and one for the end of each wait.
    Board frame, mm, s.
    """

    times: Scalars
    """(k,)"""
    tcp: Points
    """(k, 3)"""
    quaternion: Quaternions
    """(k, 4) unit length."""
    speed: Scalars
    """(k,) of the segment that ends at each key pose."""
    running: Indices
    """(k,) the instruction that runs in that segment; the first instruction for the first."""
    switch_times: Scalars
    """(s,)"""
    switched_on: NDArray[np.bool_]
    """(s + 1,) the jet before each switch, and after the last."""
    function: Naming
    nozzle: Naming
    solution: Naming
    made_by: Indices
    """(instructions,) index into ``makers``."""
    makers: tuple[Source, ...]


@dataclass(frozen=True, slots=True, eq=False)
class ToolStates:
    """The nozzle at n moments. Board frame, mm, s."""

    times: Scalars
    """(n,) as requested."""
    tcp: Points
    """(n, 3)"""
    quaternion: Quaternions
    """(n, 4) w, x, y, z of T_board_tool."""
    approach: Directions
    """(n, 3) unit vectors along the jet."""
    speed: Scalars
    """(n,) of the orifice, mm/s; 0 while it is held and outside the program."""
    spraying: NDArray[np.bool_]
    """(n,) whether the jet is on."""
    function: Indices
    """(n,) index into ``functions``; 0 is none yet."""
    nozzle: Indices
    """(n,) index into ``nozzles``; 0 is none yet."""
    solution: Indices
    """(n,) index into ``solutions``; 0 is none yet."""
    instruction: Indices
    """(n,) the instruction that runs: the move under way or the wait that holds."""
    made_by: Indices
    """(n,) index into ``makers``: the recipe path of that instruction."""
    functions: tuple[str, ...]
    nozzles: tuple[str, ...]
    solutions: tuple[str, ...]
    makers: tuple[Source, ...]


def playback(program: TimedProgram, times_s: Scalars) -> ToolStates:
    """Nozzle states at each of (n,) times, in any order.

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
    times, tcp, quaternion, running = _key_poses(columns)
    lasting, lengths = np.diff(times), np.linalg.norm(np.diff(tcp, axis=0), axis=1)
    speed = np.divide(lengths, lasting, out=np.zeros_like(lengths), where=lasting > _JUMP_S)
    makers = tuple(dict.fromkeys(item.made_by for item in program.instructions))
    code = {made_by: index for index, made_by in enumerate(makers)}
    return Timeline(
        times=times,
        tcp=tcp,
        quaternion=quaternion,
        speed=np.concatenate([[0.0], speed]),
        running=running,
        switch_times=columns.times[columns.spray_at],
        switched_on=np.concatenate([[False], columns.spray]),
        function=_naming(program, "FUNCTION"),
        nozzle=_naming(program, "NOZZLE"),
        solution=_naming(program, "SOLUTION"),
        made_by=np.array([code[item.made_by] for item in program.instructions], dtype=np.int64),
        makers=makers,
    )


def play(timeline: Timeline, times_s: Scalars) -> ToolStates:
    """Nozzle states at each of (n,) times, in any order; see ``playback``."""
    times = np.asarray(times_s, dtype=np.float64)
    key = np.searchsorted(timeline.times, times, side="right")  # the next key pose; 0 before the first
    last = len(timeline.times) - 1
    come_from, go_to = np.clip(key - 1, 0, last), np.clip(key, 0, last)
    lasting = timeline.times[go_to] - timeline.times[come_from]
    done = np.divide(times - timeline.times[come_from], lasting, out=np.zeros_like(times), where=lasting > 0)
    tcp = timeline.tcp[come_from] + done[:, None] * (timeline.tcp[go_to] - timeline.tcp[come_from])
    quaternion = slerp(timeline.quaternion[come_from], timeline.quaternion[go_to], done)
    w, x, y, z = quaternion.T
    instruction = np.where(key > last, len(timeline.made_by) - 1, timeline.running[go_to])
    return ToolStates(
        times=times,
        tcp=tcp,
        quaternion=quaternion,
        # Tool +Z: the third column of the rotation matrix.
        approach=np.column_stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]),
        speed=np.where(key > last, 0.0, timeline.speed[go_to]),
        spraying=timeline.switched_on[np.searchsorted(timeline.switch_times, times, side="right")],
        function=timeline.function.at(times),
        nozzle=timeline.nozzle.at(times),
        solution=timeline.solution.at(times),
        instruction=instruction,
        made_by=timeline.made_by[instruction],
        functions=timeline.function.names,
        nozzles=timeline.nozzle.names,
        solutions=timeline.solution.names,
        makers=timeline.makers,
    )


def _key_poses(columns: Columns) -> tuple[Scalars, Points, Quaternions, Indices]:
    """Times, positions, orientations and running instructions of the moves and of both ends of the waits."""
    tcp = columns.moves[:, :3]
    quaternion = columns.moves[:, 3:7] / np.linalg.norm(columns.moves[:, 3:7], axis=1, keepdims=True)
    wait_times = columns.times[columns.wait_at]
    # A wait holds the pose reached at its time; what is left of a segment takes the time that no wait holds.
    held = np.concatenate([[0.0], np.cumsum(columns.waits)])
    after = np.searchsorted(columns.move_at, columns.wait_at)
    come_from, go_to = np.maximum(after - 1, 0), np.minimum(after, len(tcp) - 1)
    move_clock = columns.times[columns.move_at] - held[np.searchsorted(columns.wait_at, columns.move_at)]
    begin, lasting = move_clock[come_from], move_clock[go_to] - move_clock[come_from]
    passed = wait_times - held[:-1] - begin
    done = np.clip(np.divide(passed, lasting, out=np.zeros_like(passed), where=lasting > 0), 0.0, 1.0)
    wait_tcp = tcp[come_from] + done[:, None] * (tcp[go_to] - tcp[come_from])
    wait_quaternion = slerp(quaternion[come_from], quaternion[go_to], done)
    # In the order of the instructions; the beginning of a wait belongs to the move that it interrupts.
    order = np.argsort(np.concatenate([columns.move_at, columns.wait_at, columns.wait_at]), kind="stable")
    times = np.concatenate([columns.times[columns.move_at], wait_times, wait_times + columns.waits])[order]
    running = np.concatenate([columns.move_at, columns.move_at[go_to], columns.wait_at])[order]
    running[0] = 0
    return (
        np.maximum.accumulate(times),  # a wait may overlap the next move by the last digit of the file
        np.concatenate([tcp, wait_tcp, wait_tcp])[order],
        np.concatenate([quaternion, wait_quaternion, wait_quaternion])[order],
        running,
    )


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
