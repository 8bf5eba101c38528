"""How well the robot reaches each part of the sprayed paths, as colours along them."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from programs.playback import build_timeline, play
from programs.program import MoveTo, TimedProgram
from robotcell.cell.cell import Cell
from robotcell.robot.robot import limit_share, singularity
from webui.glb.glb import bars, flat_triangles_glb
from webui.layers.robot.robot import JointMotion, clearances_mm, rows_by_tool
from webui.page.evaluations import Checked
from webui.theme.palette import Tints, tint_values

Metric: TypeAlias = Literal["manipulability", "inverse condition", "limits", "clearance"]

METRICS: dict[str, Metric] = {
    "Manipulability": "manipulability",
    "Inverse condition": "inverse condition",
    "Joint limits": "limits",
    "Clearance (mm)": "clearance",
}
"""By their names on the page."""
_STEP_MM = 3.0
_BEND = float(np.cos(np.radians(3.0)))
_WIDER = 1.6
_MARKS = 5


@dataclass(frozen=True, slots=True, eq=False)
class Reached:
    """The sprayed paths of a program, in pieces. Board frame, mm."""

    segments: NDArray[np.float64]
    """(k, 2, 3) begin and end of each piece."""
    move: NDArray[np.intp]
    """(k,) index of the last ``MoveTo`` of each piece."""


@dataclass(frozen=True, slots=True, eq=False)
class Painted:
    """The sprayed paths in the colours of a metric."""

    glb: bytes
    legend: Tints
    worst: tuple[tuple[float, float, float], float] | None
    """Place, mm, and time, s, of the smallest value; ``None`` where all are equal."""


def paint_reach(metric: Metric, check: Checked, width_mm: float) -> Painted:
    """Sprayed paths in the colours of a metric; none where the robot cannot execute the program.

    Args:
        metric: The metric.
        check: The check.
        width_mm: Of the lines of paths.

    Raises:
        CellError: distances need what ``washboard[robot]`` installs, and that is missing.
    """
    if check.motion is None:
        return Painted(b"", {}, None)
    reached = reached_path(check.program)
    if not len(reached.move):
        return Painted(b"", {}, None)
    if metric == "clearance":
        values, farthest = clearances_mm(check.cell.cell, check.run.workpiece, check.motion, reached.move)
        glb, legend = reach_glb(reached, values, (0.0, farthest), width_mm)
        far = f"{farthest:.3g}"
        legend = {f"{mark} or more" if mark == far else mark: tint for mark, tint in legend.items()}
    else:
        values = measure(metric, check.cell.cell, check.motion, reached.move)
        glb, legend = reach_glb(reached, values, (float(values.min()), float(values.max())), width_mm)
    worst, least = None, int(np.argmin(values))
    if np.ptp(values) > 0:
        x, y, z = reached.segments[least, 1].tolist()
        worst = (x, y, z), float(check.motion.times[reached.move[least]])
    return Painted(glb, legend, worst)


def reached_path(program: TimedProgram) -> Reached:
    """Sprayed paths in pieces of a few millimetres, which end at corners."""
    moves = [item for item in program.instructions if isinstance(item, MoveTo)]
    points = np.array([move.position for move in moves])
    times = np.array([move.time_s for move in moves])
    sprayed = play(build_timeline(program), (times[1:] + times[:-1]) / 2).spraying
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    unit = steps / np.maximum(lengths, 1e-12)[:, None]
    bends = np.einsum("ij,ij->i", unit[:-1], unit[1:]) < _BEND
    numbers = np.floor(np.cumsum(lengths) / _STEP_MM)
    ends = np.concatenate([(np.diff(numbers) > 0) | bends | (sprayed[:-1] != sprayed[1:]), [True]])
    last = np.flatnonzero(ends)
    first = np.concatenate([[0], last[:-1] + 1])
    kept = sprayed[last] & (np.linalg.norm(points[last + 1] - points[first], axis=1) > 0)
    return Reached(np.stack([points[first], points[last + 1]], axis=1)[kept], last[kept] + 1)


def measure(metric: Metric, cell: Cell, motion: JointMotion, rows: NDArray[np.intp]) -> Scalars:
    """(k,) values of a metric along a motion; more is better.

    Args:
        metric: The metric, other than the clearance.
        cell: Whose robot it is.
        motion: Joints at each move.
        rows: (k,) indices of the moves.
    """
    joints = motion.joints[rows]
    if metric == "limits":
        return limit_share(cell.robot, joints)
    carried = {tool.number: tool.T_flange_tcp for tool in cell.tools}
    values = np.zeros(len(rows))
    for number, mine in rows_by_tool(motion, rows):
        w, condition = singularity(cell.robot, joints[mine], carried.get(number))
        values[mine] = w if metric == "manipulability" else condition
    return values


def reach_glb(reached: Reached, values: Scalars, scale: tuple[float, float], width_mm: float) -> tuple[bytes, Tints]:
    """Pieces in the colours of their values, over the lines of the paths; and the legend.

    Args:
        reached: The pieces.
        values: (k,) of each.
        scale: Values of the dark and the light end.
        width_mm: Of the lines of paths.
    """
    tints, legend = tint_values(values, {f"{mark:.3g}": mark for mark in np.linspace(*scale, _MARKS)})
    return flat_triangles_glb(*bars(reached.segments, np.array(tints, dtype=np.uint8), _WIDER * width_mm)), legend
