"""Small programs for robots, and what to judge the robot's motion by."""

import math

import numpy as np
from small_programs import DOWN, program_of

from programs.program import Command, Instruction, MoveTo, SetNozzle, TimedProgram, Wait
from robotcell.cell.cell import Cell
from robotcell.robot.robot import flange_poses
from robotcell.track import CellReport
from specs.source import Source

MADE_BY = "sequence[0]/sweep"
HEIGHT = 60.0


def tilted(degrees: float, direction_deg: float = 0.0) -> tuple[float, float, float, float]:
    """Jet down, then tilted towards a direction."""
    half, way = math.radians(degrees) / 2, math.radians(direction_deg)
    # (turn about a level axis at right angles to the direction) times (half a turn about x)
    x, y = math.sin(half) * math.sin(way), -math.sin(half) * math.cos(way)
    return (-x, math.cos(half), 0.0, y) if abs(y) + abs(x) > 0 else DOWN


X_SPEED = 0


def line_program(
    speed: float = 50.0, length: float = 60.0, nozzle: str = "ring60", tool: int = 1, accelerate: float = 500.0
) -> TimedProgram:
    """Down, a sprayed line along x as a trapezoid of speed, a rest, a corner, another line, and up again."""
    told: list[Instruction] = [
        Command(0.0, "FUNCTION", ("clean",), "sequence[0]"),
        Command(0.0, "NOZZLE", (nozzle, "TOOL", str(tool)), "sequence[0]"),
    ]
    now = _go(told, 0.0, (20, 20, 110), (20, 20, HEIGHT), 100.0, f"{MADE_BY}/transfer", accelerate=accelerate)
    told.append(SetNozzle(now, True, MADE_BY))
    now = _go(told, now, (20, 20, HEIGHT), (20 + length, 20, HEIGHT), speed, MADE_BY, accelerate=accelerate)
    told.append(Wait(now, 0.3, MADE_BY))
    now = _go(
        told, now + 0.3, (20 + length, 20, HEIGHT), (20 + length, 40, HEIGHT), speed, MADE_BY, accelerate=accelerate
    )
    told.append(SetNozzle(now, False, MADE_BY))
    _go(told, now, (20 + length, 40, HEIGHT), (20 + length, 40, 110), 100.0, "sequence[0]/park", accelerate=accelerate)
    return program_of(*told, liquid=(("clean", 1.0),))


def split_program(over_mm: float = 140) -> TimedProgram:
    """A sprayed line near the robot, a flight over a height in its middle, and a sprayed line far from the robot."""
    told: list[Instruction] = [
        Command(0.0, "FUNCTION", ("clean",), "sequence[0]"),
        Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "sequence[0]"),
    ]
    now, fly = 0.0, f"{MADE_BY}/transfer"
    for begin, end in ((-200, -170), (300, 330)):
        now = _go(told, now, (begin, 20, 110), (begin, 20, HEIGHT), 100.0, fly, accelerate=500.0)
        told.append(SetNozzle(now, True, MADE_BY))
        now = _go(told, now, (begin, 20, HEIGHT), (end, 20, HEIGHT), 50.0, MADE_BY, accelerate=500.0)
        told.append(SetNozzle(now, False, MADE_BY))
        now = _go(told, now, (end, 20, HEIGHT), (end, 20, 110), 100.0, fly, accelerate=500.0)
        if end < 0:
            now = _go(told, now, (end, 20, 110), (60, 20, over_mm), 100.0, fly, accelerate=500.0)
            now = _go(told, now, (60, 20, over_mm), (300, 20, 110), 100.0, fly, accelerate=500.0)
    return program_of(*told, liquid=(("clean", 1.0),))


def lines_program() -> TimedProgram:
    """Three sprayed lines of 100 mm side by side, all one way, with flights of one height between them."""
    told: list[Instruction] = [
        Command(0.0, "FUNCTION", ("clean",), "sequence[0]"),
        Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "sequence[0]"),
    ]
    now, fly, at = 0.0, f"{MADE_BY}/transfer", (0.0, 0.0, 110.0)
    for y in (0.0, 45.0, 90.0):
        for place in ((0.0, y, 110.0), (0.0, y, HEIGHT)):
            if place != at:
                now, at = _go(told, now, at, place, 200.0, fly, accelerate=500.0), place
        told.append(SetNozzle(now, True, MADE_BY))
        now = _go(told, now, at, (100.0, y, HEIGHT), 50.0, MADE_BY, accelerate=500.0)
        told.append(SetNozzle(now, False, MADE_BY))
        now = _go(told, now, (100.0, y, HEIGHT), (100.0, y, 110.0), 200.0, fly, accelerate=500.0)
        at = (100.0, y, 110.0)
    return program_of(*told, liquid=(("clean", 1.0),))


def _go(
    told: list[Instruction],
    now: float,
    begin: tuple[float, float, float],
    end: tuple[float, float, float],
    speed: float,
    made_by: Source,
    *,
    accelerate: float,
) -> float:
    a, b = np.array(begin, dtype=float), np.array(end, dtype=float)
    length = float(np.linalg.norm(b - a))
    top = min(speed, math.sqrt(length * accelerate))
    ramp = top / accelerate
    total = 2 * ramp + (length - top * ramp) / top
    last = a
    for at in np.linspace(0.0, total, max(2, math.ceil(total / 0.008)) + 1)[0 if not _moves(told) else 1 :]:
        up, down = min(at, ramp), max(at - (total - ramp), 0.0)
        way = accelerate * up**2 / 2 + top * (max(at - ramp, 0.0)) - accelerate * down**2 / 2
        place = a + (b - a) * min(way / length, 1.0)
        told.append(MoveTo(now + at, tuple(place.tolist()), DOWN, float(np.linalg.norm(place - last)) / 0.008, made_by))
        last = place
    return now + total


def _moves(told: list[Instruction]) -> bool:
    return any(isinstance(item, MoveTo) for item in told)


def moves_of(program: TimedProgram) -> list[MoveTo]:
    return [item for item in program.instructions if isinstance(item, MoveTo)]


def reached_mm(report: CellReport, tool: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Where the joints bring the orifice (m, 3) in the board frame, mm, and the jet's direction (m, 3)."""
    cell: Cell = report.cell
    poses = cell.T_cell_base @ flange_poses(cell.robot, report.joints) @ cell.tools[tool].T_flange_tcp
    poses = np.linalg.inv(cell.T_cell_board) @ poses
    return poses[:, :3, 3] * 1e3, poses[:, :3, 2]


def rates(report: CellReport) -> tuple[np.ndarray, np.ndarray]:
    """Joint speeds (m - 1, dof) and accelerations (m - 2, dof) between the moves of the robot's program."""
    times = np.array([move.time_s for move in moves_of(report.program)])
    lasting = np.diff(times)
    keep = np.concatenate(([True], lasting > 1e-7))
    times, q = times[keep], report.joints[keep]
    lasting = np.diff(times)
    speed = np.diff(q, axis=0) / lasting[:, None]
    return speed, np.diff(speed, axis=0) / (0.5 * (lasting[:-1] + lasting[1:]))[:, None]
