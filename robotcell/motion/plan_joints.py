"""The motion of the joints along a course: searched, followed, looked at, and searched anew until nothing is wrong."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices
from robotcell.motion.attempt import Motion, Search, attempt, widened
from robotcell.motion.avoid_collisions import HITS, Knowledge, Problem, nothing_known, resolve
from robotcell.motion.cell_queries import Questions
from robotcell.motion.ladder_graph import (
    Asked,
    Nodes,
    States,
    asked_at,
    near_home,
    nodes_of,
    paces_of,
    states_of,
    steps_of,
    with_windings,
)
from robotcell.motion.ladder_search import FOLLOW, MAY_LEAP, Choice
from robotcell.motion.sampled_path import Course
from robotcell.motion.track_branch import chosen_postures, overwound
from specs.progress import Progress

_ROUNDS = 12
_PATIENCE = 2
"""How often a leap is tried at one place, with other postures each time."""
_ALIKE = 0.05
"""rad or m"""
_TRANSFER_LEANS = np.radians([20.0, 40.0])
"""How far the jet may lean while it is off, where nothing else is clear."""
_LEANT_AZIMUTHS = 6
"""Tried about the jet where it may lean: a third of ``AZIMUTHS``, as there are seventeen leans to each."""
_STRAIGHT = np.zeros((1, 2))


@dataclass(frozen=True, slots=True, eq=False)
class OutOfReach:
    """Nodes that no posture reaches within the joints' limits."""

    nodes: Nodes
    empty: Indices


def find_motion(ask: Questions, course: Course, lean: float, progress: Progress) -> Motion | OutOfReach:
    """Find how the joints move along a course.

    Args:
        ask: What can be asked about the cell.
        course: Where the TCP is to go.
        lean: rad that the jet may lean while it sprays, where nothing else is clear.
        progress: Receives the stage and the share done.
    """
    nodes = nodes_of(course, ask.cell.robot.dof)
    progress("solving postures", 0.05)
    everywhere = asked_at(nodes, np.arange(len(nodes.sample)), _STRAIGHT)
    states = states_of(ask.cell.robot, course, nodes, everywhere, ask.postures)
    empty = np.flatnonzero(np.diff(states.layers.first) == 0)
    if len(empty) and not course.wet[nodes.sample[empty]].any():
        states = _with_leans(ask, course, nodes, empty, lean)
        empty = np.flatnonzero(np.diff(states.layers.first) == 0)
    if len(empty):
        return OutOfReach(nodes, empty)
    states = near_home(ask.cell, states)
    search = Search(ask, course, nodes, states, nothing_known(states), nodes.azimuths == 1)
    choice = _first_choice(search, lean, progress)
    return _settle_all(search, choice, progress)


def _first_choice(search: Search, lean: float, progress: Progress) -> Choice:
    """Search; let the jet lean where nothing else is clear; close loops."""
    progress("searching postures", 0.2)
    choice = _resolve(search)
    hit = np.flatnonzero(search.known.verdict[choice.state] == HITS)
    wet = search.course.wet[search.nodes.sample]
    if lean <= 0.0:
        hit = hit[~wet[hit]]
    if len(hit):
        progress("leaning where nothing else is clear", 0.35)
        near = np.unique(np.clip(hit[:, None] + np.arange(-2, 3), 0, len(wet) - 1))
        search.states = near_home(search.ask.cell, _with_leans(search.ask, search.course, search.nodes, near, lean))
        search.known = nothing_known(search.states)
        choice = _resolve(search)
    while _unwind(search, choice):
        progress("unwinding joints", 0.38)
        choice = _resolve(search)
    if _close_loops(search, choice):
        choice = _resolve(search)
    return choice


def _unwind(search: Search, choice: Choice) -> bool:
    """Tell whole turns of joints apart that a choice winds up beyond their limits; say whether there are any."""
    robot = search.ask.cell.robot
    wraps = paces_of(robot, search.wound).wraps
    wanted = chosen_postures(robot, search.states.layers, choice, search.nodes, wraps)
    fresh = np.setdiff1d(overwound(robot, wanted), search.wound).tolist()
    if not fresh:
        return False
    search.wound += fresh
    search.states, parent = with_windings(robot, search.states, fresh)
    known = search.known
    search.known = Knowledge(known.verdict[parent], known.suspect[parent], known.barred[parent])
    return True


def _resolve(search: Search) -> Choice:
    steps = steps_of(search.course, search.nodes, search.ask.cell)
    hopeless = [node for node, times in search.refused.items() if times >= _PATIENCE and steps.kind[node] == MAY_LEAP]
    steps.kind[hopeless] = FOLLOW
    paces = paces_of(search.ask.cell.robot, search.wound)
    problem = Problem(search.course, search.nodes, steps, paces, search.ask.touches)
    return resolve(problem, search.states, search.known, np.array(search.banned, dtype=np.int64).reshape(-1, 2))


def _with_leans(ask: Questions, course: Course, nodes: Nodes, where: Indices, lean: float) -> States:
    """Ask at some nodes for leaning poses too: within the band while spraying, further while the jet is off."""
    wet = course.wet[nodes.sample[where]]
    rest = np.setdiff1d(np.arange(len(nodes.sample)), where)
    fewer = replace(nodes, azimuths=np.minimum(nodes.azimuths, _LEANT_AZIMUTHS))
    parts = [asked_at(nodes, rest, _STRAIGHT), asked_at(fewer, where[~wet], _fan(_TRANSFER_LEANS))]
    if lean > 0.0:
        parts.append(asked_at(fewer, where[wet], _fan(np.array([0.5 * lean, lean]))))
    else:
        parts.append(asked_at(nodes, where[wet], _STRAIGHT))
    node = np.concatenate([part.node for part in parts])
    order = np.argsort(node, kind="stable")
    asked = Asked(
        node[order],
        np.concatenate([part.azimuth for part in parts])[order],
        np.concatenate([part.lean for part in parts])[order],
        np.concatenate([part.label for part in parts])[order],
    )
    return states_of(ask.cell.robot, course, nodes, asked, ask.postures)


def _fan(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give no lean, and each angle in eight directions."""
    turns = np.radians(np.arange(0.0, 360.0, 45.0))
    return np.concatenate([_STRAIGHT, *(angle * np.column_stack((np.cos(turns), np.sin(turns))) for angle in angles)])


def _close_loops(search: Search, choice: Choice) -> bool:
    """Let each repeated part end in the posture in which it begins; say whether anything had to be changed."""
    changed = False
    for begin, end in search.ask.loops(search.course):
        first, last = (int(np.searchsorted(search.nodes.sample, at, side="right")) - 1 for at in (begin, end))
        search.pinned[[first, last]] = True
        low, high = search.states.layers.first[last : last + 2]
        q = search.states.layers.q
        alike = np.abs(q[low:high] - q[choice.state[first]]).max(axis=1) < 1e-6
        same = np.abs(search.course.T_base_tcp[begin] - search.course.T_base_tcp[end]).max() < 1e-6
        if same and alike.any():
            search.known.barred[low:high] = ~alike
            changed |= not alike[choice.state[last] - low]
            others = np.arange(*search.states.layers.first[first : first + 2])
            search.known.barred[others] = others != choice.state[first]
    return changed


def _settle_all(search: Search, choice: Choice, progress: Progress) -> Motion:
    """Follow the choice, look for what is wrong, and choose anew until nothing is or nothing helps."""
    motion = attempt(search, choice)
    for number in range(_ROUNDS):
        progress("following the course", 0.4 + 0.5 * number / _ROUNDS)
        if not _note(search, choice, motion):
            break
        choice = _resolve(search)
        motion = attempt(search, choice)
    return motion


def _note(search: Search, choice: Choice, motion: Motion) -> bool:
    """Note what is wrong with an attempt for the next search; say whether there was anything that it may mend."""
    noted = _blame(search, choice, motion.nodes, motion.lost, banning=True)
    noted |= _blame(search, choice, motion.nodes, motion.hits, banning=False)
    for node in motion.blocked.tolist():
        search.refused[node] = search.refused.get(node, 0) + 1
        pair = (int(choice.state[node]), int(choice.state[node + 1]))
        if not motion.done.course.changed[motion.nodes.sample[node + 1]] and pair not in search.banned:
            search.banned.append(pair)
            noted = True
    return noted


def _blame(search: Search, choice: Choice, nodes: Nodes, wrong: Indices, *, banning: bool) -> bool:
    """Pin the nodes around wrong samples; where they are pinned already, forbid the step or the postures there."""
    count = len(nodes.sample)
    node = np.unique(np.searchsorted(nodes.sample, wrong, side="right") - 1)
    node = node[~np.append(choice.torn, False)[node]]
    hit = search.known.verdict[choice.state] == HITS
    around = np.stack((node, np.minimum(node + 1, count - 1)), axis=1)
    node, around = node[~hit[around].any(axis=1)], around[~hit[around].any(axis=1)]
    if len(node) == 0:
        return False
    fixed = search.pinned[around].all(axis=1)
    search.pinned |= widened(np.isin(np.arange(count), around[~fixed]), 3)
    if banning:
        pairs = [(int(a), int(b)) for a, b in choice.state[around[fixed]].tolist()]
        search.banned += [pair for pair in pairs if pair not in search.banned]
    else:
        for state in np.unique(choice.state[around[fixed]]).tolist():
            search.known.verdict[_alike(search.states, state)] = HITS
    return True


def _alike(states: States, state: int) -> Indices:
    """States of the same node whose arm stands alike, whatever the last joint does: what hits in one hits in all."""
    low, high = states.layers.first[states.node[state] : states.node[state] + 2]
    off = np.abs(states.layers.q[low:high] - states.layers.q[state])[:, :-1]
    return low + np.flatnonzero(off.max(axis=1) < _ALIKE)
