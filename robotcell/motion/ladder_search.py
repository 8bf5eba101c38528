"""The cheapest way through layers of joint positions: dynamic programming, compiled.

Viterbi, "Error bounds for convolutional codes and an asymptotically optimum decoding algorithm" (1967).
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from geometry.coverage.compiled import compiled, quick
from robotcell.robot.robot import Joints

LEAP_S = 3.0
"""What a change of configuration costs on top of its own time, in seconds."""
TORN_S = 1e5
"""What it costs where there must be none."""
_TURN_S = 0.02
"""Seconds that a radian about the jet is worth where it gains nothing."""
_LATE = 4.0
"""How many times over a second counts by which the joints are slower than the program."""
_SHARE = 0.8
"""Of a joint's greatest speed that it may need before that counts as late."""
_LEAST_S = 0.02
_TIE = 1e-9
"""s: what costs so little more is as good; the first is taken."""
FOLLOW, MAY_LEAP, MUST_LEAP = 0, 1, 2
"""What may be done between two layers: follow the course, change the configuration too, or that in any case."""


class Layers(NamedTuple):
    """What the robot could do at each of n nodes: m states, layer after layer."""

    first: Indices
    """(n + 1,) where each layer begins."""
    q: Joints
    """(m, dof)"""
    azimuth: Scalars
    """(m,) rad about the jet, from what the program asks for."""
    lean: NDArray[np.float64]
    """(m, 2) rad about the tool's own x and y, from what the program asks for."""
    cost: Scalars
    """(m,) seconds that a state is as bad as."""


class Steps(NamedTuple):
    """What lies between the layers: n - 1 intervals."""

    lasting: Scalars
    """(n - 1,) s"""
    kind: Indices
    """(n - 1,) FOLLOW, MAY_LEAP or MUST_LEAP"""
    slack: Scalars
    """(n - 1,) rad that a joint may turn while the course is followed."""
    window: Scalars
    """(n - 1,) rad that the tool may turn about its jet."""
    turning: Scalars
    """(n - 1,) rad that a joint may turn more for each radian that the tool turns about its jet."""


class Paces(NamedTuple):
    """What the joints can do."""

    seconds: Scalars
    """(dof,) for a radian or a metre, at the greatest speed."""
    wraps: NDArray[np.bool_]
    """(dof,) whether a joint may go on past a whole turn."""
    turns: NDArray[np.bool_]
    """(dof,) whether it is revolute."""


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """One state of each layer."""

    state: Indices
    """(n,)"""
    leaps: NDArray[np.bool_]
    """(n - 1,) whether the course is left between two layers."""
    torn: NDArray[np.bool_]
    """(n - 1,) whether it is left where it must not be."""


def cheapest(layers: Layers, steps: Steps, paces: Paces, banned: NDArray[np.int64]) -> Choice:
    """Choose a state of each layer so that states and steps together cost least; the first of equals.

    Args:
        layers: At least one state in each.
        steps: Between them.
        paces: Of the joints.
        banned: (k, 2) pairs of states that must not follow each other.
    """
    order = np.argsort(banned[:, 1], kind="stable")
    table = np.column_stack((layers.q, layers.azimuth))
    between, able = (np.stack([np.asarray(row, dtype=np.float64) for row in rows], axis=1) for rows in (steps, paces))
    best, came = _sweep(layers.first, table, layers.cost, between, able, banned[order])
    state = np.empty(len(layers.first) - 1, dtype=np.int64)
    begin = layers.first[-2]
    state[-1] = begin + int(np.argmin(np.round(best[begin:], 9)))
    for node in range(len(state) - 1, 0, -1):
        state[node - 1] = came[state[node]]
    return Choice(state, *_kinds(layers, steps, paces, state))


def _kinds(layers: Layers, steps: Steps, paces: Paces, state: Indices) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which steps of a choice leave the course, and which of those must not."""
    way = np.diff(layers.q[state], axis=0)
    way = np.abs(np.where(paces.wraps, way - 2.0 * np.pi * np.round(way / (2.0 * np.pi)), way))
    turn = np.diff(layers.azimuth[state])
    turn = np.abs(turn - 2.0 * np.pi * np.round(turn / (2.0 * np.pi)))
    widest = np.max(way, axis=1, where=paces.turns, initial=0.0)
    leaves = (widest > steps.slack + steps.turning * turn + 1e-9) | (turn > steps.window + 1e-9)
    return leaves | (steps.kind == MUST_LEAP), leaves & (steps.kind == FOLLOW)


@compiled
def _sweep(
    first: Indices,
    table: NDArray[np.float64],
    cost: Scalars,
    steps: NDArray[np.float64],
    paces: NDArray[np.float64],
    banned: NDArray[np.int64],
) -> tuple[Scalars, Indices]:
    """Least cost (m,) of reaching each state, and the state before it."""
    best = cost.copy()
    came = np.full(len(best), -1, dtype=np.int64)
    for node in range(len(steps)):
        low, high = first[node], first[node + 1]
        nearest = low
        for before in range(low, high):
            if best[before] < best[nearest] - _TIE:
                nearest = before
        for state in range(high, first[node + 2]):
            least, source = best[nearest] + TORN_S, nearest
            for before in range(low, high):
                if best[before] >= least - _TIE:
                    continue
                step = best[before] + _step(table, before, state, steps, node, paces)
                if step < least - _TIE and not _is_banned(banned, before, state):
                    least, source = step, before
            best[state] += least
            came[state] = source
    return best, came


@quick
def _step(
    table: NDArray[np.float64],
    before: int,
    state: int,
    steps: NDArray[np.float64],
    node: int,
    paces: NDArray[np.float64],
) -> float:
    """Seconds that a step from one state to the next is as bad as."""
    dof = len(paces)
    lasting, kind, slack, window = steps[node, 0], steps[node, 1], steps[node, 2], steps[node, 3]
    turn = abs(table[state, dof] - table[before, dof])
    turn = min(turn, abs(turn - 2.0 * math.pi))
    follows = turn <= window + _TIE
    if kind == FOLLOW and not follows:
        return 2.0 * TORN_S
    most = slack + steps[node, 4] * turn + _TIE
    slowest, squared, widest = 0.0, 0.0, 0.0
    for joint in range(dof):
        way = abs(table[state, joint] - table[before, joint])
        if paces[joint, 1]:
            way = min(way, abs(way - 2.0 * math.pi))
        widest = max(widest, way * paces[joint, 2])
        needed = way * paces[joint, 0]
        slowest = max(slowest, needed)
        squared += needed * needed
    if kind == MUST_LEAP:
        return slowest
    if not follows or widest > most:
        return 2.0 * TORN_S if kind == FOLLOW else LEAP_S + slowest
    return squared / max(lasting, _LEAST_S) + _LATE * max(0.0, slowest - _SHARE * lasting) + _TURN_S * turn


@compiled
def _is_banned(banned: NDArray[np.int64], before: int, state: int) -> bool:
    """Whether a pair is among those (k, 2), which are in the order of their second."""
    mark = np.searchsorted(banned[:, 1], state)
    while mark < len(banned) and banned[mark, 1] == state:
        if banned[mark, 0] == before:
            return True
        mark += 1
    return False
