"""The timed program: a flat list of instructions, each with its time."""

from dataclasses import dataclass
from typing import TypeAlias

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
