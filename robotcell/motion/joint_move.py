"""Joint moves with the jet off: to another configuration, another tool, home. Metres, radians."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from geometry.arrays import Scalars
from robotcell.cell.cell import Cell
from robotcell.motion.sampled_path import Flags
from robotcell.robot.robot import Joints, Robot

SHARE = 0.5
"""Share of the joints' greatest speeds and accelerations that such moves take."""
_SAMPLE_S = 0.04

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


def find_move(cell: Cell, begin: Joints, end: Joints, tools: tuple[int, int], is_blocked: IsBlocked) -> Joints | None:
    """Find the way (k, dof) of a joint move that collides with nothing: straight, lifted, or via home; else ``None``.

    Args:
        cell: Whose home.
        begin: (k, dof) where it begins, and how it may be lifted from there.
        end: (k, dof) where it ends, and how it may be lifted from there.
        tools: Index of the tool before and after: it is changed at the beginning, or at home if the way leads there.
        is_blocked: Checks straight ways for collisions.
    """
    for way, carried in _ways(cell, begin, end, tools):
        legs = (is_blocked(way[at : at + 1], way[at + 1 : at + 2], tool)[0] for at, tool in enumerate(carried))
        if not any(legs):
            return way
    return None


def _ways(cell: Cell, begin: Joints, end: Joints, tools: tuple[int, int]) -> list[tuple[Joints, list[int]]]:
    """Ways (k, dof) with the tool on each leg, the simplest first."""
    home = cell.home[None]
    before, after = tools
    down = end[::-1]
    ways = [(np.concatenate((begin[:1], end[:1])), [after])]
    for lift in range(2, max(len(begin), len(end)) + 1):
        way = np.concatenate((begin[:lift], down[-lift:]))
        ways.append((way, [after] * (len(way) - 1)))
    for lift in (1, len(begin)):
        up, back = begin[:lift], down[-lift:]
        over, under = home.copy(), home.copy()
        over[0, 0], under[0, 0] = up[-1, 0], back[0, 0]
        for middle in ((home, home), (np.concatenate((up[-1:], over, home)), np.concatenate((home, under, back[:1])))):
            out, come = np.concatenate((up, middle[0])), np.concatenate((middle[1], back))
            way = np.concatenate((out, come))
            ways.append((way, [before] * (len(out) - 1) + [after] * len(come)))
    return ways


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
