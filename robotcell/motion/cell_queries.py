"""Queries of the motion search to a cell: configurations, collisions, clearance; joint moves with the jet off.

Joint moves lead to another configuration, another tool, home. Metres, radians.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from boards.board import Workpiece
from geometry.arrays import Indices, Scalars
from programs.motion.installation import ToolPointMachine
from programs.program import Command, MoveTo, TimedProgram
from robotcell.cell.cell import MACHINE_UNITS, Cell
from robotcell.collision.body_pairs import Touch
from robotcell.collision.clearance import NEAREST_DIGITS, Clearance, clearance
from robotcell.collision.collision import (
    Collider,
    build_collider,
    collides,
    collides_between,
    fewest_obstacles,
    first_pairs,
    touch_between,
    with_board_at,
)
from robotcell.kinematics.inverse import solve
from robotcell.motion.sampled_path import Flags, SampledPath, TrackedPath
from robotcell.robot.robot import Joints, Poses, Robot, inverse, is_beyond, nearest_turns, row_pieces, rows_by

_LIFTS_M = np.array([0.02, 0.04, 0.07, 0.1, 0.15])
_MOST_LIFT_CHANGE = 0.6
"""rad or m that a joint may move for a step of lifting."""
_SAFE_ENOUGH_M = 1e-4
SHARE = 0.5
"""Share of the joints' greatest speeds and accelerations that such moves take."""
_SAMPLE_S = 0.04
_MEASURED_AT_ONCE = 5_000
"""Rows whose touches are kept until the nearest of them is known."""
_CARRIAGE, _FAR_TURN = 3, np.radians(10.0)
"""Joints of a gantry before those that turn, and rad from which on it tilts and turns the tool one after the other."""
_PART_RAD = np.radians(3.0)
"""Turn of the tool within which the carriage's way counts as straight: 180 mm from its axis that is 0.06 mm off."""
_TILTED_RAD = 1e-9
_CURVED_SHARE = 0.5
"""Of the accelerations along a way on which joints do not go evenly; the other half is for its bends."""


@dataclass(frozen=True, slots=True, eq=False)
class Reconfiguration:
    """A joint move in place of a piece of the path."""

    begin: int
    """Sample before it,"""
    end: int
    """and after it."""
    way: Joints
    """(k, dof) rows of joints, straight from one to the next, at rest at each; k >= 2"""
    change: int = 0
    """Row at which the tool is changed; 0 also where it is not."""

    @property
    def parts(self) -> list[Joints]:
        """The way, divided where the tool is changed."""
        return [self.way[: self.change + 1], self.way[self.change :]] if self.change else [self.way]


@dataclass(frozen=True, slots=True, eq=False)
class Lifting:
    """Where a joint move begins or ends, and how the tool may be lifted from there."""

    rows: Joints
    """(k, dof) the joints there, then lifted step by step."""
    least: int = 1
    """How many of them a way has at least: up to the safe height."""

    def up_to(self, count: int) -> Joints:
        """Give the first rows, at least as many as it takes."""
        return self.rows[: max(count, self.least)]


@dataclass(frozen=True, slots=True, eq=False)
class HomeMoves:
    """Joint moves from home to where a path begins, and from its end home."""

    out: Joints
    """(k, dof) rows of joints, as those of a reconfiguration; one row where no way is clear."""
    back: Joints
    """(k, dof) likewise."""


Way: TypeAlias = tuple[Joints, int]
"""Rows (k, dof), and the one at which the tool is changed."""


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

    def first_touch(self, q: Joints, tool: int, placement: int) -> Touch | None:
        """Give the first pair of bodies that collides at joints (dof,)."""
        return first_pairs(self.colliders[placement], q[None], self.cell.tools[tool].number)[0]

    def touch_between(self, start: Joints, end: Joints, tool: int, placement: int) -> Touch | None:
        """Give a pair of bodies that collides on the way between two rows of joints (dof,)."""
        return touch_between(self.colliders[placement], start, end, self.cell.tools[tool].number)

    def obstacles(self, q: Joints, tool: int, placement: int) -> tuple[Touch, ...]:
        """Give what collides at that of joints (k, dof) which the fewest bodies keep from being clear."""
        return fewest_obstacles(self.colliders[placement], q, self.cell.tools[tool].number)

    def clearance(self, q: Joints, tool: Indices, placement: Indices) -> Clearance:
        """Measure the clearance of joints (k, dof) with tools and placements (k,); the nearest also has the touch."""
        distances, least = np.zeros(len(q)), list[tuple[float, int, Touch | None]]()
        for at, carried, place in _groups(tool, placement):
            for some in (at[piece] for piece in row_pieces(len(at), _MEASURED_AT_ONCE)):
                found = clearance(self.colliders[place], q[some], self.cell.tools[carried].number)
                row, distances[some] = found.nearest, found.distances
                least.append((round(float(found.distances[row]), NEAREST_DIGITS), int(some[row]), found.touches[row]))
        touches: list[Touch | None] = [None] * len(q)
        for _, row, touch in sorted(least, key=lambda each: each[:2])[:1]:
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

    def is_blocked(self, begin: Joints, end: Joints, tool: int, placement: int) -> bool:
        """Whether a joint move from (dof,) to (dof,) collides or leaves the travel."""
        way = straight_way(self.cell.tool_point, begin, end)
        hits = collides_between(self.colliders[placement], way[:-1], way[1:], self.cell.tools[tool].number)
        return bool((hits | is_beyond(self.cell.robot, way[1:])).any())

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


def _groups(tool: Indices, placement: Indices) -> Iterator[tuple[Indices, int, int]]:
    """Rows that have the same tool and the same placement of the board."""
    for carried, rows in rows_by(tool):
        for place, some in rows_by(placement[rows]):
            yield rows[some], carried, place


def find_move(
    queries: CellQueries, begin: Lifting, end: Lifting, before: tuple[int, int], after: tuple[int, int]
) -> Way | None:
    """Find a joint move that collides with nothing: straight, lifted, or via home; another tool by way of its place.

    Args:
        queries: To the cell.
        begin: Where it begins.
        end: Where it ends.
        before: Index of the tool, and of the board's placement, until the tool is changed.
        after: The same from then on, and where it is not changed.

    Returns:
        ``None`` where every way collides.
    """
    cell, changes = queries.cell, before[0] != after[0]
    for way, change in _by_way_of(cell, cell.change_place, begin, end) if changes else _direct(cell, begin, end):
        legs = enumerate(pairwise(way))
        if not any(queries.is_blocked(*leg, *(before if changes and at < change else after)) for at, leg in legs):
            return way, change
    return None


def _direct(cell: Cell, begin: Lifting, end: Lifting) -> Iterator[Way]:
    """Give ways straight from begin to end, the simplest first, then by way of home."""
    seen = set[int]()
    for lift in range(1, max(len(begin.rows), len(end.rows)) + 1):
        up, back = begin.up_to(lift), end.up_to(lift)[::-1]
        if len(up) + len(back) not in seen:
            seen.add(len(up) + len(back))
            if len(corner := _tilting_apart(cell, up[-1], back[0])):
                yield np.concatenate((up, corner, back)), 0
            yield np.concatenate((up, back)), 0
    for way, _ in _by_way_of(cell, cell.home, begin, end):
        yield way, 0


def _tilting_apart(cell: Cell, begin: Joints, end: Joints) -> Joints:
    """Give the row (1, 5) at which a gantry has tilted its tool but not turned it; no row where it does only one.

    While both turning axes go, the carriage would circle with the tool's tilt as fast as that turns. The tool tilts
    where it leans farther, about its orifice, so that it turns nearly upright.
    """
    machine = cell.tool_point
    if machine is None or np.abs(end - begin)[_CARRIAGE:].min() < _FAR_TURN:
        return np.empty((0, cell.robot.dof))
    axes, tilt = machine.axes(np.stack((begin, end)) * MACHINE_UNITS), 7 - machine.swing
    axes = axes if abs(axes[0, tilt]) > abs(axes[1, tilt]) else axes[::-1]
    axes[0, tilt] = axes[1, tilt]
    return machine.joints(axes[:1]) / MACHINE_UNITS


def straight_way(machine: ToolPointMachine | None, begin: Joints, end: Joints) -> Joints:
    """Give the way between two rows (dof,) at which a joint move rests, as the controller goes.

    Args:
        machine: Where the controller takes tool points; ``None`` where each joint goes evenly.
        begin: Metres, radians.
        end: Likewise.

    Returns:
        (k, dof) rows between which each joint goes evenly; with a tool that leans the carriage of a tool point that
        goes straight does not.
    """
    rows = np.stack((begin, end))
    if machine is None:
        return rows
    axes = machine.axes(rows * MACHINE_UNITS)
    if np.abs(axes[:, 7 - machine.swing]).max() < _TILTED_RAD:
        return rows
    parts = max(int(np.ceil(np.abs(end - begin)[_CARRIAGE:].max() / _PART_RAD)), 1)
    shares = np.linspace(0.0, 1.0, parts + 1)[1:-1, None]
    between = machine.joints(axes[0] + shares * (axes[1] - axes[0])) / MACHINE_UNITS
    return np.concatenate((rows[:1], between, rows[1:]))


def _by_way_of(cell: Cell, place: Joints, begin: Lifting, end: Lifting) -> Iterator[Way]:
    """Give ways by a place (dof,), at which the tool is changed: straight, or with the first joint last and first.

    Joints of several turns come to the place without unwinding.
    """
    nearest = nearest_turns(cell.robot, place[None], begin.rows[:1])
    place = np.where(np.isfinite(nearest), nearest, place)
    for lift in dict.fromkeys((1, max(len(begin.rows), len(end.rows)))):
        up, back = begin.up_to(lift), end.up_to(lift)[::-1]
        up = np.concatenate((up, _tilting_apart(cell, up[-1], place[0])))
        back = np.concatenate((_tilting_apart(cell, place[0], back[0]), back))
        over, under = place.copy(), place.copy()
        over[0, 0], under[0, 0] = up[-1, 0], back[0, 0]
        yield np.concatenate((up, place, back)), len(up)
        yield np.concatenate((up, over, place, under, back)), len(up) + 1


def time_move(robot: Robot, way: Joints, machine: ToolPointMachine | None = None) -> tuple[Scalars, Joints]:
    """Sample a joint move: times (k,) from 0 and joints (k, dof), with trapezoids of speed from rest to rest.

    Args:
        robot: Whose limits count.
        way: (n, dof) rows at which it rests.
        machine: Where the controller takes tool points.
    """
    times, rows, clock = [np.zeros(1)], [way[:1]], 0.0
    for begin, end in pairwise(way):
        far = np.abs(end - begin)
        if far.max() < 1e-9:
            continue
        between = straight_way(machine, begin, end)
        speed, push = _limits_along(robot, between)
        ramp = min(speed / push, float(np.sqrt(1.0 / push)))
        top = ramp * push
        cruise = max(0.0, 1.0 / top - ramp)
        total = 2.0 * ramp + cruise
        at = np.linspace(0.0, total, max(4, int(np.ceil(total / _SAMPLE_S)) + 1))
        at = np.unique(np.round(np.concatenate((at, np.array([ramp, ramp + cruise]))), 12)).astype(np.float64)
        up, down = np.minimum(at, ramp), np.maximum(at - ramp - cruise, 0.0)
        share = 0.5 * push * up**2 + top * np.clip(at - ramp, 0.0, cruise) + top * down - 0.5 * push * down**2
        share = np.clip(share, 0.0, 1.0)
        times.append(clock + at[1:])
        done = np.linspace(0.0, 1.0, len(between))
        rows.append(np.column_stack([np.interp(share[1:], done, column) for column in between.T]))
        clock += float(at[-1])
    return np.concatenate(times), np.concatenate(rows)


def _limits_along(robot: Robot, way: Joints) -> tuple[float, float]:
    """Greatest rate and acceleration of the share of a way (k, dof) that is done, rows at equal shares."""
    parts = len(way) - 1
    rates = np.diff(way, axis=0) * parts
    fastest, bends = np.abs(rates).max(axis=0), np.abs(np.diff(rates, axis=0)).max(axis=0, initial=0.0) * parts
    limits = zip(robot.joints, fastest.tolist(), bends.tolist(), strict=True)
    spans = [(joint, span, bend) for joint, span, bend in limits if span > 0.0]
    speed = min(SHARE * joint.speed / span for joint, span, _ in spans)
    push = min(SHARE * joint.acceleration / span for joint, span, _ in spans)
    for joint, _, bend in spans if parts > 1 else ():
        room = (1.0 - _CURVED_SHARE) * SHARE * joint.acceleration
        speed = min(speed, float(np.sqrt(room / bend))) if bend > 0.0 else speed
    return speed, push * (_CURVED_SHARE if parts > 1 else 1.0)
