"""The motion of the joints along a course: searched, followed, looked at, and searched anew until nothing is wrong."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices
from geometry.progress import Progress
from robotcell.course import Course, Flags, denser
from robotcell.follow import Followed, Wanted, chosen_postures, follow, overwound, settle, smooth
from robotcell.joint_move import JointMove, find_move
from robotcell.layers import (
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
from robotcell.questions import Questions
from robotcell.resolve import HITS, Knowledge, Problem, nothing_known, resolve
from robotcell.retell import Leap
from robotcell.search import FOLLOW, MAY_LEAP, Choice

_ROUNDS = 12
_SMOOTH_ROUNDS = 4
_PATIENCE = 2
"""How often a leap is tried at one place, with other postures each time."""
_WIDEST = 0.12
"""rad that a joint may turn from sample to sample; else more samples are taken."""
_MOST_PARTS = 40
_TRANSFER_LEANS = np.radians([20.0, 40.0])
"""How far the jet may lean while it is off, where nothing else is clear."""
_LEANT_AZIMUTHS = 6
"""Tried about the jet where it may lean: a third of ``AZIMUTHS``, as there are seventeen leans to each."""
_STRAIGHT = np.zeros((1, 2))


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """What was found."""

    nodes: Nodes
    done: Followed
    leaps: tuple[Leap, ...]
    hits: Indices
    """Samples at which something collides whatever was chosen."""
    lost: Indices
    """Samples at which no posture goes on from the one before."""
    torn: Indices
    """Nodes after which the configuration would have to change while the jet is on."""
    blocked: Indices
    """Nodes after which a joint move is needed, and every way that was tried collides."""


@dataclass(frozen=True, slots=True, eq=False)
class OutOfReach:
    """Nodes that no posture reaches within the joints' limits."""

    nodes: Nodes
    empty: Indices


@dataclass(slots=True, eq=False)
class _Search:
    """How far the search has come."""

    ask: Questions
    course: Course
    nodes: Nodes
    states: States
    known: Knowledge
    pinned: Flags
    """(nodes,) whose azimuth is not made smooth."""
    wound: list[int] = field(default_factory=list[int])
    """Joints whose whole turns are told apart."""
    banned: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])
    refused: dict[int, int] = field(default_factory=dict[int, int])
    """How often no way was found for a leap after a node."""


def find_motion(ask: Questions, course: Course, lean: float, tell: Progress) -> Motion | OutOfReach:
    """Find how the joints move along a course.

    Args:
        ask: What can be asked about the cell.
        course: Where the TCP is to go.
        lean: rad that the jet may lean while it sprays, where nothing else is clear.
        tell: Told how far the search is.
    """
    nodes = nodes_of(course, ask.cell.robot.dof)
    tell("solving postures", 0.05)
    everywhere = asked_at(nodes, np.arange(len(nodes.sample)), _STRAIGHT)
    states = states_of(ask.cell.robot, course, nodes, everywhere, ask.postures)
    empty = np.flatnonzero(np.diff(states.layers.first) == 0)
    if len(empty) and not course.wet[nodes.sample[empty]].any():
        states = _with_leans(ask, course, nodes, empty, lean)
        empty = np.flatnonzero(np.diff(states.layers.first) == 0)
    if len(empty):
        return OutOfReach(nodes, empty)
    states = near_home(ask.cell, states)
    search = _Search(ask, course, nodes, states, nothing_known(states), nodes.azimuths == 1)
    choice = _first_choice(search, lean, tell)
    return _settle_all(search, choice, tell)


def _first_choice(search: _Search, lean: float, tell: Progress) -> Choice:
    """Search; let the jet lean where nothing else is clear; close loops."""
    tell("searching postures", 0.2)
    choice = _resolve(search)
    hit = np.flatnonzero(search.known.verdict[choice.state] == HITS)
    wet = search.course.wet[search.nodes.sample]
    if lean <= 0.0:
        hit = hit[~wet[hit]]
    if len(hit):
        tell("leaning where nothing else is clear", 0.35)
        near = np.unique(np.clip(hit[:, None] + np.arange(-2, 3), 0, len(wet) - 1))
        search.states = near_home(search.ask.cell, _with_leans(search.ask, search.course, search.nodes, near, lean))
        search.known = nothing_known(search.states)
        choice = _resolve(search)
    while _unwind(search, choice):
        tell("unwinding joints", 0.38)
        choice = _resolve(search)
    if _close_loops(search, choice):
        choice = _resolve(search)
    return choice


def _unwind(search: _Search, choice: Choice) -> bool:
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


def _resolve(search: _Search) -> Choice:
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


def _close_loops(search: _Search, choice: Choice) -> bool:
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


def _settle_all(search: _Search, choice: Choice, tell: Progress) -> Motion:
    """Follow the choice, look for what is wrong, and choose anew until nothing is or nothing helps."""
    motion, wrong = _try(search, choice)
    for number in range(_ROUNDS):
        tell("following the course", 0.4 + 0.5 * number / _ROUNDS)
        if not wrong or number == _ROUNDS - 1:
            break
        choice = _resolve(search)
        motion, wrong = _try(search, choice)
    return motion


def _try(search: _Search, choice: Choice) -> tuple[Motion, bool]:
    """Follow a choice; note what is wrong with it for the next search, and say whether there was anything."""
    nodes, done = _follow(search, choice)
    moves = _joint_moves(search, choice, nodes, done)
    lost, hits = _wrong(search, choice, done)
    noted = _blame(search, choice, nodes, lost, banning=True) | _blame(search, choice, nodes, hits, banning=False)
    blocked = [node for node, move in moves if move is None]
    for node in blocked:
        search.refused[node] = search.refused.get(node, 0) + 1
        pair = (int(choice.state[node]), int(choice.state[node + 1]))
        if not done.course.changed[nodes.sample[node + 1]] and pair not in search.banned:
            search.banned.append(pair)
            noted = True
    motion = Motion(
        nodes=nodes,
        done=done,
        leaps=tuple(
            Leap(int(nodes.until[node]), int(nodes.sample[node + 1]), move) for node, move in moves if move is not None
        ),
        hits=np.flatnonzero(hits),
        lost=np.flatnonzero(lost),
        torn=np.flatnonzero(choice.torn),
        blocked=np.array(blocked, dtype=np.int64),
    )
    return motion, noted


def _follow(search: _Search, choice: Choice) -> tuple[Nodes, Followed]:
    """Give the joints at every sample, taking more samples where the joints turn far between two."""
    ask, course, nodes = search.ask, search.course, search.nodes
    wraps = paces_of(ask.cell.robot, search.wound).wraps
    raw = chosen_postures(ask.cell.robot, search.states.layers, choice, nodes, wraps)
    wanted = _smoothed(search, raw)
    done = follow(ask.cell.robot, wanted, course, ask.postures)
    wide = _widest(ask, done)
    wide[_within(nodes, np.flatnonzero(choice.torn), len(wide))] = 0.0
    if wide.max(initial=0.0) > _WIDEST:
        parts = np.clip(np.ceil(wide / _WIDEST), 1, _MOST_PARTS).astype(np.int64)
        course, place = denser(course, parts)
        nodes = replace(nodes, sample=place[nodes.sample], until=place[nodes.until])
        wanted = replace(wanted, sample=nodes.sample, until=nodes.until)
        done = follow(ask.cell.robot, wanted, course, ask.postures)
    return nodes, done


def _within(nodes: Nodes, after: Indices, count: int) -> Flags:
    """(count,) intervals of the course between some nodes and the next."""
    inside = np.zeros(count + 1, dtype=np.int64)
    np.add.at(inside, nodes.until[after], 1)
    np.add.at(inside, nodes.sample[after + 1], -1)
    return np.cumsum(inside)[:count] > 0


def _smoothed(search: _Search, raw: Wanted) -> Wanted:
    """Make azimuths smooth; leave alone those at which the posture would be lost."""
    ask, pinned = search.ask, search.pinned.copy()
    wanted = raw
    for _ in range(_SMOOTH_ROUNDS):
        wanted, lost = settle(ask.cell.robot, smooth(raw, search.course, pinned), search.course, ask.postures)
        if not lost.any():
            return wanted
        pinned |= _widened(lost, 3)
    return settle(ask.cell.robot, smooth(raw, search.course, pinned), search.course, ask.postures)[0]


def _widest(ask: Questions, done: Followed) -> NDArray[np.float64]:
    """How far a turning joint goes in each interval (n - 1,) that is followed, rad."""
    turning = np.array([joint.kind == "revolute" for joint in ask.cell.robot.joints])
    far = np.max(np.abs(np.diff(done.q, axis=0)), axis=1, where=turning, initial=0.0)
    return np.where(np.diff(done.piece) == 0, far, 0.0)


def _wrong(search: _Search, choice: Choice, done: Followed) -> tuple[Flags, Flags]:
    """Say at which samples the posture is lost or jumps, and at which something collides."""
    lost = done.lost | np.append(_widest(search.ask, done) > 2.0 * _WIDEST, False)
    hits = search.ask.touches(done.q, done.course.tool, done.course.placement)
    expected = search.known.verdict[choice.state] == HITS
    if not lost.any() and not (hits.any() and not expected.any()):
        same = np.flatnonzero(np.diff(done.piece) == 0)
        hits[same] |= search.ask.swept(done.q, done.course.tool, done.course.placement, same)
    return lost, hits


def _blame(search: _Search, choice: Choice, nodes: Nodes, wrong: Flags, *, banning: bool) -> bool:
    """Pin the nodes around wrong samples; where they are pinned already, forbid the step or the postures there."""
    count = len(nodes.sample)
    node = np.unique(np.searchsorted(nodes.sample, np.flatnonzero(wrong), side="right") - 1)
    node = node[~np.append(choice.torn, False)[node]]
    hit = search.known.verdict[choice.state] == HITS
    around = np.stack((node, np.minimum(node + 1, count - 1)), axis=1)
    node, around = node[~hit[around].any(axis=1)], around[~hit[around].any(axis=1)]
    if len(node) == 0:
        return False
    fixed = search.pinned[around].all(axis=1)
    search.pinned |= _widened(np.isin(np.arange(count), around[~fixed]), 3)
    if banning:
        pairs = [(int(a), int(b)) for a, b in choice.state[around[fixed]].tolist()]
        search.banned += [pair for pair in pairs if pair not in search.banned]
    else:
        search.known.verdict[choice.state[around[fixed]]] = HITS
    return True


def _widened(flags: Flags, by: int) -> Flags:
    return np.convolve(flags.astype(np.int64), np.ones(2 * by + 1, dtype=np.int64), mode="same") > 0


def _joint_moves(search: _Search, choice: Choice, nodes: Nodes, done: Followed) -> list[tuple[int, JointMove | None]]:
    """Find a joint move for each leap of a choice; ``None`` where every way collides."""
    moves: list[tuple[int, JointMove | None]] = []
    course = done.course
    for node in np.flatnonzero(choice.leaps & ~choice.torn).tolist():
        begin, end = int(nodes.until[node]), int(nodes.sample[node + 1])
        tools = int(course.tool[begin]), int(course.tool[end])
        blocked = search.ask.blocked(int(course.placement[end]))
        ends = [search.ask.raised(done.q[at], done.T_base_tcp[at], int(course.tool[at])) for at in (begin, end)]
        moves.append((node, find_move(search.ask.cell, ends[0], ends[1], tools, blocked)))
    return moves
