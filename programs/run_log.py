"""What a controller's log shows of a program that ran: poses and jets over time, with the program's commands."""

import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import islice, product
from math import dist, isfinite
from operator import attrgetter
from pathlib import Path
from typing import TypeAlias

import numpy as np

from geometry.arrays import Points, Quaternions, Scalars
from programs.driven import when, with_totals
from programs.errors import ProgramError
from programs.playback import playback
from programs.pose import Quaternion, unit
from programs.posts.writing.angles import from_fixed_xyz, from_moving_zyx, from_rotation_vector
from programs.program import Command, Instruction, MoveTo, SetNozzle, TimedProgram
from specs.input_file import InputFile

_TIMES = {"time_s": 1.0, "time_ms": 1e-3}
_PLACES = ("x_mm", "y_mm", "z_mm")
_TURNS: dict[tuple[str, ...], Callable[..., Quaternion]] = {
    ("qw", "qx", "qy", "qz"): lambda *each: unit(each),
    ("rx_rad", "ry_rad", "rz_rad"): from_rotation_vector,
    ("a_deg", "b_deg", "c_deg"): from_moving_zyx,
    ("w_deg", "p_deg", "r_deg"): from_fixed_xyz,
}
"""How the tool may be turned, by the columns"""
_NEAR_MM = 10.0
"""From where a jet is planned to begin, to where the log has it."""
_GAP_S = 0.25
"""Between two jets, for which a valve may stay open."""
_MOST_TRIES = 100
"""How often loops may have been run, tried one after the other."""
_STEP_S = 0.01
"""Between poses that are kept, while nothing switches."""
_LARGEST_BYTES = 200_000_000
_Jet: TypeAlias = tuple[SetNozzle, SetNozzle, list[float]]
"""Begin and end of a jet of the program, and where it begins."""


@dataclass(frozen=True, slots=True, eq=False)
class RunLog:
    """A log of n rows: s, mm in the board's frame."""

    file: Path
    seconds: Scalars
    """(n,) increasing, from 0."""
    tcp: Points
    """(n, 3) the orifice."""
    quaternion: Quaternions | None
    """(n, 4) w, x, y, z; ``None`` where the log has none."""
    jets: tuple[tuple[float, bool], ...]
    """When jets begin and end."""

    def place_at(self, seconds: float) -> list[float]:
        """Give where the orifice is at a time."""
        return [float(np.interp(seconds, self.seconds, column)) for column in self.tcp.T]


def read_run_log(file: Path) -> RunLog:
    """Read a table of time, place of the orifice and jet.

    Its first row names the columns: ``time_s`` or ``time_ms``; ``x_mm``, ``y_mm``, ``z_mm`` in the board's frame;
    how the tool is turned by columns of ``_TURNS``, or by none; ``jet``, 1 while a jet is on at the orifice, else 0.
    Other columns are left alone. They are separated by commas, semicolons, tabs or blanks.

    Raises:
        ProgramError: a column is missing, a cell is no number, time runs back, or no jet is on.
    """
    lines = InputFile(file, ProgramError, "log", _LARGEST_BYTES).read().decode("utf-8", "replace").splitlines()
    names = _cells(lines[0].lstrip("# "), file, 1) if lines else []
    time = next((each for each in _TIMES if each in names), None)
    turns = next((each for each in _TURNS if set(each) <= set(names)), ())
    lacking = [each for each in (*_PLACES, "jet") if each not in names]
    if time is None or lacking:
        known = ", ".join(("time_s (or time_ms)", *_PLACES, "jet"))
        what = "time_s" if time is None else lacking[0]
        raise ProgramError(f"the log has no column {what}; its first row names {known}.", file=file, line=1)
    at = [names.index(each) for each in (time, *_PLACES, "jet", *turns)]
    rows: list[list[float]] = []
    for number, line in enumerate(lines[1:], start=2):
        if line.strip():
            rows.append(_numbers(_cells(line, file, number), at, file, number))
            if len(rows) > 1 and rows[-1][0] <= rows[-2][0]:
                message = f"time goes from {rows[-2][0]:g} to {rows[-1][0]:g}; each row is later than the one before."
                raise ProgramError(message, file=file, line=number)
    table = np.array(rows, dtype=np.float64).reshape(len(rows), len(at))
    seconds, on = _TIMES[time] * table[:, 0], table[:, 4] > 0.5
    changes = np.flatnonzero(np.diff(on.astype(np.int8), prepend=0, append=0))
    if not len(changes):
        raise ProgramError("no jet is on in the log: the column jet is 1 while one is.", file=file)
    seconds = seconds - seconds[0]
    jets = tuple((float(seconds[min(row, len(seconds) - 1)]), number % 2 == 0) for number, row in enumerate(changes))
    quaternion = np.array([_TURNS[turns](*row) for row in table[:, 5:].tolist()]) if turns else None
    return RunLog(file, seconds, table[:, 1:4], quaternion, jets)


def _cells(text: str, file: Path, line: int) -> list[str]:
    delimiter = next((each for each in ",;\t" if each in text), None)
    try:
        cells = text.split() if delimiter is None else next(csv.reader([text], delimiter=delimiter))
    except csv.Error as error:
        raise ProgramError(f"this is no row of a table: {error}.", file=file, line=line) from None
    return [each.strip() for each in cells]


def _numbers(cells: Sequence[str], at: Sequence[int], file: Path, line: int) -> list[float]:
    try:
        values = [float(cells[column]) for column in at]
    except (IndexError, ValueError):
        raise ProgramError(f"{','.join(cells)[:60]!r} has no number in each column.", file=file, line=line) from None
    if not all(isfinite(each) and abs(each) < 1e9 for each in values):
        raise ProgramError("a number is not finite, or beyond 1e9.", file=file, line=line)
    return values


def program_of_log(log: RunLog, program: TimedProgram) -> TimedProgram:
    """Give what ran as a program: poses and jets of the log, commands and sources of the program.

    Its jets are those of the program in their order, each of which begins where that does; a run that was ended earlier
    has fewer. A loop that a sensor ends was run as often as fits the log.

    Raises:
        ProgramError: the log has another jet than the program, or more of them.
    """
    planned_once = program
    program, jets = _as_often_as_run(program, log)
    planned, begins = [item for begin, end, _ in jets for item in (begin, end)], [place for _, _, place in jets]
    if len(log.jets) > len(planned):
        raise ProgramError(
            f"the log has {len(log.jets) // 2} jets, the program {len(planned) // 2}: it is of another program, "
            "or of one that was run more than once.",
            file=log.file,
        )
    for number, (seconds, _) in enumerate(log.jets[::2]):
        place = log.place_at(seconds)
        if dist(place, begins[number]) > _NEAR_MM:
            where = ", ".join(f"{each:.1f}" for each in place)
            raise ProgramError(
                f"jet {number + 1} of the log begins at {where} mm, {dist(place, begins[number]):.1f} mm from where "
                "the program has it: the log is of another program, or not in the board's frame.",
                file=log.file,
            )
    ran = [(0.0, 0.0), *((item.time_s, there) for item, (there, _) in zip(planned, log.jets, strict=False))]
    end_s = program.instructions[-1].time_s if len(log.jets) == len(planned) else ran[-1][0] + 1e-3
    ran.append((max(end_s, ran[-1][0]), float(log.seconds[-1])))
    times, there = (np.maximum.accumulate(np.array(each)) for each in zip(*ran, strict=True))
    commands: list[Instruction] = [
        replace(item, time_s=when(times, there, "left", item.time_s))
        for item in program.instructions
        if isinstance(item, Command) and item.time_s <= end_s
    ]
    switched = [replace(item, time_s=seconds) for item, (seconds, _) in zip(planned, log.jets, strict=False)]
    moved = [*commands, *_poses(log, program, (times, there)), *switched]
    return with_totals(planned_once, sorted(moved, key=attrgetter("time_s")))


def _as_often_as_run(program: TimedProgram, log: RunLog) -> tuple[TimedProgram, list[_Jet]]:
    """Give a program whose loops are run as often as its log has them, and its jets."""
    loops: list[tuple[int, int, int]] = []
    for number, item in enumerate(program.instructions):
        if isinstance(item, Command) and item.keyword == "REPEAT":
            loops.append((number, number, int(item.arguments[0])))
        elif isinstance(item, Command) and item.keyword == "ENDREPEAT":
            loops[-1] = (loops[-1][0], number, loops[-1][2])
    tries = islice(product(*(range(1, most + 1) for _, _, most in loops)), _MOST_TRIES)
    runs = (_repeated(program, loops, rounds) for rounds in tries)
    return min(((each, _jets(each, log)) for each in runs), key=lambda each: _misfit(each[1], log))


def _repeated(program: TimedProgram, loops: Sequence[tuple[int, int, int]], rounds: Sequence[int]) -> TimedProgram:
    done: list[Instruction] = []
    at, later_s = 0, 0.0
    for (begin, end, _), times in zip(loops, rounds, strict=True):
        lasts_s = program.instructions[end].time_s - program.instructions[begin].time_s
        for _ in range(times - 1):
            done += [replace(item, time_s=item.time_s + later_s) for item in program.instructions[at:end]]
            at, later_s = begin + 1, later_s + lasts_s
    done += [replace(item, time_s=item.time_s + later_s) for item in program.instructions[at:]]
    return replace(program, instructions=tuple(done))


def _jets(program: TimedProgram, log: RunLog) -> list[_Jet]:
    switches = [item for item in program.instructions if isinstance(item, SetNozzle)]
    was_on = [False, *(item.spraying for item in switches)]
    switches = [item for item, before in zip(switches, was_on, strict=False) if item.spraying != before]
    begins = playback(program, np.array([item.time_s for item in switches[::2]])).tcp.tolist()
    return _without_gaps(list(zip(switches[::2], switches[1::2], begins, strict=False)), log)


def _misfit(jets: Sequence[_Jet], log: RunLog) -> tuple[int, int]:
    """How many jets of a log are none of these, and how many of these it lacks."""
    begins = [log.place_at(seconds) for seconds, _ in log.jets[::2]]
    fit = sum(dist(there, place) <= _NEAR_MM for there, (_, _, place) in zip(begins, jets, strict=False))
    return len(begins) - fit, abs(len(jets) - len(begins))


def _without_gaps(planned: Sequence[_Jet], log: RunLog) -> list[_Jet]:
    """Leave out the gaps between jets in which the valve stayed open: short ones after which the log has no begin."""
    kept: list[_Jet] = []
    for number, jet in enumerate(planned):
        at = 2 * len(kept)
        stayed_open = bool(kept) and jet[0].time_s - kept[-1][1].time_s < _GAP_S
        if stayed_open and at < len(log.jets):
            # The next begin is not this jet's but the next one's, or farther away than any may be.
            there = log.place_at(log.jets[at][0])
            first_mm, *next_mm = (dist(there, place) for _, _, place in planned[number : number + 2])
            stayed_open = first_mm > min(_NEAR_MM, *next_mm)
        if stayed_open:
            kept[-1] = (kept[-1][0], jet[1], kept[-1][2])
        else:
            kept.append(jet)
    return kept


def _poses(log: RunLog, program: TimedProgram, clock: tuple[Scalars, Scalars]) -> list[Instruction]:
    """Give the poses of a log, some of many, with the sources, and where it has none the orientations, of the plan."""
    switched = np.searchsorted(log.seconds, [seconds for seconds, _ in log.jets])
    ends = np.searchsorted(log.seconds, np.arange(0.0, log.seconds[-1], _STEP_S))
    rows = np.unique(np.clip([*switched, *ends, len(log.seconds) - 1], 0, len(log.seconds) - 1))
    times, there = clock
    states = playback(program, np.interp(log.seconds[rows], there, times))
    turns = states.quaternion if log.quaternion is None else log.quaternion[rows]
    columns = log.seconds[rows].tolist(), log.tcp[rows].tolist(), turns.tolist(), states.made_by.tolist()
    return [
        MoveTo(at, (x, y, z), (a, b, c, d), 0.0, states.makers[maker])
        for at, (x, y, z), (a, b, c, d), maker in zip(*columns, strict=True)
    ]
