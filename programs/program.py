"""The timed program: a flat list of instructions, each with its time."""

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from programs.plan import Origin
from specs.finding import Finding
from specs.source import Source

MOST_MOVES = 2_000_000
"""Of a program: as many lines as a file of a sensible size holds."""


@dataclass(frozen=True, slots=True)
class MoveTo:
    """The TCP is at this pose at this time; it came straight (and by slerp) from the last one. Board frame, mm."""

    time_s: float
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    """w, x, y, z of T_board_tool; tool +Z is the jet."""
    speed_mm_s: float
    """Mean TCP speed of the segment that ends here."""
    made_by: Source


@dataclass(frozen=True, slots=True)
class SetNozzle:
    """The jet begins or ends at the orifice at this time; the valves' lags are taken into account in the posts."""

    time_s: float
    spraying: bool
    made_by: Source


@dataclass(frozen=True, slots=True)
class Wait:
    """The pose is held for this long; the next instruction is at least that much later."""

    time_s: float
    duration_s: float
    made_by: Source


@dataclass(frozen=True, slots=True)
class Command:
    """Any other instruction to the cell, by its keyword in the native file."""

    time_s: float
    keyword: str
    arguments: tuple[str, ...]
    made_by: Source


TILT_BAND = "tilt_band_deg"
"""Key of the SET that grants a robot a lean of the jet while it sprays; no output belongs to it."""

Instruction: TypeAlias = MoveTo | SetNozzle | Wait | Command


@dataclass(frozen=True, slots=True)
class Totals:
    """What the whole program takes; the body of a REPEAT counts once."""

    duration_s: float
    spray_s: float
    travel_mm: float
    moves: int
    liquid_l: tuple[tuple[str, float], ...]
    """Litres by function, in the order of first use; gases are left out."""


@dataclass(frozen=True, slots=True)
class TimedProgram:
    """Instructions in time order, from parked to parked with the jet off. Board frame, mm, s."""

    origin: Origin
    totals: Totals
    instructions: tuple[Instruction, ...]
    findings: tuple[Finding, ...] = ()
    """What the timing saw; not part of the file."""


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """The numbers of n instructions, m of them moves, w waits, s nozzle switches. Board frame, mm, s."""

    times: Scalars
    """(n,) time of every instruction."""
    move_at: Indices
    """(m,) which instructions are moves."""
    moves: NDArray[np.float64]
    """(m, 8) x y z, w x y z of the quaternion, speed."""
    wait_at: Indices
    """(w,) which instructions are waits."""
    waits: Scalars
    """(w,) how long they hold."""
    spray_at: Indices
    """(s,) which instructions switch the nozzle."""
    spray: NDArray[np.bool_]
    """(s,) whether the jet is requested from then on."""

    def part(self, begin: int, end: int) -> "Columns":
        """Give the numbers of the instructions from ``begin`` to before ``end``, as if there were no others."""
        moves, waits, spray = (
            slice(*np.searchsorted(at, (begin, end)).tolist()) for at in (self.move_at, self.wait_at, self.spray_at)
        )
        return Columns(
            times=self.times[begin:end],
            move_at=self.move_at[moves] - begin,
            moves=self.moves[moves],
            wait_at=self.wait_at[waits] - begin,
            waits=self.waits[waits],
            spray_at=self.spray_at[spray] - begin,
            spray=self.spray[spray],
        )


def columns_of(program: TimedProgram) -> Columns:
    """Collect the numbers of a program into arrays."""
    move_at = [at for at, item in enumerate(program.instructions) if isinstance(item, MoveTo)]
    moves = [item for item in program.instructions if isinstance(item, MoveTo)]
    numbers = np.empty((len(moves), 8))
    if moves:
        numbers[:, :3] = [move.position for move in moves]
        numbers[:, 3:7] = [move.quaternion for move in moves]
        numbers[:, 7] = [move.speed_mm_s for move in moves]
    waits = [(at, item) for at, item in enumerate(program.instructions) if isinstance(item, Wait)]
    spray = [(at, item) for at, item in enumerate(program.instructions) if isinstance(item, SetNozzle)]
    return Columns(
        times=np.array([item.time_s for item in program.instructions], dtype=np.float64),
        move_at=np.array(move_at, dtype=np.int64),
        moves=numbers,
        wait_at=np.array([at for at, _ in waits], dtype=np.int64),
        waits=np.array([wait.duration_s for _, wait in waits], dtype=np.float64),
        spray_at=np.array([at for at, _ in spray], dtype=np.int64),
        spray=np.array([switch.spraying for _, switch in spray], dtype=np.bool_),
    )


@np.errstate(over="ignore")  # numbers beyond every bound are refused later, with their line
def rounded(columns: Columns) -> Columns:
    """Round to the digits of the native file: 0.1 ms, 1 um, 1e-7 of a quaternion, 1 um/s; no negative zero."""
    moves = columns.moves.copy()
    moves[:, :3] = np.round(moves[:, :3], 3)
    moves[:, 3:7] = np.round(moves[:, 3:7], 7)
    moves[:, 7] = np.round(moves[:, 7], 3)
    return replace(
        columns,
        times=np.round(columns.times, 4) + 0.0,
        moves=moves + 0.0,
        waits=np.round(columns.waits, 4) + 0.0,
    )
