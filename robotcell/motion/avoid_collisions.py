"""Postures at nodes that collide with nothing: search, look at what was chosen, forbid what collides, search anew."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices
from robotcell.motion.ladder_graph import Nodes, States
from robotcell.motion.ladder_search import Choice, Paces, Steps, cheapest
from robotcell.motion.sampled_path import Course, Flags
from robotcell.robot.robot import Joints

Touches: TypeAlias = Callable[[Joints, Indices, Indices], Flags]
"""Takes (k, dof) joints, the tool's index and the board's placement of each; says (k,) which collide."""

HIT_S = 1e3
"""What a posture that collides costs: more than all that is free, less than leaving the course."""
_SUSPECT_S = 1.0
"""What a posture costs of which a neighbour collides."""
_ROUNDS = 60
_MOST_AT_ONCE = 20_000
"""States looked at in a round beyond the chosen ones."""
_NEVER = np.zeros((0, 2), dtype=np.int64)

UNKNOWN, CLEAR, HITS = 0, 1, 2


@dataclass(frozen=True, slots=True, eq=False)
class Knowledge:
    """What is known of m states; it grows while the search goes on."""

    verdict: NDArray[np.int8]
    """(m,) UNKNOWN, CLEAR or HITS"""
    suspect: Flags
    """(m,)"""
    barred: Flags
    """(m,) whether it must not be chosen for another reason, if there is a choice."""


def nothing_known(states: States) -> Knowledge:
    """Begin without knowing anything."""
    count = len(states.node)
    return Knowledge(np.zeros(count, dtype=np.int8), np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_))


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """What is searched."""

    course: Course
    nodes: Nodes
    steps: Steps
    paces: Paces
    touches: Touches


def resolve(problem: Problem, states: States, known: Knowledge, banned: NDArray[np.int64] = _NEVER) -> Choice:
    """Choose a state of every node; one that collides only where all that could be chosen do.

    Args:
        problem: The course and its nodes, none without a state.
        states: What the robot could do there.
        known: Of the states; what is found out is added.
        banned: (k, 2) states that must not follow each other.
    """
    choice = _choose(problem, states, known, banned)
    for _ in range(_ROUNDS):
        fresh = choice.state[known.verdict[choice.state] == UNKNOWN]
        if len(fresh) == 0:
            break
        _look(problem, states, known, fresh)
        bad = np.unique(states.node[fresh[known.verdict[fresh] == HITS]])
        if len(bad) == 0:
            break
        _spread(problem, states, known, bad)
        choice = _choose(problem, states, known, banned)
    return choice


def _choose(problem: Problem, states: States, known: Knowledge, banned: NDArray[np.int64]) -> Choice:
    doubtful = known.suspect & (known.verdict == UNKNOWN)
    price = HIT_S * (known.verdict == HITS) + 10.0 * HIT_S * known.barred + _SUSPECT_S * doubtful
    return cheapest(states.layers._replace(cost=states.layers.cost + price), problem.steps, problem.paces, banned)


def _look(problem: Problem, states: States, known: Knowledge, which: Indices) -> None:
    """Find out whether states collide."""
    sample = problem.nodes.sample[states.node[which]]
    course = problem.course
    hits = problem.touches(states.layers.q[which], course.tool[sample], course.placement[sample])
    known.verdict[which] = np.where(hits, HITS, CLEAR)


def _spread(problem: Problem, states: States, known: Knowledge, bad: Indices) -> None:
    """Look at all states of some of the nodes whose choice collides, and suspect those that are alike at the others."""
    sizes = np.diff(states.layers.first)[bad]
    stride = max(1, int(np.ceil(sizes.sum() / _MOST_AT_ONCE)))
    seen = bad[::stride]
    members = np.concatenate([np.arange(*states.layers.first[node : node + 2]) for node in seen.tolist()])
    _look(problem, states, known, members[known.verdict[members] == UNKNOWN])
    if stride == 1:
        return
    width = int(states.label.max()) + 1
    hits = members[known.verdict[members] == HITS]
    nearest = seen[np.minimum(np.arange(len(bad)) // stride, len(seen) - 1)]
    others = np.concatenate([np.arange(*states.layers.first[node : node + 2]) for node in bad.tolist()])
    model = np.repeat(nearest, sizes)
    known.suspect[others] |= np.isin(
        model * width + states.label[others], states.node[hits] * width + states.label[hits]
    )
