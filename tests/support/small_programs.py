"""Programs that tests build by hand or at random."""

import math
from collections.abc import Callable

import numpy as np
from hypothesis import strategies as st

from programs.plan import Origin
from programs.program import Command, Instruction, MoveTo, SetNozzle, TimedProgram, Totals, Wait

DOWN = (0.0, 1.0, 0.0, 0.0)
"""Tool +Z along -z of the board, tool +X along +x."""
ORIGIN = Origin("tiny", "9f2c", "smt-aqueous", "77b0")


def program_of(*instructions: Instruction, liquid: tuple[tuple[str, float], ...] = ()) -> TimedProgram:
    """Give instructions the totals that they have."""
    moves = [item for item in instructions if isinstance(item, MoveTo)]
    points = np.array([move.position for move in moves]).reshape(-1, 3)
    travel = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    spray_s, opened = 0.0, math.nan
    for item in instructions:
        if isinstance(item, SetNozzle):
            if item.spraying:
                opened = item.time_s
            elif not math.isnan(opened):
                spray_s, opened = spray_s + item.time_s - opened, math.nan
    end_s = instructions[-1].time_s if instructions else 0.0
    return TimedProgram(ORIGIN, Totals(end_s, spray_s, travel, len(moves), liquid), instructions)


def hand_program() -> TimedProgram:
    """One of everything: down from the park height, a sprayed line, a pause, and up again."""
    made_by = "sequence[0]/edge"
    tilted = (math.sin(math.radians(5)), math.cos(math.radians(5)), 0.0, 0.0)
    return program_of(
        Command(0.0, "FUNCTION", ("clean",), "sequence[0]"),
        Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "sequence[0]"),
        Command(0.0, "SOLUTION", ("saponifier-15",), "sequence[0]"),
        Command(0.0, "SET", ("pressure_bar", "3.500"), "sequence[0]"),
        MoveTo(0.0, (0.0, 0.0, 110.0), DOWN, 0.0, "sequence[0]/start"),
        MoveTo(1.0, (10.0, -0.0001, 60.0), tilted, 50.990, made_by + "/transfer"),
        Command(1.0, "REPEAT", ("4", "UNTIL", "resistivity_mohm_cm", ">=", "1.0"), made_by),
        SetNozzle(1.0, True, made_by),
        MoveTo(2.0, (40.0, 0.0, 60.0), tilted, 30.0, made_by),
        Wait(2.0, 0.2, made_by),
        MoveTo(3.2, (40.0, 20.0, 60.0), tilted, 20.0, made_by),
        SetNozzle(3.2, False, made_by),
        Command(3.2, "ENDREPEAT", (), made_by),
        Command(3.2, "GRIP", ("close",), ""),
        Command(3.2, "CALL", ("flip",), "sequence[1]"),
        MoveTo(4.2, (40.0, 20.0, 110.0), DOWN, 50.0, "sequence[1]/park/transfer"),
        liquid=(("clean", 0.073),),
    )


_NAMES = st.from_regex(r"[A-Za-z][A-Za-z0-9_.-]{0,8}", fullmatch=True)
_MAKERS = st.one_of(
    st.sampled_from(["", "sequence[0]/around/U12", "sequence[0]/around/C1+C2", "a ; b", "größe ; µ"]),
    st.text(max_size=12).filter(lambda text: text.isprintable() and text == text.strip()),
)
_LENGTHS = st.one_of(st.floats(-500, 500), st.floats(-0.001, 0.001))


def _unit(parts: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    length = math.hypot(*parts)
    if length <= 0.1:
        return DOWN
    w, x, y, z = (part / length for part in parts)
    return w, x, y, z


_QUATERNIONS = st.tuples(*4 * [st.floats(-1, 1)]).map(_unit)
# What is said at some time for some maker. Built once: building them for each instruction takes longer than drawing.
_SAID: st.SearchStrategy[Callable[[float, str], Instruction]] = st.one_of(
    st.builds(lambda name: lambda time_s, by: Command(time_s, "FUNCTION", (name,), by), _NAMES),
    st.builds(
        lambda name, n: lambda time_s, by: Command(time_s, "NOZZLE", (name, "TOOL", str(n)), by),
        _NAMES,
        st.integers(0, 99),
    ),
    st.builds(
        lambda name, x: lambda time_s, by: Command(time_s, "SET", (name, f"{x:.3f}"), by), _NAMES, st.floats(-9, 9)
    ),
    st.builds(lambda word: lambda time_s, by: Command(time_s, "GRIP", (word,), by), st.sampled_from(["open", "close"])),
    st.builds(lambda on: lambda time_s, by: SetNozzle(time_s, on, by), st.booleans()),
    st.builds(lambda seconds: lambda time_s, by: Wait(time_s, seconds, by), st.floats(0, 2)),
    st.builds(
        lambda position, quaternion, speed: lambda time_s, by: MoveTo(time_s, position, quaternion, speed, by),
        st.tuples(_LENGTHS, _LENGTHS, _LENGTHS),
        _QUATERNIONS,
        st.floats(0, 300),
    ),
)
_PAUSES = st.one_of(st.just(0.0), st.floats(0, 3))
_COUNTS = st.integers(0, 12)
_FUNCTIONS = st.lists(_NAMES, max_size=2)


@st.composite
def programs(draw: st.DrawFn) -> TimedProgram:
    """Any valid program: it begins at a pose, ends with the jet off and keeps its waits."""
    instructions: list[Instruction] = [MoveTo(0.0, (0.0, 0.0, 110.0), draw(_QUATERNIONS), 0.0, draw(_MAKERS))]
    time_s = 0.0
    for _ in range(draw(_COUNTS)):
        time_s += draw(_PAUSES)
        made_by = draw(_MAKERS)
        item = draw(_SAID)(time_s, made_by)
        instructions.append(item)
        time_s += item.duration_s if isinstance(item, Wait) else 0.0
    instructions.append(SetNozzle(time_s, False, ""))
    return program_of(*instructions, liquid=tuple((name, 1.25) for name in draw(_FUNCTIONS)))
