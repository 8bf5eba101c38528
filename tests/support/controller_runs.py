"""Programs of a gantry's cell on LinuxCNC's real controller, held against what was planned.

The controller's log has joints; the orifice follows by the formulas of ``5axiskins``. It is compared with the robot's
program: the way of the orifice while a jet is on, and where and when each jet begins and ends, lags included.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from real_linuxcnc import CYCLE_S, Axis, ControllerLog, Surroundings, run_on_linuxcnc
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from programs.motion.installation import Installation
from programs.playback import playback
from programs.program import Command, MoveTo, SetNozzle, TimedProgram
from robotcell.robot.robot import Robot

_STEP_S = 2e-4
"""Between the places of a planned way, at 60 mm/s about 0.01 mm."""
_LATE_S = 0.05
"""By which a jet may begin before the way that is planned, or end after it: edges have limits of their own."""
_AROUND = round(0.6 / CYCLE_S)
_ALIKE_MM = 0.02
"""What the orifice may be farther from a place than it comes to it, to be there."""


@dataclass(frozen=True, slots=True)
class Edge:
    """A jet's begin or end."""

    valve: str
    on: bool
    seconds: float
    """In the log, or in the robot's program."""


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """What the controller did with a program."""

    log: ControllerLog
    whole_s: float
    """From the first motion to the last."""
    path_s: float
    """From the end of the joint motion to the first pose to the beginning of the one home."""
    home_s: float
    """Of that one."""
    edges: tuple[Edge, ...]
    planned: tuple[Edge, ...]
    edge_mm: tuple[float, ...]
    """Of each edge, from where it is planned."""
    edge_s: tuple[float, ...]
    """Of each edge, from when the orifice is there."""
    off_mm: float
    """Largest distance of the orifice from its planned way while a jet is on."""
    left_out_mm: float
    """Largest distance of that way from where the orifice went."""


def run_program(file: Path, program: TimedProgram, robot: Robot, cell: Installation, limit_s: float) -> Run:
    """Run an exported program, and hold the log against the robot's program (from home to home)."""
    machine = cell.tool_point
    assert machine is not None
    contacts = tuple(wait.contact.number for wait in cell.waits if wait.contact is not None)
    log = run_on_linuxcnc(
        file,
        axes_of(robot),
        "5axiskins coordinates=XYZBCW",
        pivot_mm=machine.pivot_mm,
        limit_s=limit_s,
        around=Surroundings(contacts=contacts),
    )
    return compare(log, file.read_text("ascii").splitlines(), program, cell)


def axes_of(robot: Robot) -> tuple[Axis, ...]:
    """Give the axes of a gantry in the order of the module's joints, with W, which rests."""
    axes: list[Axis] = []
    for letter in "XYZBC":
        (joint,) = (each for each in robot.joints if each.name == letter)
        size = float(np.degrees(1.0)) if letter in "BC" else 1e3
        limits = (size * value for value in (joint.lowest, joint.highest, joint.speed, joint.acceleration))
        axes.append(Axis(letter, letter in "BC", *limits))
    return (*axes, Axis("W", turns=False, least=-1.0, most=1.0, speed=10.0, acceleration=100.0))


def tool_points(log: ControllerLog, text: list[str], cell: Installation) -> NDArray[np.float64]:
    """Give the orifice (n, 3) at each servo cycle, mm in the board's frame as the cell holds it then."""
    machine = cell.tool_point
    assert machine is not None
    b, c = np.radians(log.joints[:, 3]), np.radians(log.joints[:, 4])
    reach = machine.pivot_mm * np.sin(b)
    across = np.stack((reach * np.cos(c), reach * np.sin(c), machine.pivot_mm * (1.0 - np.cos(b))), axis=1)
    tips, lines = log.joints[:, :3] + across - np.array(machine.base), _lines_of(text)
    points, begin = np.empty_like(tips), {0: cell.T_base_board}
    for number, block in enumerate(text, 1):
        if (call := re.match(r"o<(\w+)> call", block)) and call[1] in cell.placements:
            before = np.flatnonzero((log.blocks >= lines[0]) & (log.blocks < number))
            begin[int(before[-1]) + 1] = cell.placements[call[1]]
    for first, placed in begin.items():
        turn = Rotation.from_quat(placed.quaternion, scalar_first=True)
        points[first:] = turn.inv().apply(tips[first:] - np.array(placed.position))
    return points


def compare(log: ControllerLog, text: list[str], program: TimedProgram, cell: Installation) -> Run:
    """Hold a log against the text that was run and the robot's program."""
    blocks = _lines_of(text)
    driven = np.flatnonzero((log.blocks >= blocks[0]) & (log.blocks <= blocks[-1]))
    begin, last = int(driven[0]), int(driven[-1]) + 1
    home = np.flatnonzero(log.blocks[last:] > blocks[-1])  # a block's number is 0 while the machine dwells
    end = last + int(home[0] if len(home) else 0)
    moving, orifice = log.moving, tool_points(log, text, cell)
    edges, planned = sorted(_edges(log, cell), key=_when), tuple(_planned(program, cell))
    places = playback(program, np.array([edge.seconds for edge in planned])).tcp
    apart = [_apart(orifice, edge, place) for edge, place in zip(edges, places, strict=False)]
    ways = list(_ways(orifice, edges, program, planned))
    return Run(
        log=log,
        whole_s=(moving.stop - moving.start) * CYCLE_S,
        path_s=(end - begin) * CYCLE_S,
        home_s=(moving.stop - end) * CYCLE_S,
        edges=tuple(edges),
        planned=planned,
        edge_mm=tuple(off for off, _ in apart),
        edge_s=tuple(late for _, late in apart),
        off_mm=max(off for off, _ in ways),
        left_out_mm=max(left_out for _, left_out in ways),
    )


def _lines_of(text: list[str]) -> list[int]:
    """Give the numbers of the blocks that move the orifice; main calls them from the end of the file."""
    return [number for number, block in enumerate(text, 1) if "G1 " in block and not block.startswith("(")]


def _when(edge: Edge) -> float:
    return edge.seconds


def _edges(log: ControllerLog, cell: Installation) -> Iterator[Edge]:
    """Give the jets' edges of a log."""
    for name in dict.fromkeys(valve.channel.number for valve in cell.valves.values()):
        (valve, *_) = (each for each in cell.valves.values() if each.channel.number == name)
        for seconds, on in log.edges(f"P{name}") if f"P{name}" in log.outputs else ():
            yield Edge(valve.channel.name, on, seconds + (valve.open_lag_s if on else valve.close_lag_s))


def _planned(program: TimedProgram, cell: Installation) -> Iterator[Edge]:
    """Give the jets' edges of a program, but for those between which the valve cannot shut: it stays open."""
    nozzle, off = "", None
    for item in program.instructions:
        match item:
            case Command(keyword="NOZZLE", arguments=(name, *_)):
                nozzle = name
            case SetNozzle():
                valve = cell.valves[nozzle]
                edge = Edge(valve.channel.name, item.spraying, item.time_s)
                if off is not None:
                    shut_s = edge.seconds - valve.open_lag_s - (off.seconds - valve.close_lag_s)
                    if edge.valve != off.valve or shut_s >= valve.min_pulse_s:
                        yield from (off, edge)
                    off = None
                elif edge.on:
                    yield edge
                else:
                    off = edge
            case _:
                pass
    if off is not None:
        yield off


def _apart(orifice: NDArray[np.float64], edge: Edge, place: NDArray[np.float64]) -> tuple[float, float]:
    """Give how far an edge is from its place, and from when the orifice is there."""
    at = round(edge.seconds / CYCLE_S)
    off = np.linalg.norm(orifice[at - _AROUND : at + _AROUND + 1] - place, axis=1)
    there = np.flatnonzero(off <= off.min() + _ALIKE_MM)
    return float(off[_AROUND]), float(np.abs(there - _AROUND).min()) * CYCLE_S


def _ways(
    orifice: NDArray[np.float64], edges: list[Edge], program: TimedProgram, planned: tuple[Edge, ...]
) -> Iterator[tuple[float, float]]:
    """Compare the way of each jet with the planned one: the largest distance of either from the other."""
    moves = np.array([item.time_s for item in program.instructions if isinstance(item, MoveTo)])
    for (on, off), (begin, end) in zip(pairwise(edges), pairwise(planned), strict=False):
        if not on.on:
            continue
        way, beyond = (_way(program, moves, begin.seconds - late, end.seconds + late) for late in (0.0, _LATE_S))
        went = orifice[round(on.seconds / CYCLE_S) : round(off.seconds / CYCLE_S) + 1]
        yield float(cKDTree(beyond).query(went)[0].max()), float(cKDTree(went).query(way)[0].max())


def _way(program: TimedProgram, moves: NDArray[np.float64], begin: float, end: float) -> NDArray[np.float64]:
    """Give places (n, 3) of the planned way between two times, at its moves and between them."""
    times = np.concatenate((np.arange(begin, end, _STEP_S), moves[(moves > begin) & (moves < end)], [end]))
    return playback(program, np.sort(times)).tcp
