"""Planning of the joint motion along a path: ladder search, tracking, checks, and search anew until nothing is wrong.

Collisions are checked lazily: only what was chosen is looked at; what collides is priced out and the search done anew.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices
from robotcell.kinematics.inverse import gantry_of
from robotcell.motion.cell_queries import CellQueries
from robotcell.motion.even_turns import EvenLines, find_even_lines, with_lap_lines
from robotcell.motion.ladder_graph import (
    STRAIGHT,
    NodePoses,
    Nodes,
    choose_nodes,
    joint_speeds,
    ladder_steps,
    node_pieces,
    node_poses,
    solve_states,
    with_full_turns,
    with_home_costs,
)
from robotcell.motion.ladder_search import FOLLOW, MAY_RECONFIGURE, MUST_RECONFIGURE, Choice, Ladder, cheapest
from robotcell.motion.sampled_path import SampledPath
from robotcell.motion.track_attempt import (
    CLEAR,
    HITS,
    UNKNOWN,
    Knowledge,
    Motion,
    Search,
    attempt_motion,
    chosen_configurations,
    nothing_known,
    widened,
)
from specs.progress import Progress

_ATTEMPTS = 12
_PATIENCE = 4
"""Attempts in a row that may have no fewer flaws than the best before the search ends with what it found."""
_MOST_REFUSALS = 2
"""How often a reconfiguration is tried at one place, with other configurations each time."""
_ALIKE = 0.05
"""rad or m"""
_TRANSFER_TILTS = np.radians([20.0, 40.0])
"""Largest tilts of the jet while it is off, where nothing else is clear."""
_TILTED_AZIMUTHS = 6
"""Tried about the jet where it may be tilted: a third of ``AZIMUTHS``, as there are seventeen tilts to each."""
_HIT_COST_S = 1e3
"""Cost of a configuration that collides: more than all that is free, less than leaving the path."""
_SUSPECT_COST_S = 1.0
"""Cost of a configuration of which a neighbour collides."""
_CLEAR_ROUNDS = 60
_MOST_AT_ONCE = 20_000
"""States checked in a round beyond the chosen ones."""


@dataclass(frozen=True, slots=True, eq=False)
class OutOfReach:
    """Nodes that no configuration reaches within the joints' limits."""

    nodes: Nodes
    empty: Indices


def plan_motion(queries: CellQueries, path: SampledPath, tilt: float, progress: Progress) -> Motion | OutOfReach:
    """Plan how the joints move along a path.

    Args:
        queries: Queries to the cell.
        path: The path of the TCP.
        tilt: rad that the jet may be tilted while it sprays, where nothing else is clear.
        progress: Receives the stage and the share done.
    """
    even = find_even_lines(path, queries.cell)
    begun = _begin_search(queries, path, even, tilt, progress)
    if isinstance(begun, OutOfReach):
        return begun
    if _winds_up(*begun):
        progress("turning over the vertical within laps", 0.38)
        again = _begin_search(queries, path, with_lap_lines(path, even), tilt, progress)
        begun = begun if isinstance(again, OutOfReach) or _winds_up(*again) else again
    search, choice = begun
    motion = attempt_motion(search, choice)
    fewest, since = motion.flaws, 0
    for number in range(_ATTEMPTS):
        progress("tracking the path", 0.4 + 0.5 * number / _ATTEMPTS)
        if since == _PATIENCE or not _note_flaws(search, choice, motion):
            break
        choice = _choose(search)
        motion = attempt_motion(search, choice)
        flaws = motion.flaws
        fewest, since = min(fewest, flaws), 0 if flaws < fewest else since + 1
    return motion


def _begin_search(
    queries: CellQueries, path: SampledPath, even: EvenLines, tilt: float, progress: Progress
) -> tuple[Search, Choice] | OutOfReach:
    """Solve the nodes of a path, and choose for the first time."""
    nodes = choose_nodes(path, queries.cell.robot.dof, even, queries.repeats(path))
    progress("solving configurations", 0.05)
    everywhere = (node_poses(nodes, some, STRAIGHT) for some in node_pieces(nodes))
    ladder = solve_states(queries, path, nodes, everywhere)
    empty = np.flatnonzero(np.diff(ladder.first) == 0)
    tilted = empty[:0]
    if len(empty) and not path.jet_on[nodes.sample[empty]].any():
        tilted = empty
        ladder = _with_tilts(queries, path, nodes, tilted, tilt)
        empty = np.flatnonzero(np.diff(ladder.first) == 0)
    if len(empty):
        return OutOfReach(nodes, empty)
    ladder, known = with_home_costs(queries.cell, ladder), nothing_known(len(ladder.q))
    search = Search(queries, path, nodes, ladder, known, nodes.azimuths == 1, tilted, even)
    return search, _first_choice(search, tilt, progress)


def _winds_up(search: Search, choice: Choice) -> bool:
    """Whether a gantry's joints would have to change their configuration on the path because they wind up."""
    return bool(choice.discontinuities.any() and search.multi_turn) and gantry_of(search.queries.cell.robot) is not None


def _first_choice(search: Search, tilt: float, progress: Progress) -> Choice:
    """Search; tilt the jet where nothing else is clear; separate whole turns; close repeats."""
    progress("searching configurations", 0.2)
    choice = _choose(search)
    hit = np.flatnonzero(search.known.verdict[choice.state] == HITS)
    jet_on = search.path.jet_on[search.nodes.sample]
    if tilt <= 0.0:
        hit = hit[~jet_on[hit]]
    if len(hit):
        progress("tilting the jet where nothing else is clear", 0.35)
        near = np.clip(hit[:, None] + np.arange(-2, 3), 0, len(jet_on) - 1)
        search.tilted = np.union1d(search.tilted, near)
        ladder = _with_tilts(search.queries, search.path, search.nodes, search.tilted, tilt)
        search.ladder, search.known = with_home_costs(search.queries.cell, ladder), nothing_known(len(ladder.q))
        choice = _choose(search)
    while _separate_turns(search, choice):
        progress("separating whole turns of joints", 0.38)
        choice = _choose(search)
    return _choose(search) if _close_repeats(search, choice) else choice


def _separate_turns(search: Search, choice: Choice) -> bool:
    """Give joints that a choice turns beyond their limits states for each whole turn; return whether there are any."""
    robot = search.queries.cell.robot
    wraps = joint_speeds(robot, search.multi_turn).wraps
    q = chosen_configurations(robot, search.ladder, choice, search.nodes, wraps).q
    beyond = np.flatnonzero(((q < robot.lowest - 1e-6) | (q > robot.highest + 1e-6)).any(axis=0))
    fresh = np.setdiff1d(beyond, search.multi_turn).tolist()
    if not fresh:
        return False
    search.multi_turn += fresh
    search.ladder, parent = with_full_turns(robot, search.ladder, fresh)
    known = search.known
    search.known = Knowledge(known.verdict[parent], known.suspect[parent], known.excluded[parent])
    return True


def _choose(search: Search) -> Choice:
    """Choose a state of every node; where that breaks off on the path, with changes all along level ways too."""
    choice = _choose_once(search)
    if search.anywhere or not choice.discontinuities.any():
        return choice
    search.anywhere = True
    return _choose_once(search)


def _choose_once(search: Search) -> Choice:
    """Choose a state of every node; one that collides only where all that could be chosen do."""
    steps = ladder_steps(search.path, search.nodes, search.queries.cell, search.even, anywhere=search.anywhere)
    counts = search.refused.items()
    steps.kind[[at for at, times in counts if times >= _MOST_REFUSALS and steps.kind[at] == MAY_RECONFIGURE]] = FOLLOW
    steps.kind[list(search.by_joints)] = MUST_RECONFIGURE
    speeds = joint_speeds(search.queries.cell.robot, search.multi_turn)
    forbidden = np.array(search.forbidden, dtype=np.int64).reshape(-1, 2)
    ladder, known = search.ladder, search.known
    rounds = 0
    while True:
        doubtful = known.suspect & (known.verdict == UNKNOWN)
        price = _HIT_COST_S * (known.verdict == HITS) + 10.0 * _HIT_COST_S * known.excluded + _SUSPECT_COST_S * doubtful
        choice = cheapest(ladder._replace(cost=ladder.cost + price), steps, speeds, forbidden)
        fresh = choice.state[known.verdict[choice.state] == UNKNOWN]
        if rounds == _CLEAR_ROUNDS or len(fresh) == 0:
            return choice
        _check_states(search, fresh)
        bad = np.unique(search.ladder.node[fresh[known.verdict[fresh] == HITS]])
        if len(bad) == 0:
            return choice
        _check_rungs(search, bad)
        rounds += 1


def _check_states(search: Search, which: Indices) -> None:
    """Find out whether states collide."""
    path, sample = search.path, search.nodes.sample[search.ladder.node[which]]
    hits = search.queries.collide(search.ladder.q[which], path.tool[sample], path.placement[sample])
    search.known.verdict[which] = np.where(hits, HITS, CLEAR)


def _check_rungs(search: Search, bad: Indices) -> None:
    """Check all states of some of the nodes whose choice collides, and suspect those that are alike at the others."""
    ladder, known, first = search.ladder, search.known, search.ladder.first
    sizes = np.diff(first)[bad]
    stride = max(1, int(np.ceil(sizes.sum() / _MOST_AT_ONCE)))
    seen = bad[::stride]
    members = np.concatenate([np.arange(*first[node : node + 2]) for node in seen.tolist()])
    _check_states(search, members[known.verdict[members] == UNKNOWN])
    if stride == 1:
        return
    width = int(ladder.label.max()) + 1
    hits = members[known.verdict[members] == HITS]
    nearest = seen[np.minimum(np.arange(len(bad)) // stride, len(seen) - 1)]
    others = np.concatenate([np.arange(*first[node : node + 2]) for node in bad.tolist()])
    model = np.repeat(nearest, sizes)
    known.suspect[others] |= np.isin(
        model * width + ladder.label[others], ladder.node[hits] * width + ladder.label[hits]
    )


def _with_tilts(queries: CellQueries, path: SampledPath, nodes: Nodes, where: Indices, tilt: float) -> Ladder:
    """Solve tilted poses too at some nodes: within the band while spraying, further while the jet is off."""
    jet_on = path.jet_on[nodes.sample]
    tilts = np.isin(np.arange(len(jet_on)), where) & (~jet_on | (tilt > 0.0))
    fewer = replace(nodes, azimuths=np.minimum(nodes.azimuths, _TILTED_AZIMUTHS))

    def poses_of(some: Indices) -> NodePoses:
        parts = [
            node_poses(nodes, some[~tilts[some]], STRAIGHT),
            node_poses(fewer, some[(tilts & ~jet_on)[some]], _fan(_TRANSFER_TILTS)),
            node_poses(fewer, some[(tilts & jet_on)[some]], _fan(np.array([0.5 * tilt, tilt]))),
        ]
        order = np.argsort(np.concatenate([part.node for part in parts]), kind="stable")
        fields = (np.concatenate([getattr(part, name) for part in parts]) for name in NodePoses.__slots__)
        return NodePoses(*(field[order] for field in fields))

    requested = (poses_of(some) for some in node_pieces(nodes))
    return solve_states(queries, path, nodes, requested)


def _fan(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give no tilt, and each angle in eight directions."""
    turns = np.radians(np.arange(0.0, 360.0, 45.0))
    return np.concatenate([STRAIGHT, *(angle * np.column_stack((np.cos(turns), np.sin(turns))) for angle in angles)])


def _close_repeats(search: Search, choice: Choice) -> bool:
    """Let each repeated part end in the configuration in which it begins; return whether anything had to be changed."""
    changed = False
    ladder, path = search.ladder, search.path
    for begin, end in search.queries.repeats(path):
        first, last = (int(np.searchsorted(search.nodes.sample, at, side="right")) - 1 for at in (begin, end))
        search.fixed_azimuth[[first, last]] = True
        low, high = ladder.first[last : last + 2]
        alike = np.abs(ladder.q[low:high] - ladder.q[choice.state[first]]).max(axis=1) < 1e-6
        same = np.abs(path.T_base_tcp[begin] - path.T_base_tcp[end]).max() < 1e-6
        if same and alike.any():
            search.known.excluded[low:high] = ~alike
            changed |= not alike[choice.state[last] - low]
            others = np.arange(*ladder.first[first : first + 2])
            search.known.excluded[others] = others != choice.state[first]
    return changed


def _note_flaws(search: Search, choice: Choice, motion: Motion) -> bool:
    """Note what is wrong with an attempt for the next search; return whether there was anything that it may mend."""
    first, verdict = search.ladder.first, search.known.verdict
    hit = np.flatnonzero(verdict[choice.state] == HITS).tolist() if len(motion.hits) else []
    if any(bool(np.all(verdict[first[node] : first[node + 1]] == HITS)) for node in hit):
        return False  # no other choice can be clear there
    noted = _blame(search, choice, motion, forbid_pairs=True)
    noted |= _blame(search, choice, motion, forbid_pairs=False)
    for node in motion.blocked.tolist():
        search.refused[node] = search.refused.get(node, 0) + 1
        pair = (int(choice.state[node]), int(choice.state[node + 1]))
        if not motion.tracked.path.changed[motion.nodes.sample[node + 1]] and pair not in search.forbidden:
            search.forbidden.append(pair)
            noted = True
    return noted


def _blame(search: Search, choice: Choice, motion: Motion, *, forbid_pairs: bool) -> bool:
    """Fix the azimuths around lost or colliding samples; where they are fixed, forbid the pairs or states there.

    Where the jet is off, what was lost is left to a joint move: a jet that passes close by an axis of its wrist needs
    half a turn of that at once. With a state are forbidden those of its node whose arm stands alike, whatever the last
    joint does.
    """
    wrong, count = motion.lost if forbid_pairs else motion.hits, len(motion.nodes.sample)
    node = np.unique(np.searchsorted(motion.nodes.sample, wrong, side="right") - 1)
    node = node[~np.append(choice.discontinuities, False)[node]]
    around = np.stack((node, np.minimum(node + 1, count - 1)), axis=1)
    around = around[~(search.known.verdict[choice.state] == HITS)[around].any(axis=1)]
    if len(around) == 0:
        return False
    fixed = search.fixed_azimuth[around].all(axis=1)
    search.fixed_azimuth |= widened(np.isin(np.arange(count), around[~fixed]), 3)
    states = choice.state[around[fixed]]
    if forbid_pairs:
        jet_off = ~search.path.jet_on[search.nodes.sample[around[fixed]]].any(axis=1)
        search.by_joints |= set(around[fixed][jet_off, 0].tolist())
        states = states[~jet_off]
        pairs = [(int(a), int(b)) for a, b in states.tolist()]
        search.forbidden += [pair for pair in pairs if pair not in search.forbidden]
        return True
    ladder = search.ladder
    for state in np.unique(states).tolist():
        low, high = ladder.first[search.ladder.node[state] : search.ladder.node[state] + 2]
        off = np.abs(ladder.q[low:high] - ladder.q[state])[:, :-1].max(axis=1)
        search.known.verdict[low + np.flatnonzero(off < _ALIKE)] = HITS
    return True
