"""Ladder-graph search over IK branches: the cheapest configurations along a path by dynamic programming, compiled.

Viterbi, "Error bounds for convolutional codes and an asymptotically optimum decoding algorithm" (1967).
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from geometry.compiled import compiled, inner
from robotcell.robot.robot import Joints

RECONFIGURE_COST_S = 3.0
"""Cost of a reconfiguration move on top of its own time."""
UNWIND_COST_S = 30.0
"""Cost on top of that for five axes, whose joint moves wind the hose back: several turns over the vertical instead."""
DISCONTINUITY_COST_S = 1e5
"""Cost of a change of configuration where the path does not allow any."""
_LATE_WEIGHT = 4.0
"""Weight of each second by which the joints are slower than the program."""
_SPEED_SHARE = 0.8
"""Share of a joint's greatest speed above which it counts as late."""
_LEAST_LASTING_S = 0.02
_CLEARLY = 1e-6
_TIE = 1e-9
"""s: costs that differ by less are equal; the first is taken."""
FOLLOW, MAY_RECONFIGURE, MUST_RECONFIGURE = 0, 1, 2
"""Kinds of interval between two rungs: the path is followed; the configuration may change; it has to."""


class Ladder(NamedTuple):
    """The configurations at each of n nodes: m states, rung after rung."""

    first: Indices
    """(n + 1,) where each rung begins."""
    q: Joints
    """(m, dof)"""
    azimuth: Scalars
    """(m,) rad about the jet, from the programmed azimuth."""
    tilt: NDArray[np.float64]
    """(m, 2) rad about the tool's own x and y, from the programmed direction."""
    cost: Scalars
    """(m,) s"""
    node: Indices = np.empty(0, dtype=np.int64)
    """(m,) the rung that each belongs to."""
    label: Indices = np.empty(0, dtype=np.int64)
    """(m,) the same for states of different nodes with the same azimuth, tilt and branch."""


class Steps(NamedTuple):
    """The n - 1 intervals between rungs."""

    lasting: Scalars
    """(n - 1,) s"""
    kind: Indices
    """(n - 1,) FOLLOW, MAY_RECONFIGURE or MUST_RECONFIGURE"""
    slack: Scalars
    """(n - 1,) rad that a joint may turn while the path is followed."""
    window: Scalars
    """(n - 1,) rad that the tool may turn about its jet."""
    turning: Scalars
    """(n - 1,) rad that a joint may turn more for each radian that the tool turns about its jet."""
    azimuth_cost: Scalars
    """(n - 1,) s for each radian about the jet."""


class JointSpeeds(NamedTuple):
    """Greatest speeds of the joints, and which of them turn."""

    seconds: Scalars
    """(dof,) s for a radian or a metre at the greatest speed."""
    wraps: NDArray[np.bool_]
    """(dof,) whether a joint may go on past a whole turn."""
    turns: NDArray[np.bool_]
    """(dof,) whether it is revolute."""


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """One state of each rung."""

    state: Indices
    """(n,)"""
    reconfigurations: NDArray[np.bool_]
    """(n - 1,) whether the configuration changes between two nodes."""
    discontinuities: NDArray[np.bool_]
    """(n - 1,) whether it changes where the path does not allow it."""


def cheapest(ladder: Ladder, steps: Steps, speeds: JointSpeeds, forbidden: NDArray[np.int64]) -> Choice:
    """Choose a state of each rung so that states and steps together cost least; the first of equals.

    Args:
        ladder: At least one state on each rung.
        steps: Between them.
        speeds: Of the joints.
        forbidden: (k, 2) pairs of states that must not follow each other.
    """
    order = np.argsort(forbidden[:, 1], kind="stable")
    table = np.column_stack((ladder.q, ladder.azimuth, np.linalg.norm(ladder.tilt, axis=1)))
    between, able = (np.stack([np.asarray(row, dtype=np.float64) for row in rows], axis=1) for rows in (steps, speeds))
    best, previous = _sweep(ladder.first, table, ladder.cost, between, able, forbidden[order])
    state = np.empty(len(ladder.first) - 1, dtype=np.int64)
    begin = ladder.first[-2]
    state[-1] = begin + int(np.argmin(np.round(best[begin:], 9)))
    for node in range(len(state) - 1, 0, -1):
        state[node - 1] = previous[state[node]]
    change = np.diff(ladder.q[state], axis=0)
    change = np.abs(np.where(speeds.wraps, change - 2.0 * np.pi * np.round(change / (2.0 * np.pi)), change))
    turn = np.diff(ladder.azimuth[state])
    turn = np.abs(turn - 2.0 * np.pi * np.round(turn / (2.0 * np.pi)))
    widest = np.max(change, axis=1, where=speeds.turns, initial=0.0)
    leaves = (widest > steps.slack + steps.turning * turn + 1e-9) | (turn > steps.window + 1e-9)
    return Choice(state, leaves | (steps.kind == MUST_RECONFIGURE), leaves & (steps.kind == FOLLOW))


@compiled
def _sweep(
    first: Indices,
    table: NDArray[np.float64],
    cost: Scalars,
    steps: NDArray[np.float64],
    speeds: NDArray[np.float64],
    forbidden: NDArray[np.int64],
) -> tuple[Scalars, Indices]:
    """Give the least cost (m,) of reaching each state, and the state before it."""
    best = cost.copy()
    previous = np.full(len(best), -1, dtype=np.int64)
    for node in range(len(steps)):
        low, high = first[node], first[node + 1]
        nearest = likely = low
        for before in range(low, high):
            if best[before] < best[nearest] - _TIE:
                nearest = before
        for state in range(high, first[node + 2]):
            least, source = best[nearest] + DISCONTINUITY_COST_S, nearest
            # What follows the source of the last state, or its neighbour, is mostly near the cheapest: what costs more
            # need not be looked at. Which of equals is taken does not depend on it.
            bound = least
            for before in range(likely, min(likely + 2, high)):
                step = best[before] + _step_cost(table, (before, state), steps, node, speeds, bound - best[before])
                if step < bound and not _is_forbidden(forbidden, before, state):
                    bound = step
            bound += _CLEARLY
            for before in range(low, high):
                room = min(least - _TIE, bound) - best[before]
                if room <= 0.0:
                    continue
                step = best[before] + _step_cost(table, (before, state), steps, node, speeds, room)
                if step < least - _TIE and not _is_forbidden(forbidden, before, state):
                    least, source = step, before
            likely = source
            best[state] += least
            previous[state] = source
    return best, previous


@inner
def _step_cost(
    table: NDArray[np.float64],
    pair: tuple[int, int],
    steps: NDArray[np.float64],
    node: int,
    speeds: NDArray[np.float64],
    room: float,
) -> float:
    """Give the cost of a step from one state to the next, s; infinite where it is seen to be above ``room``."""
    dof = len(speeds)
    before, state = pair
    lasting, kind, slack, window = steps[node, 0], steps[node, 1], steps[node, 2], steps[node, 3]
    turn = abs(table[state, dof] - table[before, dof])
    turn = min(turn, abs(turn - 2.0 * math.pi))
    follows = turn <= window + _TIE
    if kind == FOLLOW and not follows:
        return 2.0 * DISCONTINUITY_COST_S
    most = slack + steps[node, 4] * turn + _TIE
    slowest, squared, widest = 0.0, 0.0, 0.0
    most_squared = (room - steps[node, 5] * turn) * max(lasting, _LEAST_LASTING_S) if kind == FOLLOW else math.inf
    for joint in range(dof):
        change = abs(table[state, joint] - table[before, joint])
        if speeds[joint, 1]:
            change = min(change, abs(change - 2.0 * math.pi))
        widest = max(widest, change * speeds[joint, 2])
        needed = change * speeds[joint, 0]
        slowest = max(slowest, needed)
        squared += needed * needed
        if kind == FOLLOW and (widest > most or squared > most_squared):
            return math.inf
    if kind == MUST_RECONFIGURE:
        return slowest
    if not follows or widest > most:
        more = UNWIND_COST_S if dof < 6 else 0.0
        return 2.0 * DISCONTINUITY_COST_S if kind == FOLLOW else RECONFIGURE_COST_S + more + slowest
    return (
        squared / max(lasting, _LEAST_LASTING_S)
        + _LATE_WEIGHT * max(0.0, slowest - _SPEED_SHARE * lasting)
        + steps[node, 5] * turn
    )


@compiled
def _is_forbidden(forbidden: NDArray[np.int64], before: int, state: int) -> bool:
    """Whether a pair is among those (k, 2), which are in the order of their second."""
    mark = np.searchsorted(forbidden[:, 1], state)
    while mark < len(forbidden) and forbidden[mark, 1] == state:
        if forbidden[mark, 0] == before:
            return True
        mark += 1
    return False
