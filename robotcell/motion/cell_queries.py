"""What the search for a motion asks of a cell: postures, collisions, ways."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from geometry.arrays import Indices, Scalars
from programs.program import Command, TimedProgram
from robotcell.cell.cell import Cell
from robotcell.collision.clearance import Clearance, clearance
from robotcell.collision.collision import Collider, build_collider, collides, first_pairs, with_board_at
from robotcell.collision.contacts import Touch
from robotcell.collision.sweep import collides_between
from robotcell.kinematics.inverse import solve
from robotcell.motion.joint_move import Blocked
from robotcell.motion.sampled_path import Course, Flags
from robotcell.robot.full_turns import unwound
from robotcell.robot.poses import inverse
from robotcell.robot.robot import Joints, Poses

_LIFTS_M = np.array([0.02, 0.04, 0.07, 0.1, 0.15])
_SMALL = 0.6
"""rad or m: what a joint may go for a step of lifting."""


@dataclass(frozen=True, slots=True, eq=False)
class Questions:
    """A cell that can be asked about joints."""

    cell: Cell
    program: TimedProgram
    colliders: tuple[Collider, ...]
    """By the placement of the board."""
    T_tcp_flange: Poses
    """(tools, 4, 4)"""

    def postures(self, T_base_tcp: Poses, tool: int) -> tuple[Joints, Scalars]:
        """Give every configuration (n, b, dof) and by how much its azimuth (n, b) differs from the asked one."""
        found = solve(
            self.cell.robot, T_base_tcp @ self.T_tcp_flange[tool], T_flange_tcp=self.cell.tools[tool].T_flange_tcp
        )
        return found.q, found.azimuth

    def touches(self, q: Joints, tool: Indices, placement: Indices) -> Flags:
        """Say (k,) which joints (k, dof) collide."""
        hits = np.zeros(len(q), dtype=np.bool_)
        for at, carried, place in _groups(tool, placement):
            hits[at] = collides(self.colliders[place], q[at], self.cell.tools[carried].number)
        return hits

    def swept(self, q: Joints, tool: Indices, placement: Indices, intervals: Indices) -> Flags:
        """Say which of the intervals from row to row of joints (n, dof) collide on the way."""
        hits = np.zeros(len(intervals), dtype=np.bool_)
        for at, carried, place in _groups(tool[intervals], placement[intervals]):
            begin = intervals[at]
            number = self.cell.tools[carried].number
            hits[at] = collides_between(self.colliders[place], q[begin], q[begin + 1], number)
        return hits

    def pair(self, q: Joints, tool: int, placement: int) -> tuple[str, str] | None:
        """Name the first pair of bodies that collides at joints (dof,)."""
        touch = first_pairs(self.colliders[placement], q[None], self.cell.tools[tool].number)[0]
        return None if touch is None else (touch.body, touch.other)

    def nearest(self, q: Joints, course: Course, sample: Indices) -> Clearance:
        """Measure the clearance of joints (k, dof) at samples (k,) of a course."""
        distances = np.zeros(len(q))
        touches: list[Touch | None] = [None] * len(q)
        for at, carried, place in _groups(course.tool[sample], course.placement[sample]):
            found = clearance(self.colliders[place], q[at], self.cell.tools[carried].number)
            distances[at] = found.distances
            for row, touch in zip(at.tolist(), found.touches, strict=True):
                touches[row] = touch
        return Clearance(distances, tuple(touches))

    def raised(self, q: Joints, T_base_tcp: Poses, tool: int) -> Joints:
        """Give joints (k, dof) that lift the tool step by step from where it is, as far as the robot goes on."""
        up = np.linalg.inv(self.cell.T_cell_base)[:3, 2]
        lifted = np.repeat(T_base_tcp[None], len(_LIFTS_M), axis=0)
        lifted[:, :3, 3] += _LIFTS_M[:, None] * up
        rows = [q]
        for pose in lifted:
            found = unwound(self.cell.robot, self.postures(pose[None], tool)[0][0], rows[-1])
            far = np.max(np.abs(found - rows[-1]), axis=1)
            far = np.where(np.isfinite(far), far, np.inf)
            if far.min() > _SMALL:
                break
            rows.append(found[int(np.argmin(far))])
        return np.stack(rows)

    def blocked(self, placement: int) -> Blocked:
        """Give the question whether straight ways collide, with the board at one of its placements."""

        def ask(begin: Joints, end: Joints, tool: int) -> Flags:
            return collides_between(self.colliders[placement], begin, end, self.cell.tools[tool].number)

        return ask

    def loops(self, course: Course) -> list[tuple[int, int]]:
        """Give the samples at which each repeated part of the program begins and ends."""
        opened: list[int] = []
        found: list[tuple[int, int]] = []
        for index, item in enumerate(self.program.instructions):
            if isinstance(item, Command) and item.keyword in ("REPEAT", "ENDREPEAT"):
                at = max(int(np.searchsorted(course.instruction, index)) - 1, 0)
                if item.keyword == "REPEAT":
                    opened.append(at)
                elif opened:
                    found.append((opened.pop(), at))
        return found


def ask_of(program: TimedProgram, cell: Cell, board: Board | None, placements: list[Poses]) -> Questions:
    """Prepare a cell for questions.

    Args:
        program: What is to be done.
        cell: The cell.
        board: The board, for collisions; without one only the cell itself is looked at.
        placements: T_cell_board (4, 4) of every placement, the cell's own first.

    Raises:
        CellError: Coal is not installed, or no closed form is known for the robot.
    """
    first = build_collider(cell, board)
    colliders = (first, *(with_board_at(first, T_cell_board) for T_cell_board in placements[1:]))
    T_tcp_flange = np.stack([inverse(tool.T_flange_tcp) for tool in cell.tools])
    return Questions(cell, program, colliders, T_tcp_flange)


def _groups(tool: Indices, placement: Indices) -> list[tuple[NDArray[np.int64], int, int]]:
    """Rows that have the same tool and the same placement of the board."""
    return [
        (np.flatnonzero((tool == carried) & (placement == place)), int(carried), int(place))
        for carried in np.unique(tool).tolist()
        for place in np.unique(placement[tool == carried]).tolist()
    ]
