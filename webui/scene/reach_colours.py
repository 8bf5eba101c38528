"""How well the robot can do each part of the sprayed paths, as colours along them."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from programs.playback import build_timeline, play
from programs.program import MoveTo, TimedProgram
from robotcell.cell.cell import Cell
from robotcell.robot.robot import limit_share, singularity
from webui.glb.glb import flat_triangles_glb
from webui.glb.ribbons import bars
from webui.layers.robot.proximity import clearances_mm
from webui.layers.robot.robot import JointMotion, tool_at
from webui.layers.surface.ground import Tints
from webui.page.checked import Checked
from webui.theme.palette import of_values

Metric: TypeAlias = Literal["manipulability", "inverse condition", "limits", "clearance"]

METRICS: dict[str, Metric] = {
    "Manipulability": "manipulability",
    "Inverse condition": "inverse condition",
    "Joint limits": "limits",
    "Clearance (mm)": "clearance",
}
"""As they are called on the page."""
_STEP_MM = 3.0
_BEND = float(np.cos(np.radians(3.0)))
_WIDER = 1.6
_MARKS = 5


@dataclass(frozen=True, slots=True, eq=False)
class Reached:
    """The sprayed path of a program, in pieces. Board frame, mm."""

    segments: NDArray[np.float64]
    """(k, 2, 3) begin and end of each piece."""
    move: NDArray[np.intp]
    """(k,) the ``MoveTo`` with which each ends, counted among moves."""


@dataclass(frozen=True, slots=True)
class Worst:
    """Where the least value is first."""

    place_mm: tuple[float, float, float]
    time_s: float


@dataclass(frozen=True, slots=True, eq=False)
class Painted:
    """The sprayed paths in the colours of a metric."""

    glb: bytes
    legend: Tints
    worst: Worst | None


def paint_reach(metric: Metric, check: Checked, width_mm: float) -> Painted:
    """Colour what is sprayed by a metric; nothing where the robot cannot do it.

    Args:
        metric: What to measure.
        check: What came of the check.
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
        values, farthest = clearances_mm(check.cell.cell, check.run.board, check.motion, reached.move)
        glb, legend = reach_glb(reached, values, (0.0, farthest), width_mm)
        far = f"{farthest:.3g}"
        legend = {f"{mark} or more" if mark == far else mark: tint for mark, tint in legend.items()}
    else:
        values = measure(metric, check.cell.cell, check.motion, reached.move)
        glb, legend = reach_glb(reached, values, (float(values.min()), float(values.max())), width_mm)
    return Painted(glb, legend, _worst(reached, values, check.motion) if np.ptp(values) > 0 else None)


def reached_path(program: TimedProgram) -> Reached:
    """Collect what is sprayed, in pieces of a few millimetres that leave no corner out."""
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
    """Measure (k,) postures of a motion; more is better.

    Args:
        metric: What to measure, other than the clearance.
        cell: Whose robot it is.
        motion: How the joints stand at each move.
        rows: (k,) which moves.
    """
    joints = motion.joints[rows]
    if metric == "limits":
        return limit_share(cell.robot, joints)
    carried = {tool.number: tool.T_flange_tcp for tool in cell.tools}
    numbers = np.array([tool_at(motion, float(time_s)) for time_s in motion.times[rows]])
    values = np.zeros(len(rows))
    for number in np.unique(numbers).tolist():
        mine = numbers == number
        w, condition = singularity(cell.robot, joints[mine], carried.get(number))
        values[mine] = w if metric == "manipulability" else condition
    return values


def reach_glb(reached: Reached, values: Scalars, scale: tuple[float, float], width_mm: float) -> tuple[bytes, Tints]:
    """Draw pieces in the colours of their values, over the lines of the paths; and the legend.

    Args:
        reached: The pieces.
        values: (k,) of each.
        scale: What is dark, and what is light.
        width_mm: Of the lines of paths.
    """
    marks = np.linspace(*scale, _MARKS)
    colours = of_values(np.concatenate([values, marks]), *scale)
    glb = flat_triangles_glb(*bars(reached.segments, colours[: len(values)], _WIDER * width_mm))
    legend = {
        f"{mark:.3g}": (int(r), int(g), int(b)) for mark, (r, g, b) in zip(marks, colours[len(values) :], strict=True)
    }
    return glb, legend


def _worst(reached: Reached, values: Scalars, motion: JointMotion) -> Worst:
    least = int(np.argmin(values))
    x, y, z = reached.segments[least, 1].tolist()
    return Worst((x, y, z), float(motion.times[reached.move[least]]))
