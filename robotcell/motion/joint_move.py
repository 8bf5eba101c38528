"""Joint moves with the jet off: to another configuration, another tool, home. Metres, radians."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from geometry.arrays import Scalars
from robotcell.cell.cell import Cell
from robotcell.kinematics.inverse import gantry_of
from robotcell.motion.sampled_path import Flags
from robotcell.robot.full_turns import nearest_turns
from robotcell.robot.robot import Joints, Robot

SHARE = 0.5
"""Share of the joints' greatest speeds and accelerations that such moves take."""
_SAMPLE_S = 0.04
_CARRIAGE, _FAR_TURN = 3, np.radians(10.0)
"""Joints of a gantry before those that turn, and rad from which on it tilts and turns the tool one after the other."""

IsBlocked: TypeAlias = Callable[[Joints, Joints, int], Flags]
"""Takes (k, dof) joints before and after and the tool's index; gives (k,) whether the straight way between collides."""


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
    ways = _by_way_of(cell.robot, cell.change_place, begin, end) if changes else _direct(cell, begin, end)
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
            if len(corner := _tilting_apart(cell.robot, up[-1], back[0])):
                yield np.concatenate((up, corner, back)), 0
            yield np.concatenate((up, back)), 0
    for way, _ in _by_way_of(cell.robot, cell.home, begin, end):
        yield way, 0


def _tilting_apart(robot: Robot, begin: Joints, end: Joints) -> Joints:
    """Give the row (1, 5) at which a gantry has tilted its tool but not turned it; no row where it does only one.

    While both turning axes go, the tool point winds about the first: a controller in tool points takes many blocks for
    that. It tilts where the tool leans farther, so that it turns nearly upright.
    """
    if gantry_of(robot) is None or np.abs(end - begin)[_CARRIAGE:].min() < _FAR_TURN:
        return np.empty((0, robot.dof))
    begins = abs(begin[-1]) > abs(end[-1])
    row = (begin if begins else end).copy()
    row[-1] = (end if begins else begin)[-1]
    return row[None]


def _by_way_of(robot: Robot, place: Joints, begin: Lifting, end: Lifting) -> Iterator[Way]:
    """Give ways by a place (dof,), at which the tool is changed: straight, or with the first joint last and first.

    Joints of several turns come to the place without unwinding.
    """
    wound = nearest_turns(robot, place[None], begin.rows[:1])
    place = np.where(np.isfinite(wound), wound, place)
    for lift in dict.fromkeys((1, max(len(begin.rows), len(end.rows)))):
        up, back = begin.up_to(lift), end.up_to(lift)[::-1]
        over, under = place.copy(), place.copy()
        over[0, 0], under[0, 0] = up[-1, 0], back[0, 0]
        yield np.concatenate((up, place, back)), len(up)
        yield np.concatenate((up, over, place, under, back)), len(up) + 1


def time_move(robot: Robot, way: Joints) -> tuple[Scalars, Joints]:
    """Sample a joint move: times (k,) from 0 and joints (k, dof), with trapezoids of speed from rest to rest."""
    times, rows, clock = [np.zeros(1)], [way[:1]], 0.0
    for begin, end in pairwise(way):
        far = np.abs(end - begin)
        if far.max() < 1e-9:
            continue
        spans = [(joint, span) for joint, span in zip(robot.joints, far.tolist(), strict=True) if span > 0]
        speed = min(SHARE * joint.speed / span for joint, span in spans)
        push = min(SHARE * joint.acceleration / span for joint, span in spans)
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
        rows.append(begin + share[1:, None] * (end - begin))
        clock += float(at[-1])
    return np.concatenate(times), np.concatenate(rows)
