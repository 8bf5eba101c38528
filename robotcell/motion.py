"""The motion of the joints along a course: searched, followed, looked at, and searched anew until nothing is wrong."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices
from geometry.progress import Progress
from robotcell.course import Course, Flags, denser
from robotcell.follow import Followed, Wanted, chosen_postures, follow, settle, smooth
from robotcell.joint_move import JointMove, find_move
from robotcell.layers import Asked, Nodes, States, asked_at, nodes_of, paces_of, states_of, steps_of
from robotcell.questions import Questions
from robotcell.resolve import HITS, Knowledge, Problem, nothing_known, resolve
from robotcell.retell import Leap
from robotcell.search import Choice

_ROUNDS = 12
_SMOOTH_ROUNDS = 4
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
    """Samples at which something collides whatever is chosen."""
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
    banned: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])


def find_motion(ask: Questions, course: Course, lean: float, tell: Progress) -> Motion | OutOfReach:
    """Find how the joints move along a course.

    Args:
        ask: What can be asked about the cell.
        course: Where the TCP is to go.
        lean: rad that the jet may lean while it sprays, where nothing else is clear.
        tell: Told how far the search is.
    """
    nodes = nodes_of(course)
    tell("solving postures", 0.05)
    everywhere = asked_at(nodes, np.arange(len(nodes.sample)), _STRAIGHT)
    states = states_of(ask.cell.robot, course, nodes, everywhere, ask.postures)
    empty = np.flatnonzero(np.diff(states.layers.first) == 0)
    if len(empty) and not course.wet[nodes.sample[empty]].any():
        states = _with_leans(ask, course, nodes, empty, lean)
        empty = np.flatnonzero(np.diff(states.layers.first) == 0)
    if len(empty):
        return OutOfReach(nodes, empty)
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
        search.states = _with_leans(search.ask, search.course, search.nodes, near, lean)
        search.known = nothing_known(search.states)
        choice = _resolve(search)
    if _close_loops(search, choice):
        choice = _resolve(search)
    return choice


def _resolve(search: _Search) -> Choice:
    problem = Problem(
        search.course,
        search.nodes,
        steps_of(search.course, search.nodes, search.ask.cell),
        paces_of(search.ask.cell.robot),
        search.ask.touches,
    )
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
        alike = search.states.label[low:high] == search.states.label[choice.state[first]]
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
    search.course, search.nodes, done = _follow(search, choice)
    moves = _joint_moves(search, choice, done)
    noted = _note(search, choice, done)
    blocked = [node for node, move in moves if move is None]
    for node in blocked:
        pair = (int(choice.state[node]), int(choice.state[node + 1]))
        if not search.course.changed[search.nodes.sample[node + 1]] and pair not in search.banned:
            search.banned.append(pair)
            noted = True
    leaps = tuple(
        Leap(int(search.nodes.until[node]), int(search.nodes.sample[node + 1]), move)
        for node, move in moves
        if move is not None
    )
    hits = search.nodes.sample[search.known.verdict[choice.state] == HITS]
    torn = np.flatnonzero(choice.torn)
    return Motion(search.nodes, done, leaps, hits, torn, np.array(blocked, dtype=np.int64)), noted


def _follow(search: _Search, choice: Choice) -> tuple[Course, Nodes, Followed]:
    """Give the joints at every sample, taking more samples where the joints turn far between two."""
    ask, course, nodes = search.ask, search.course, search.nodes
    raw = chosen_postures(search.states.layers, choice, nodes)
    wanted = _smoothed(search, raw)
    done = follow(ask.cell.robot, wanted, course, ask.postures)
    wide = _widest(ask, done)
    if wide.max(initial=0.0) > _WIDEST:
        parts = np.clip(np.ceil(wide / _WIDEST), 1, _MOST_PARTS).astype(np.int64)
        parts[np.diff(done.piece) != 0] = 1
        course, place = denser(course, parts)
        nodes = replace(nodes, sample=place[nodes.sample], until=place[nodes.until])
        wanted = replace(wanted, sample=nodes.sample, until=nodes.until)
        done = follow(ask.cell.robot, wanted, course, ask.postures)
    return course, nodes, done


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


def _note(search: _Search, choice: Choice, done: Followed) -> bool:
    """Note lost postures, jumps and collisions; say whether there were any that another choice may mend."""
    jumps = _widest(search.ask, done) > 2.0 * _WIDEST
    lost = done.lost | np.append(jumps, False)
    hits = search.ask.touches(done.q, done.course.tool, done.course.placement)
    if not (lost.any() or hits.any()):
        same = np.diff(done.piece) == 0
        hits[:-1][same] = search.ask.swept(done.q, done.course.tool, done.course.placement, np.flatnonzero(same))
    return _blame(search, choice, lost, banning=True) | _blame(search, choice, hits, banning=False)


def _blame(search: _Search, choice: Choice, wrong: Flags, *, banning: bool) -> bool:
    """Pin the nodes around wrong samples; where they are pinned already, forbid the step or the postures there."""
    count = len(search.nodes.sample)
    node = np.unique(np.searchsorted(search.nodes.sample, np.flatnonzero(wrong), side="right") - 1)
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


def _joint_moves(search: _Search, choice: Choice, done: Followed) -> list[tuple[int, JointMove | None]]:
    """Find a joint move for each leap of a choice; ``None`` where every way collides."""
    moves: list[tuple[int, JointMove | None]] = []
    course, nodes = done.course, search.nodes
    for node in np.flatnonzero(choice.leaps & ~choice.torn).tolist():
        begin, end = int(nodes.until[node]), int(nodes.sample[node + 1])
        tools = int(course.tool[begin]), int(course.tool[end])
        blocked = search.ask.blocked(int(course.placement[end]))
        moves.append((node, find_move(search.ask.cell, done.q[begin], done.q[end], tools, blocked)))
    return moves
