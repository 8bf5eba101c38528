"""A robot cell as coloured triangles, the joints of a robot over time, and its clearance: the nearest bodies."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from geometry.arrays import Points, Scalars
from programs.program import Command, MoveTo, TimedProgram, Wait
from robotcell.cell.cell import Cell
from robotcell.robot.meshes import placed_triangles
from robotcell.robot.robot import Body, Joints, inverse
from webui.glb.glb import bars, flat_triangles_glb, triangles_glb
from webui.theme.palette import COLLIDING, Tint

if TYPE_CHECKING:
    from robotcell.collision.body_pairs import Touch
    from robotcell.collision.collision import Collider
    from robotcell.track import CellReport


@dataclass(frozen=True, slots=True, eq=False)
class JointMotion:
    """Joints at each move of a program; rad or m."""

    times: Scalars
    """(m,) program time of each move, s, not decreasing."""
    clock: Scalars
    """(m,) time of each move without the waits before it, s, not decreasing."""
    joints: Joints
    """(m, dof)"""
    wait_ends: Scalars
    """(2 w,) begin and end of each wait, program time."""
    waited: Scalars
    """(2 w,) total wait until then, s."""
    tool_times: Scalars
    """(t,) time of each tool change, s."""
    tools: tuple[int, ...]
    """(t,) its number."""


def joint_motion(program: TimedProgram, joints: Joints) -> JointMotion:
    """Joints of a program, arranged for interpolation in time.

    Args:
        program: As the robot executes it.
        joints: (moves, dof) at each ``MoveTo``.
    """
    waits = [(item.time_s, item.duration_s) for item in program.instructions if isinstance(item, Wait)]
    begins = np.array([begin for begin, _ in waits], dtype=np.float64)
    lasting = np.array([duration for _, duration in waits], dtype=np.float64)
    waited = np.cumsum(lasting)
    ends = np.column_stack([begins, begins + lasting]).ravel()
    held = np.column_stack([waited - lasting, waited]).ravel()
    times = np.array([item.time_s for item in program.instructions if isinstance(item, MoveTo)], dtype=np.float64)
    commands = [each for each in program.instructions if isinstance(each, Command)]
    taken = [(each.time_s, int(each.arguments[2])) for each in commands if each.keyword == "NOZZLE"]
    return JointMotion(
        times=times,
        clock=np.maximum.accumulate(times - _waited(ends, held, times)),
        joints=joints,
        wait_ends=ends,
        waited=held,
        tool_times=np.array([time_s for time_s, _ in taken], dtype=np.float64),
        tools=tuple(number for _, number in taken),
    )


def joints_at(motion: JointMotion, times_s: Scalars) -> Joints:
    """(n, dof) joints at any times; constant during waits and outside of the program."""
    clock = times_s - _waited(motion.wait_ends, motion.waited, times_s)
    return np.column_stack([np.interp(clock, motion.clock, column) for column in motion.joints.T])


def tool_at(motion: JointMotion, time_s: float) -> int:
    """Number of the tool in use at a time; of the first one before it is taken, 0 where there is none."""
    taken = int(np.searchsorted(motion.tool_times, time_s, side="right"))
    return motion.tools[max(taken - 1, 0)] if motion.tools else 0


def rows_by_tool(motion: JointMotion, rows: NDArray[np.intp]) -> list[tuple[int, NDArray[np.bool_]]]:
    """Tools in use at some moves, each with the (k,) rows of its own."""
    tools = np.array([tool_at(motion, float(time_s)) for time_s in motion.times[rows]], dtype=np.int64)
    return [(tool, tools == tool) for tool in np.unique(tools).tolist()]


def bodies_glb(bodies: Sequence[Body], tint: Tint, marked: Collection[str] = (), mark: Tint = (0, 0, 0)) -> bytes:
    """Bodies in the frame of their carrier, metres; those with marked names in another colour."""
    shapes = [placed_triangles(body) for body in bodies]
    corners = np.concatenate([np.empty((0, 3)), *(triangles.reshape(-1, 3) for triangles in shapes)])
    tints = np.array([mark if body.name in marked else tint for body in bodies], dtype=np.uint8).reshape(-1, 3)
    return triangles_glb(corners, np.repeat(tints, [3 * len(triangles) for triangles in shapes], axis=0))


def _waited(ends: Scalars, held: Scalars, times: Scalars) -> Scalars:
    return np.interp(times, ends, held) if len(ends) else np.zeros_like(times)


_MM = 1000.0
_LINE_MM, _END_MM = 0.8, 3.0
"""Widths of the line between two nearest points, and of the cubes at its ends."""


@dataclass(frozen=True, slots=True, eq=False)
class Near:
    """Two bodies close to each other at a time of the program."""

    time_s: float
    body: str
    """The moving one."""
    other: str
    distance_mm: float
    """0 where they overlap."""
    points: Points
    """(2, 3) nearest point of either, board frame, mm."""


def nearest_of(report: "CellReport", motion: JointMotion) -> Near | None:
    """Smallest clearance of robot and tool to workpiece and fixtures; nothing if all is far."""
    found = report.clearance
    touch = found.touches[found.nearest] if found.touches else None
    return touch and _near(report.cell, touch, float(motion.times[report.clearance_at[found.nearest]]))


def clearances_mm(
    cell: Cell, workpiece: Workpiece, motion: JointMotion, rows: NDArray[np.intp]
) -> tuple[Scalars, float]:
    """(k,) clearance of robot and tool to workpiece and fixtures at some moves, mm, and the largest that is measured.

    Args:
        cell: The cell.
        workpiece: The board or part in it.
        motion: Joints at each move.
        rows: (k,) indices of the moves.

    Raises:
        CellError: what ``washboard[robot]`` installs is missing.
    """
    from robotcell.collision.clearance import FARTHEST, clearance

    collider = _collider(cell, workpiece)
    distances = np.zeros(len(rows))
    for tool, mine in rows_by_tool(motion, rows):
        distances[mine] = clearance(collider, motion.joints[rows[mine]], tool).distances
    return distances * _MM, FARTHEST * _MM


def near_at(cell: Cell, workpiece: Workpiece, motion: JointMotion, time_s: float) -> Near | None:
    """Colliding pair at a time, or else the nearest; nothing if all is far.

    Raises:
        CellError: what ``washboard[robot]`` installs is missing.
    """
    from robotcell.collision.clearance import clearance
    from robotcell.collision.collision import first_pairs

    collider, joints, tool = _collider(cell, workpiece), joints_at(motion, np.array([time_s])), tool_at(motion, time_s)
    touch = first_pairs(collider, joints, tool)[0] or clearance(collider, joints, tool).touches[0]
    return None if touch is None else _near(cell, touch, time_s)


def near_glb(near: Near) -> bytes:
    """The line between the nearest points of two bodies, with a cube at either end, mm."""
    half = np.array([0.0, 0.0, _END_MM / 2])
    cubes = np.stack([near.points - half, near.points + half], axis=1)
    line, ends = bars(near.points[None], COLLIDING, _LINE_MM), bars(cubes, COLLIDING, _END_MM)
    return flat_triangles_glb(np.concatenate([line[0], ends[0]]), np.concatenate([line[1], ends[1]]))


@lru_cache(maxsize=2)
def _collider(cell: Cell, workpiece: Workpiece) -> "Collider":
    from robotcell.collision.collision import build_collider

    return build_collider(cell, workpiece)


def _near(cell: Cell, touch: "Touch", time_s: float) -> Near:
    onto = inverse(cell.T_cell_board)
    points = (touch.points @ onto[:3, :3].T + onto[:3, 3]) * _MM
    return Near(time_s, touch.body, touch.other, touch.distance * _MM, points)
