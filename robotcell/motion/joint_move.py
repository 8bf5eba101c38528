"""Joint moves with the jet off: to another configuration, another tool, home. Metres, radians."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from geometry.arrays import Scalars
from programs.motion.installation import ToolPointMachine
from robotcell.cell.cell import Cell
from robotcell.motion.sampled_path import Flags
from robotcell.robot.robot import Joints, Robot, nearest_turns

SHARE = 0.5
"""Share of the joints' greatest speeds and accelerations that such moves take."""
_SAMPLE_S = 0.04
_CARRIAGE, _FAR_TURN = 3, np.radians(10.0)
"""Joints of a gantry before those that turn, and rad from which on it tilts and turns the tool one after the other."""
_PART_RAD = np.radians(3.0)
"""Turn of the tool within which the carriage's way counts as straight: 180 mm from its axis that is 0.06 mm off."""
_TILTED_RAD = 1e-9
_CURVED_SHARE = 0.5
"""Of the accelerations along a way on which joints do not go evenly; the other half is for its bends."""
_MACHINE_UNITS = np.array([1e3, 1e3, 1e3, 1.0, 1.0])

IsBlocked: TypeAlias = Callable[[Joints, Joints, int], Flags]
"""Takes (k, dof) joints before and after and the tool's index; gives (k,) whether the way between collides."""


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


def find_move(
    cell: Cell, begin: Lifting, end: Lifting, tools: tuple[int, int], is_blocked: IsBlocked
) -> tuple[Joints, int] | None:
    """Find a joint move that collides with nothing: straight, lifted, or via home; another tool by way of its place.

    Args:
        cell: Whose home, and whose place for a change of the tool.
        begin: Where it begins.
        end: Where it ends.
        tools: Index of the tool before and after.
        is_blocked: Checks straight ways for collisions.

    Returns:
        Rows (k, dof) and the one at which the tool is changed; ``None`` where every way collides.
    """
    before, after = tools
    changes = before != after
    ways = _by_way_of(cell, cell.change_place, begin, end) if changes else _direct(cell, begin, end)
    for way, change in ways:
        carried = ((before if changes and at < change else after) for at in range(len(way) - 1))
        legs = (is_blocked(way[at : at + 1], way[at + 1 : at + 2], tool)[0] for at, tool in enumerate(carried))
        if not any(legs):
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
    axes, tilt = machine.axes(np.stack((begin, end)) * _MACHINE_UNITS), 7 - machine.swing
    axes = axes if abs(axes[0, tilt]) > abs(axes[1, tilt]) else axes[::-1]
    axes[0, tilt] = axes[1, tilt]
    return machine.joints(axes[:1]) / _MACHINE_UNITS


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
    axes = machine.axes(rows * _MACHINE_UNITS)
    if np.abs(axes[:, 7 - machine.swing]).max() < _TILTED_RAD:
        return rows
    parts = max(int(np.ceil(np.abs(end - begin)[_CARRIAGE:].max() / _PART_RAD)), 1)
    shares = np.linspace(0.0, 1.0, parts + 1)[1:-1, None]
    between = machine.joints(axes[0] + shares * (axes[1] - axes[0])) / _MACHINE_UNITS
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
