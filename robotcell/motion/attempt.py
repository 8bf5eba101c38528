"""One attempt at a motion: a choice of postures followed at every sample, with the joint moves between its pieces."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices
from robotcell.motion.avoid_collisions import HITS, Knowledge
from robotcell.motion.cell_queries import Questions
from robotcell.motion.joint_move import JointMove, find_move
from robotcell.motion.joint_program import Leap
from robotcell.motion.ladder_graph import Nodes, States, paces_of
from robotcell.motion.ladder_search import Choice
from robotcell.motion.sampled_path import Course, Flags, denser
from robotcell.motion.track_branch import Followed, Wanted, chosen_postures, follow, settle, smooth

_SMOOTH_ROUNDS = 4
_WIDEST = 0.12
"""rad that a joint may turn from sample to sample; else more samples are taken."""
_MOST_PARTS = 40


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


@dataclass(slots=True, eq=False)
class Search:
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


def attempt(search: Search, choice: Choice) -> Motion:
    """Follow a choice at every sample, and look for what is wrong with it."""
    nodes, done = _follow(search, choice)
    moves = _joint_moves(search, choice, nodes, done)
    lost, hits = _wrong(search, choice, done)
    found = [(node, move) for node, move in moves if move is not None]
    return Motion(
        nodes=nodes,
        done=done,
        leaps=tuple(Leap(int(nodes.until[node]), int(nodes.sample[node + 1]), move) for node, move in found),
        hits=np.flatnonzero(hits),
        lost=np.flatnonzero(lost),
        torn=np.flatnonzero(choice.torn),
        blocked=np.array([node for node, move in moves if move is None], dtype=np.int64),
    )


def _follow(search: Search, choice: Choice) -> tuple[Nodes, Followed]:
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


def _smoothed(search: Search, raw: Wanted) -> Wanted:
    """Make azimuths smooth; leave alone those at which the posture would be lost."""
    ask, pinned = search.ask, search.pinned.copy()
    wanted = raw
    for _ in range(_SMOOTH_ROUNDS):
        wanted, lost = settle(ask.cell.robot, smooth(raw, search.course, pinned), search.course, ask.postures)
        if not lost.any():
            return wanted
        pinned |= widened(lost, 3)
    return settle(ask.cell.robot, smooth(raw, search.course, pinned), search.course, ask.postures)[0]


def _widest(ask: Questions, done: Followed) -> NDArray[np.float64]:
    """How far a turning joint goes in each interval (n - 1,) that is followed, rad."""
    turning = np.array([joint.kind == "revolute" for joint in ask.cell.robot.joints])
    far = np.max(np.abs(np.diff(done.q, axis=0)), axis=1, where=turning, initial=0.0)
    return np.where(np.diff(done.piece) == 0, far, 0.0)


def _wrong(search: Search, choice: Choice, done: Followed) -> tuple[Flags, Flags]:
    """Say at which samples the posture is lost or jumps, and at which something collides."""
    lost = done.lost | np.append(_widest(search.ask, done) > 2.0 * _WIDEST, False)
    hits = search.ask.touches(done.q, done.course.tool, done.course.placement)
    expected = search.known.verdict[choice.state] == HITS
    if not lost.any() and not (hits.any() and not expected.any()):
        same = np.flatnonzero(np.diff(done.piece) == 0)
        hits[same] |= search.ask.swept(done.q, done.course.tool, done.course.placement, same)
    return lost, hits


def _joint_moves(search: Search, choice: Choice, nodes: Nodes, done: Followed) -> list[tuple[int, JointMove | None]]:
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


def widened(flags: Flags, by: int) -> Flags:
    """Set what is no farther from something set than so many places."""
    return np.convolve(flags.astype(np.int64), np.ones(2 * by + 1, dtype=np.int64), mode="same") > 0
