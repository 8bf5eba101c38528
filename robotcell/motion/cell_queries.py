"""Queries of the motion search to a cell: configurations, collisions, clearance, lifted joints."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from geometry.arrays import Indices, Scalars
from programs.program import Command, MoveTo, TimedProgram
from robotcell.cell.cell import Cell
from robotcell.collision.body_pairs import Touch
from robotcell.collision.clearance import Clearance, clearance
from robotcell.collision.collision import (
    Collider,
    build_collider,
    collides,
    fewest_obstacles,
    first_pairs,
    with_board_at,
)
from robotcell.collision.sweep import collides_between, touch_between
from robotcell.kinematics.inverse import solve
from robotcell.motion.joint_move import IsBlocked, Lifting, straight_way
from robotcell.motion.sampled_path import Flags, SampledPath, TrackedPath
from robotcell.robot.robot import Joints, Poses, inverse, is_beyond, nearest_turns

_LIFTS_M = np.array([0.02, 0.04, 0.07, 0.1, 0.15])
_MOST_LIFT_CHANGE = 0.6
"""rad or m that a joint may move for a step of lifting."""
_SAFE_ENOUGH_M = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class CellQueries:
    """A cell and a program, prepared for queries about joints."""

    cell: Cell
    program: TimedProgram
    colliders: tuple[Collider, ...]
    """By the placement of the board."""
    T_tcp_flange: Poses
    """(tools, 4, 4)"""

    def configurations(self, T_base_tcp: Poses, tool: int) -> tuple[Joints, Scalars]:
        """Give every configuration (n, b, dof) and by how much its azimuth (n, b) differs from the requested one."""
        found = solve(
            self.cell.robot, T_base_tcp @ self.T_tcp_flange[tool], T_flange_tcp=self.cell.tools[tool].T_flange_tcp
        )
        return found.q, found.azimuth

    def collide(self, q: Joints, tool: Indices, placement: Indices) -> Flags:
        """Give (k,) which joints (k, dof) collide."""
        hits = np.zeros(len(q), dtype=np.bool_)
        for at, carried, place in _groups(tool, placement):
            hits[at] = collides(self.colliders[place], q[at], self.cell.tools[carried].number)
        return hits

    def collide_between(self, q: Joints, tool: Indices, placement: Indices, intervals: Indices) -> Flags:
        """Give which of the intervals from row to row of joints (n, dof) collide on the way."""
        hits = np.zeros(len(intervals), dtype=np.bool_)
        for at, carried, place in _groups(tool[intervals], placement[intervals]):
            begin = intervals[at]
            number = self.cell.tools[carried].number
            hits[at] = collides_between(self.colliders[place], q[begin], q[begin + 1], number)
        return hits

    def first_pair(self, q: Joints, tool: int, placement: int) -> tuple[str, str] | None:
        """Name the first pair of bodies that collides at joints (dof,)."""
        touch = first_pairs(self.colliders[placement], q[None], self.cell.tools[tool].number)[0]
        return None if touch is None else (touch.body, touch.other)

    def pair_between(self, start: Joints, end: Joints, tool: int, placement: int) -> tuple[str, str] | None:
        """Name a pair of bodies that collides on the way between two rows of joints (dof,)."""
        touch = touch_between(self.colliders[placement], start, end, self.cell.tools[tool].number)
        return None if touch is None else (touch.body, touch.other)

    def obstacles(self, q: Joints, tool: int, placement: int) -> tuple[Touch, ...]:
        """Give what collides at that of joints (k, dof) which the fewest bodies keep from being clear."""
        return fewest_obstacles(self.colliders[placement], q, self.cell.tools[tool].number)

    def clearance(self, q: Joints, path: SampledPath, sample: Indices) -> Clearance:
        """Measure the clearance of joints (k, dof) at samples (k,) of a path."""
        distances = np.zeros(len(q))
        touches: list[Touch | None] = [None] * len(q)
        for at, carried, place in _groups(path.tool[sample], path.placement[sample]):
            found = clearance(self.colliders[place], q[at], self.cell.tools[carried].number)
            distances[at] = found.distances
            for row, touch in zip(at.tolist(), found.touches, strict=True):
                touches[row] = touch
        return Clearance(distances, tuple(touches))

    def lifting(self, tracked: TrackedPath, sample: int, safe_m: float = 0.0) -> Lifting:
        """Give how the tool may be lifted straight up from a sample, as far as the branch goes on.

        Args:
            tracked: The path.
            sample: Where it is lifted.
            safe_m: By how much it is lifted at least; in one piece.
        """
        up = np.linalg.inv(self.cell.T_cell_base)[:3, 2]
        tool, last = int(tracked.path.tool[sample]), tracked.q[sample]
        small = np.arange(_LIFTS_M[0], safe_m - 1e-9, _LIFTS_M[0])
        safe = [safe_m] if safe_m > 0.0 else []
        rows = [last]
        for lift in (*small, *safe, *(safe_m + _LIFTS_M)):
            pose = tracked.T_base_tcp[sample].copy()
            pose[:3, 3] += lift * up
            found = nearest_turns(self.cell.robot, self.configurations(pose[None], tool)[0][0], last)
            far = np.max(np.abs(found - last), axis=1)
            far = np.where(np.isfinite(far), far, np.inf)
            if far.min() > _MOST_LIFT_CHANGE:
                break
            last = found[int(np.argmin(far))]
            rows = [*rows, last] if lift > safe_m else [rows[0], last]
        return Lifting(np.stack(rows), min(1 + len(safe), len(rows)))

    def below_safe(self, path: SampledPath, sample: int) -> float:
        """Give by how much the orifice is lower at a sample than it ever is at that place of the board, m."""
        up = np.linalg.inv(self.cell.T_cell_base)[:3, 2]
        heights = path.T_base_tcp[path.placement == path.placement[sample], :3, 3] @ up
        below = float(heights.max() - path.T_base_tcp[sample, :3, 3] @ up)
        return below if below > _SAFE_ENOUGH_M else 0.0

    def blocked_at(self, placement: int) -> IsBlocked:
        """Give the check whether joint moves collide or leave the travel, with the board at one of its placements."""

        def is_blocked(begin: Joints, end: Joints, tool: int) -> Flags:
            ways = [straight_way(self.cell.tool_point, *ends) for ends in zip(begin, end, strict=True)]
            before, after = (np.concatenate([way[part] for way in ways]) for part in (slice(-1), slice(1, None)))
            hits = collides_between(self.colliders[placement], before, after, self.cell.tools[tool].number)
            hits |= is_beyond(self.cell.robot, after)
            return np.array([part.any() for part in np.split(hits, np.cumsum([len(way) - 1 for way in ways])[:-1])])

        return is_blocked

    def blocked_on_change(self, path: SampledPath, begin: int, end: int) -> IsBlocked:
        """Give the check of a joint move between two samples: with its tool each has its placement of the board."""
        places = {int(path.tool[at]): int(path.placement[at]) for at in (begin, end)}

        def is_blocked(before: Joints, after: Joints, tool: int) -> Flags:
            return self.blocked_at(places[tool])(before, after, tool)

        return is_blocked

    def repeats(self, path: SampledPath) -> list[tuple[int, int]]:
        """Give the samples at which each repeated part of the program begins and ends."""
        opened: list[int] = []
        found: list[tuple[int, int]] = []
        left = False  # whether the tool was changed, or the board turned, since the last move
        for index, item in enumerate(self.program.instructions):
            left &= not isinstance(item, MoveTo)
            left |= isinstance(item, Command) and item.keyword in ("NOZZLE", "CALL")
            if isinstance(item, Command) and item.keyword in ("REPEAT", "ENDREPEAT"):
                following = int(np.searchsorted(path.instruction, index))
                at = max(following - 1, 0)
                if item.keyword == "REPEAT":
                    arrives = left and following < len(path.changed) and bool(path.changed[following])
                    at = following if arrives else at
                    opened.append(at)
                elif opened:
                    found.append((opened.pop(), at))
        return found


def build_queries(program: TimedProgram, cell: Cell, board: Workpiece | None, placements: list[Poses]) -> CellQueries:
    """Prepare a cell for queries.

    Args:
        program: The program to be carried out.
        cell: The cell.
        board: The board, for collisions; without one only the cell itself is checked.
        placements: T_cell_board (4, 4) of every placement, the cell's own first.

    Raises:
        CellError: Coal is not installed, or no closed form is known for the robot.
    """
    first = build_collider(cell, board)
    colliders = (first, *(with_board_at(first, T_cell_board) for T_cell_board in placements[1:]))
    return CellQueries(cell, program, colliders, np.stack([inverse(tool.T_flange_tcp) for tool in cell.tools]))


def _groups(tool: Indices, placement: Indices) -> list[tuple[NDArray[np.int64], int, int]]:
    """Rows that have the same tool and the same placement of the board."""
    return [
        (np.flatnonzero((tool == carried) & (placement == place)), int(carried), int(place))
        for carried in np.unique(tool).tolist()
        for place in np.unique(placement[tool == carried]).tolist()
    ]
