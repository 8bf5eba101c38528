"""What a controller's log shows of a program that ran: poses or joints and jets over time, with its commands."""

import csv
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count, takewhile
from math import degrees, dist, isfinite
from operator import attrgetter
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Points, Quaternions, Scalars
from programs.driven import when, with_totals
from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.playback import playback
from programs.pose import Pose, Quaternion, unit
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
_STEP_S = 0.01
"""Between poses that are kept, while nothing switches."""
_LARGEST_BYTES = 200_000_000
_JOINT = re.compile(r"j(\d{1,3})_(deg|mm)")
PlacesOfTool: TypeAlias = Callable[[NDArray[np.float64], Pose, Pose], tuple[Points, Quaternions]]
"""Where the orifice is in the board's frame (n, 3) mm, and how it is turned (n, 4), by joints (n, dof) in rad or mm,
T_flange_tcp and T_base_board."""
_Jet: TypeAlias = tuple[SetNozzle, SetNozzle, list[float]]
"""Begin and end of a jet of the program, and where it begins."""


@dataclass(frozen=True, slots=True, eq=False)
class RunLog:
    """A log of n rows: s, mm in the board's frame."""

    file: Path
    seconds: Scalars
    """(n,) increasing, from 0."""
    tcp: Points
    """(n, 3) the orifice; NaN while only the joints are known."""
    quaternion: Quaternions | None
    """(n, 4) w, x, y, z; ``None`` where the log has none."""
    jets: tuple[tuple[float, bool], ...]
    """When jets begin and end."""
    joints: NDArray[np.float64] | None = None
    """(n, dof) degrees and mm, as the controller counts them; ``None`` where the log has places."""
    units: tuple[str, ...] = ()
    """Of each joint: ``deg`` or ``mm``."""

    def place_at(self, seconds: float) -> list[float]:
        """Give where the orifice is at a time."""
        return [float(np.interp(seconds, self.seconds, column)) for column in self.tcp.T]


def read_run_log(file: Path) -> RunLog:
    """Read a table of time, place of the orifice and jet.

    Its first row names the columns: ``time_s`` or ``time_ms``; ``x_mm``, ``y_mm``, ``z_mm`` in the board's frame;
    how the tool is turned by columns of ``_TURNS``, or by none; ``jet``, 1 while a jet is on at the orifice, else 0.
    In place of where the tool is there may be joints, ``j1_deg`` (or ``j1_mm``), ``j2_deg`` and so on, which
    ``place_joints`` takes on. Other columns are left alone. They are separated by commas, semicolons, tabs or blanks.

    Raises:
        ProgramError: a column is missing, a cell is no number, time runs back, or no jet is on.
    """
    lines = InputFile(file, ProgramError, "log", _LARGEST_BYTES).read().decode("utf-8", "replace").splitlines()
    names = _cells(lines[0].lstrip("# "), file, 1) if lines else []
    time = next((each for each in _TIMES if each in names), None)
    turns = next((each for each in _TURNS if set(each) <= set(names)), ())
    of_joints = {int(match[1]): each for each in names if (match := _JOINT.fullmatch(each))}
    joints = tuple(takewhile(bool, (of_joints.get(number, "") for number in count(1))))
    by_joints = bool(joints) and not set(_PLACES) & set(names)
    where = joints if by_joints else _PLACES
    lacking = [each for each in (*where, "jet") if each not in names]
    if time is None or lacking:
        known = ", ".join(("time_s (or time_ms)", *_PLACES, "jet"))
        what = "time_s" if time is None else lacking[0]
        reason = f"the log has no column {what}; its first row names {known}; or j1_deg, j2_deg ... for x, y and z."
        raise ProgramError(reason, file=file, line=1)
    at = [names.index(each) for each in (time, "jet", *where, *(() if by_joints else turns))]
    rows: list[list[float]] = []
    for number, line in enumerate(lines[1:], start=2):
        if line.strip():
            rows.append(_numbers(_cells(line, file, number), at, file, number))
            if len(rows) > 1 and rows[-1][0] <= rows[-2][0]:
                message = f"time goes from {rows[-2][0]:g} to {rows[-1][0]:g}; each row is later than the one before."
                raise ProgramError(message, file=file, line=number)
    table = np.array(rows, dtype=np.float64).reshape(len(rows), len(at))
    seconds, on = _TIMES[time] * table[:, 0], table[:, 1] > 0.5
    changes = np.flatnonzero(np.diff(on.astype(np.int8), prepend=0, append=0))
    if not len(changes):
        raise ProgramError("no jet is on in the log: the column jet is 1 while one is.", file=file)
    seconds = seconds - seconds[0]
    jets = tuple((float(seconds[min(row, len(seconds) - 1)]), number % 2 == 0) for number, row in enumerate(changes))
    if by_joints:
        unknown = np.full((len(table), 3), np.nan)
        return RunLog(file, seconds, unknown, None, jets, table[:, 2:], tuple(each.split("_")[1] for each in joints))
    quaternion = np.array([_TURNS[turns](*row) for row in table[:, 5:].tolist()]) if turns else None
    return RunLog(file, seconds, table[:, 2:5], quaternion, jets)


def place_joints(log: RunLog, program: TimedProgram, installation: Installation, places_of: PlacesOfTool) -> RunLog:
    """Give a log of joints with the places of the orifice: of the tool in use then, on the board as it lay then.

    Which those are is found by where the log's jets begin: of the tools and places that the program's jets have, the
    one whose jets begin nearest counts from the end of the jet before.

    Args:
        log: With joints.
        program: What was to run.
        installation: The cell.
        places_of: Forward kinematics.

    Raises:
        ProgramError: the joints are not those of the cell's robot, the program has no jet, or the cell lacks a tool.
    """
    kinds = tuple("deg" if joint.kind == "revolute" else "mm" for joint in installation.joints)
    if log.joints is None or log.units != kinds:
        due = ", ".join(f"j{number}_{kind}" for number, kind in enumerate(kinds, start=1))
        message = (
            f"the joints are not those of robot {installation.robot} of cell {installation.cell}, which are {due}."
        )
        raise ProgramError(message, file=log.file, line=1)
    joints, held = _as_the_cell_counts(log.joints, installation), list(_held(program, installation))
    if not held:
        raise ProgramError(
            "a jet is on in the log, and the program has none: it is not of this program.", file=log.file
        )
    begins = playback(program, np.array([seconds for seconds, _ in held])).tcp
    rows = np.searchsorted(log.seconds, [seconds for seconds, _ in log.jets])
    ways: dict[tuple[int, str], tuple[Points, Quaternions]] = {}
    apart: dict[tuple[int, str], list[float]] = {}
    for tool, placement in dict.fromkeys(combination for _, combination in held):
        if tool not in installation.tools:
            raise ProgramError(f"the program has tool {tool}, and cell {installation.cell} has none of that number.")
        lies = installation.placements[placement] if placement else installation.T_base_board
        ways[tool, placement] = way = places_of(joints, installation.tools[tool].T_flange_tcp, lies)
        own = begins[[combination == (tool, placement) for _, combination in held]]
        apart[tool, placement] = [float(np.linalg.norm(own - each, axis=1).min()) for each in way[0][rows[::2]]]
    used = [held[0][1]]
    for jet in range(len(rows) // 2):
        near = [each for each, far in apart.items() if far[jet] <= _NEAR_MM]
        used.append(used[-1] if used[-1] in near else min(apart, key=lambda each: apart[each][jet]))
    borders = [0, *(rows[1:-1:2] + 1).tolist(), len(log.seconds)]
    pieces = [(ways[each], slice(a, b)) for each, a, b in zip(used[1:], borders, borders[1:], strict=False)]
    tcp, quaternion = (np.concatenate([way[part][piece] for way, piece in pieces]) for part in (0, 1))
    return replace(log, tcp=tcp, quaternion=quaternion)


def _as_the_cell_counts(counted: NDArray[np.float64], installation: Installation) -> NDArray[np.float64]:
    """Give joints (n, dof) in rad or mm as the cell counts them, of those of its controller in degrees or mm."""
    values, machine = counted.copy(), installation.tool_point
    if installation.convention is not None:
        shifted = values - np.array(installation.convention.zeros)
        values = np.linalg.solve(np.array(installation.convention.rows), shifted.T).T
    elif machine is not None:
        turning = (
            (machine.swing, machine.signs[0], machine.swing_zero),
            (7 - machine.swing, machine.signs[1], machine.tilt_zero),
        )
        for at, sign, zero in turning:
            values[:, at] = sign * (values[:, at] - degrees(zero))
    turns = [joint.kind == "revolute" for joint in installation.joints]
    return np.where(turns, np.radians(values), values)


def _held(program: TimedProgram, installation: Installation) -> Iterator[tuple[float, tuple[int, str]]]:
    """Give when each jet of a program begins, the tool that it is of, and the name of the board's place then."""
    tool, placement, on = 0, "", False
    for item in program.instructions:
        match item:
            case Command(keyword="NOZZLE", arguments=(_, _, number, *_)):
                tool = int(number)
            case Command(keyword="CALL", arguments=(name, *_)) if name in installation.placements:
                placement = name
            case SetNozzle():
                if item.spraying and not on:
                    yield item.time_s, (tool, placement)
                on = item.spraying
            case _:
                pass


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
            where = ", ".join(f"{each:z.1f}" for each in place)
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

    def run(rounds: Sequence[int]) -> tuple[TimedProgram, list[_Jet]]:
        repeated = _repeated(program, loops, rounds)
        return repeated, _jets(repeated, log)

    rounds = [1] * len(loops)
    for number, (_, _, most) in enumerate(loops):  # what is before a loop fits already, so its own rounds decide
        tries = [[*rounds[:number], each, *rounds[number + 1 :]] for each in range(1, most + 1)]
        rounds = min(tries, key=lambda each: _misfit(run(each)[1], log))
    return run(rounds)


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
    """How many jets of a log there are from the first that is none of these, and how many of these it lacks."""
    begins = [log.place_at(seconds) for seconds, _ in log.jets[::2]]
    pairs = zip(begins, jets, strict=False)
    fit = sum(1 for _ in takewhile(lambda each: dist(each[0], each[1][2]) <= _NEAR_MM, pairs))
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
