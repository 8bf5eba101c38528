"""What a program does, function by function."""

from collections import defaultdict
from dataclasses import dataclass
from math import dist

from programs.program import Command, MoveTo, SetNozzle, TimedProgram
from specs.source import Source


@dataclass(frozen=True, slots=True)
class FunctionSummary:
    """One stretch of a program between two FUNCTION instructions."""

    function: str
    nozzle: str
    solution: str
    start_s: float
    duration_s: float
    spray_s: float
    spray_mm: float
    travel_mm: float
    """All of the way, spraying or not."""


def by_function(program: TimedProgram) -> tuple[FunctionSummary, ...]:
    """Add up time, spray and way of each step, in order.

    A program without a FUNCTION gives one summary with empty names.
    """
    starts = [
        index
        for index, instruction in enumerate(program.instructions)
        if isinstance(instruction, Command) and instruction.keyword == "FUNCTION"
    ] or [0]
    ends = [*starts[1:], len(program.instructions)]
    return tuple(_stretch(program, start, end) for start, end in zip(starts, ends, strict=True))


def jet_seconds(program: TimedProgram) -> dict[Source, float]:
    """Add up the seconds of the jets by what requested them, in the order of their first; each loop once."""
    seconds = defaultdict[Source, float](float)
    begun: SetNozzle | None = None
    for item in program.instructions:
        if isinstance(item, SetNozzle) and item.spraying != (begun is not None):
            if begun is not None:
                seconds[begun.made_by] += item.time_s - begun.time_s
            begun = item if item.spraying else None
    return dict(seconds)


def _stretch(program: TimedProgram, start: int, end: int) -> FunctionSummary:
    names = {"FUNCTION": "", "NOZZLE": "", "SOLUTION": ""}
    place = next((i.position for i in reversed(program.instructions[:start]) if isinstance(i, MoveTo)), None)
    spray_s = spray_mm = travel_mm = 0.0
    spraying = False
    begin = now = program.instructions[start].time_s
    for instruction in program.instructions[start:end]:
        spray_s += (instruction.time_s - now) * spraying
        now = instruction.time_s
        if isinstance(instruction, MoveTo):
            step = dist(place, instruction.position) if place is not None else 0.0
            travel_mm += step
            spray_mm += step * spraying
            place = instruction.position
        elif isinstance(instruction, SetNozzle):
            spraying = instruction.spraying
        elif isinstance(instruction, Command) and names.get(instruction.keyword) == "":
            names[instruction.keyword] = instruction.arguments[0]
    if end < len(program.instructions):
        now = program.instructions[end].time_s
    return FunctionSummary(
        names["FUNCTION"], names["NOZZLE"], names["SOLUTION"], begin, now - begin, spray_s, spray_mm, travel_mm
    )
