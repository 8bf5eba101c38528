"""A track attempt: from the chosen configurations at the nodes to the joints at every sample, and its flaws."""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from programs.motion.tracks import LARGEST_TURN_RAD
from robotcell.motion.cell_queries import CellQueries, Reconfiguration, find_move
from robotcell.motion.even_turns import EvenLines, turn_evenly
from robotcell.motion.ladder_graph import Nodes, joint_speeds, solve_by_tool, tilted
from robotcell.motion.ladder_search import Choice, Ladder
from robotcell.motion.sampled_path import Flags, SampledPath, TrackedPath, refine_path, turns_between, turns_within
from robotcell.robot.robot import TURN, Joints, Poses, Robot, nearest_turns, row_pieces

_SMOOTHING_S = 0.5
"""Turns about the jet are spread over about twice this time."""
_FIXED_WEIGHT = 1e6
"""Weight of a fixed azimuth against smoothness."""
_SWEEP_WEIGHT = 100.0
"""s/rad^2. On a line on which the jet turns by b and the tool by a about it the jet is up to a b / 8 off."""
_SMOOTH_ROUNDS = 4
_TURNED_RAD = 1e-7
"""A line that turns by less does not turn."""
_MM = 1e3
_WIDEST = 0.12
"""rad that a joint may turn from sample to sample; else more samples are taken."""
_MOST_PARTS = 40

UNKNOWN, CLEAR, HITS = 0, 1, 2


@dataclass(frozen=True, slots=True, eq=False)
class Knowledge:
    """Collision verdicts on m states; they grow while the search goes on."""

    verdict: NDArray[np.int8]
    """(m,) UNKNOWN, CLEAR or HITS"""
    suspect: Flags
    """(m,) whether a state of a neighbouring node that is alike collides."""
    excluded: Flags
    """(m,) whether it must not be chosen for another reason, if there is a choice."""


def nothing_known(states: int) -> Knowledge:
    """Give the verdicts of states that were not looked at yet."""
    return Knowledge(np.zeros(states, dtype=np.int8), *np.zeros((2, states), dtype=np.bool_))


@dataclass(slots=True, eq=False)
class Search:
    """The state of the search."""

    queries: CellQueries
    path: SampledPath
    nodes: Nodes
    ladder: Ladder
    known: Knowledge
    fixed_azimuth: Flags
    """(nodes,) whether the azimuth is left out of smoothing."""
    tilted: Indices
    """(k,) nodes whose states have tilted jets too."""
    even: EvenLines
    """Lines along which the turning axes go evenly."""
    multi_turn: list[int] = field(default_factory=list[int])
    """Joints whose whole turns are states of their own."""
    forbidden: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])
    """Pairs of states that must not follow each other."""
    by_joints: set[int] = field(default_factory=set[int])
    """Nodes with the jet off after which the joints move freely: along the path they would turn at once."""
    anywhere: bool = False
    """Whether the configuration may change all along the highest part of a stretch with the jet off."""
    refused: dict[int, int] = field(default_factory=dict[int, int])
    """How often no way was found for a reconfiguration move after a node."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """The motion of an attempt, and what is wrong with it."""

    nodes: Nodes
    tracked: TrackedPath
    reconfigurations: tuple[Reconfiguration, ...]
    hits: Indices
    """Samples at which something collides whatever was chosen."""
    lost: Indices
    """Samples at which no configuration continues the one before."""
    discontinuities: Indices
    """Nodes after which the configuration would have to change while the jet is on."""
    blocked: Indices
    """Nodes after which a joint move is needed, and every way that was tried collides."""

    @property
    def flaws(self) -> int:
        """How many there are."""
        return sum(len(each) for each in (self.hits, self.lost, self.discontinuities, self.blocked))

    @property
    def broken(self) -> Indices:
        """Samples at which the motion is not one."""
        return np.concatenate((self.nodes.sample[self.discontinuities], self.nodes.sample[self.blocked], self.lost))


@dataclass(frozen=True, slots=True, eq=False)
class NodeTargets:
    """Configurations at k nodes, with the azimuths made smooth."""

    sample: Indices
    """(k,) the first of each node"""
    until: Indices
    """(k,) the last of each node: the TCP dwells till then"""
    q: Joints
    """(k, dof)"""
    azimuth: Scalars
    """(k,) rad, going on from node to node"""
    tilt: NDArray[np.float64]
    """(k, 2) rad"""
    reconfigurations: Flags
    """(k - 1,)"""


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """The straight lines of a path between its corners, of which there are k; the tool turns evenly along each."""

    corner: Indices
    """(k,) samples"""
    before: Indices
    """(n,) of each sample the corner that it is, or follows; not the last one"""
    share: Scalars
    """(n,) of the way to the next corner"""
    turns: Scalars
    """(n - 1,) rad that the programmed pose turns from each sample to the next"""

    def along(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Give values at the n samples that change evenly between those (k, ...) at the corners."""
        share = self.share.reshape(-1, *[1] * (values.ndim - 1))
        after = np.minimum(self.before + 1, len(self.corner) - 1)
        return values[self.before] + share * (values[after] - values[self.before])


@dataclass(frozen=True, slots=True, eq=False)
class HeldTool:
    """How the tool is held along a path, from the azimuth and the direction of the jet that are programmed."""

    edges: Edges
    corners: tuple[Scalars, NDArray[np.float64]]
    """(k,) rad about the jet at the corners, going on from one to the next, and (k, 2) rad of tilt."""
    T_base_tcp: Poses
    """(n, 4, 4) at the n samples"""
    azimuth: Scalars
    """(n,) rad"""
    tilt: NDArray[np.float64]
    """(n, 2) rad"""


def attempt_motion(search: Search, choice: Choice) -> Motion:
    """Track a choice at every sample, and look for what is wrong with it."""
    nodes, tracked = _track_choice(search, choice)
    queries, path = search.queries, tracked.path
    moves: list[Reconfiguration] = []
    blocked: list[int] = []
    for node in np.flatnonzero(choice.reconfigurations & ~choice.discontinuities).tolist():
        begin, end = int(nodes.until[node]), int(nodes.sample[node + 1])
        before, after = ((int(path.tool[at]), int(path.placement[at])) for at in (begin, end))
        safe_m = [queries.below_safe(path, at) if before[0] != after[0] else 0.0 for at in (begin, end)]
        ends = [queries.lifting(tracked, at, safe) for at, safe in zip((begin, end), safe_m, strict=True)]
        found = find_move(queries, ends[0], ends[1], before, after)
        if found is None:  # every way collides
            blocked.append(node)
        else:
            moves.append(Reconfiguration(begin, end, *found))
    lost = tracked.lost | np.append(_joint_turns(queries.cell.robot, tracked) > 2.0 * _WIDEST, False)
    hits = queries.collide(tracked.q, path.tool, path.placement)
    expected = search.known.verdict[choice.state] == HITS
    if not lost.any() and not (hits.any() and not expected.any()):
        same = np.flatnonzero(np.diff(tracked.piece) == 0)
        hits[same] |= queries.collide_between(tracked.q, path.tool, path.placement, same)
    return Motion(
        nodes=nodes,
        tracked=tracked,
        reconfigurations=tuple(moves),
        hits=np.flatnonzero(hits),
        lost=np.flatnonzero(lost),
        discontinuities=np.flatnonzero(choice.discontinuities),
        blocked=np.array(blocked, dtype=np.int64),
    )


def _track_choice(search: Search, choice: Choice) -> tuple[Nodes, TrackedPath]:
    """Give the joints at every sample, taking more samples where the joints turn far between two.

    The azimuth changes evenly along each straight line of the path, but for nodes at which the branch would be lost.
    """
    queries, path, nodes = search.queries, search.path, search.nodes
    robot, fixed, even = queries.cell.robot, search.fixed_azimuth.copy(), search.even
    raw = chosen_configurations(robot, search.ladder, choice, nodes, joint_speeds(robot, search.multi_turn).wraps)
    rounds = 0
    while True:
        held = smooth(raw, path, fixed, even)
        # The nodes anew with the tool held so, next to the chosen configurations.
        q, lost = _nearest_branch(queries, held.T_base_tcp[raw.sample], path.tool[raw.sample], raw.q)
        lost |= np.max(np.abs(q - raw.q) * robot.turning, axis=1, initial=0.0) > np.radians(40.0)
        targets = replace(raw, q=np.where(lost[:, None], raw.q, q))
        if not lost.any() or rounds == _SMOOTH_ROUNDS:
            break
        fixed |= widened(lost, 3)
        rounds += 1
    tracked = turn_evenly(queries.cell, track_path(queries, targets, held, path), even)
    wide = _joint_turns(robot, tracked)
    for node in np.flatnonzero(choice.discontinuities).tolist():
        wide[nodes.until[node] : nodes.sample[node + 1]] = 0.0
    if wide.max(initial=0.0) > _WIDEST:
        parts = np.clip(np.ceil(wide / _WIDEST), 1, _MOST_PARTS).astype(np.int64)
        path, place = refine_path(path, parts)
        nodes = replace(nodes, sample=place[nodes.sample], until=place[nodes.until])
        targets = replace(targets, sample=nodes.sample, until=nodes.until)
        held = hold_tool(straight_edges(path, place[held.edges.corner]), *held.corners, path)
        tracked = track_path(queries, targets, held, path)
        tracked = turn_evenly(queries.cell, tracked, even.at(place))
    return nodes, tracked


def _joint_turns(robot: Robot, tracked: TrackedPath) -> NDArray[np.float64]:
    """Give how far a joint turns in each interval (n - 1,) that is tracked, rad."""
    far = np.max(np.abs(np.diff(tracked.q, axis=0)), axis=1, where=robot.turning, initial=0.0)
    return np.where(np.diff(tracked.piece) == 0, far, 0.0)


def widened(flags: Flags, by: int) -> Flags:
    """Set what is no farther from something set than so many places."""
    return np.convolve(flags.astype(np.int64), np.ones(2 * by + 1, dtype=np.int64))[by : by + len(flags)] > 0


def chosen_configurations(robot: Robot, ladder: Ladder, choice: Choice, nodes: Nodes, wraps: Flags) -> NodeTargets:
    """Give the configurations of a choice.

    Joints that wrap (dof,) go on past whole turns from one reconfiguration to the next, and begin each such piece where
    it stays within the limits, of several whole turns with the one next to where the joint comes from.
    """
    azimuth = ladder.azimuth[choice.state]
    steps = np.diff(azimuth)
    steps -= TURN * np.round(steps / TURN - 1e-9)
    q = ladder.q[choice.state]
    unwrapped, before = q.copy(), robot.middle[wraps]
    for a, b in pairwise([0, *(np.flatnonzero(choice.reconfigurations) + 1).tolist(), len(q)]):
        going = np.unwrap(q[a:b, wraps], axis=0)
        least = np.ceil((robot.lowest[wraps] - going.min(axis=0)) / TURN - 1e-9)
        most = np.floor((robot.highest[wraps] - going.max(axis=0)) / TURN + 1e-9)
        near = np.round((before - going[0]) / TURN - 1e-9)
        unwrapped[a:b, wraps] = going + TURN * np.where(least <= most, np.clip(near, least, most), near)
        before = unwrapped[b - 1, wraps]
    return NodeTargets(
        sample=nodes.sample,
        until=nodes.until,
        q=unwrapped,
        azimuth=np.concatenate((azimuth[:1], azimuth[0] + np.cumsum(steps))),
        tilt=ladder.tilt[choice.state],
        reconfigurations=choice.reconfigurations,
    )


def straight_edges(path: SampledPath, corner: Indices) -> Edges:
    """Give the lines between corners (k,), the first sample and the last among them."""
    way = np.linalg.norm(np.diff(path.T_base_tcp[:, :3, 3], axis=0), axis=1) * _MM
    turns = turns_between(path.T_base_tcp)
    passed = np.concatenate(([0.0], np.cumsum(np.hypot(way, np.degrees(turns)))))
    before = np.clip(np.searchsorted(corner, np.arange(len(passed)), side="right") - 1, 0, max(len(corner) - 2, 0))
    begin, end = passed[corner[before]], passed[corner[np.minimum(before + 1, len(corner) - 1)]]
    share = np.where(end > begin, (passed - begin) / np.where(end > begin, end - begin, 1.0), 0.0)
    share[corner[-1]] = 1.0
    return Edges(corner, before, share, turns)


def smooth(targets: NodeTargets, path: SampledPath, fixed: Flags, even: EvenLines) -> HeldTool:
    """Spread the turns about the jet over time where the azimuth is free, evenly along each straight line.

    Minimises the integral of (a - chosen)^2 + T^2 (da/dt)^2 over the azimuths a at the corners, a tridiagonal system.
    Nothing crosses a reconfiguration, or a line on which the axes go evenly; the tool does not turn about its jet while
    it dwells, and hardly on lines on which the jet turns far.

    Args:
        targets: The chosen configurations.
        path: The path.
        fixed: (k,) nodes that keep the azimuth that was chosen; they become corners.
        even: Lines along which the turning axes go evenly.
    """
    from scipy.linalg import solveh_banded

    sample, until = targets.sample, targets.until
    tilts = np.any(np.diff(targets.tilt, axis=0) != 0.0, axis=1)
    bends = (fixed & path.free[sample]) | np.append(tilts, False) | np.append(False, tilts)
    reconfigures = np.flatnonzero(targets.reconfigurations)
    apart = np.concatenate((until[reconfigures], even.first))
    held = np.concatenate((sample[bends], until[bends], apart, sample[reconfigures + 1], even.last))
    edges = straight_edges(path, np.union1d(np.flatnonzero(path.corner), held))
    corner = edges.corner
    if len(corner) == 1:
        return hold_tool(edges, targets.azimuth, targets.tilt, path)
    gaps = np.maximum(path.times[sample[1:]] - path.times[until[:-1]], 1e-3)
    weight = np.maximum(0.5 * (np.append(gaps, 0.0) + np.append(0.0, gaps)), 5e-4)
    weight = np.where(fixed, weight * _FIXED_WEIGHT + _FIXED_WEIGHT, weight)
    stiff = _SMOOTHING_S**2 / np.maximum(np.diff(path.times[corner]), 1e-3)
    sweeps = np.bincount(edges.before[1:], edges.turns * path.jet_on[1:], minlength=len(stiff))
    rests = path.dwelling[corner[:-1]]
    stiff = np.where(rests, _FIXED_WEIGHT, stiff + _SWEEP_WEIGHT * sweeps**2)
    stiff[np.searchsorted(corner, apart)] = 0.0
    band, right = np.zeros((2, len(corner))), np.zeros(len(corner))
    band[0, 1:] = -stiff
    band[1, :-1] += stiff
    band[1, 1:] += stiff
    begin, share = edges.before[sample], edges.share[sample]
    for at, part in ((begin, 1.0 - share), (begin + 1, share)):
        np.add.at(band[1], at, weight * part * part)
        np.add.at(right, at, weight * part * targets.azimuth)
    np.add.at(band[0], begin + 1, weight * share * (1.0 - share))
    azimuth = np.asarray(solveh_banded(band, right))
    for at in np.flatnonzero(rests).tolist():
        azimuth[at + 1] = azimuth[at]
    node = np.searchsorted(sample, corner, side="right") - 1
    ends = np.column_stack((sample, until)).ravel()  # a rest is one node, with one tilt
    tilts_at = np.repeat(targets.tilt, 2, axis=0)
    tilt = np.stack([np.interp(path.times[corner], path.times[ends], column) for column in tilts_at.T], axis=1)
    tilt = np.where(path.dwelling[corner, None], targets.tilt[node], tilt)
    return hold_tool(edges, azimuth, tilt, path)


def hold_tool(edges: Edges, turned: Scalars, leaning: NDArray[np.float64], path: SampledPath) -> HeldTool:
    """Give how the tool is held at every sample of a path.

    Where the tool turns about its jet, or tilts, while the path itself turns, it turns evenly all in all, as a
    controller does it.

    Args:
        edges: The lines between corners.
        turned: (k,) rad about the jet at the corners.
        leaning: (k, 2) rad, the tilt there.
        path: The path.
    """
    azimuth, tilt = edges.along(turned), edges.along(leaning)
    azimuth = np.where(path.free, azimuth, 0.0)
    poses = tilted(path.T_base_tcp, azimuth, tilt)
    held = HeldTool(edges, (turned, leaning), poses, azimuth, tilt)
    if len(edges.corner) < 2:
        return held
    turns = np.bincount(edges.before[1:], edges.turns, minlength=len(edges.corner) - 1)
    leans = np.any(np.abs(np.diff(leaning, axis=0)) > 1e-12, axis=1)
    mixed = ((np.abs(np.diff(turned)) > 1e-12) & (turns > _TURNED_RAD)) | leans
    far = (turns_between(poses[edges.corner]) > LARGEST_TURN_RAD) | (np.abs(np.diff(turned)) > np.pi)
    inner = np.flatnonzero((mixed & ~far)[edges.before] & (edges.share > 0.0) & (edges.share < 1.0))
    for rows in row_pieces(len(inner)):
        some = inner[rows]
        begin, end = (edges.corner[edges.before[some] + after] for after in (0, 1))
        poses[some, :3, :3] = turns_within(poses, begin, end, edges.share[some])
    return held


def track_path(queries: CellQueries, targets: NodeTargets, held: HeldTool, path: SampledPath) -> TrackedPath:
    """Give the joints at every sample, nearest to what lies between the nodes' configurations."""
    number = np.arange(len(path.times))
    before = np.searchsorted(targets.sample, number, side="right") - 1
    after = np.minimum(before + 1, len(targets.sample) - 1)
    begin, end = path.times[targets.until[before]], path.times[targets.sample[after]]
    inner = (number > targets.until[before]) & (end > begin)
    share = np.where(inner, (path.times - begin) / np.where(end > begin, end - begin, 1.0), 0.0)
    skipped = inner & np.append(targets.reconfigurations, False)[before]
    share[skipped] = 0.0
    reference = targets.q[before] + share[:, None] * (targets.q[after] - targets.q[before])
    poses, azimuth, tilt = held.T_base_tcp.copy(), held.azimuth.copy(), held.tilt.copy()
    rest = targets.until[before[skipped]]
    poses[skipped], azimuth[skipped], tilt[skipped] = poses[rest], azimuth[rest], tilt[rest]
    q, lost = _nearest_branch(queries, poses, path.tool, reference)
    q[skipped] = targets.q[before][skipped]
    begins = np.zeros(len(number), dtype=np.int64)
    begins[targets.sample[1:][targets.reconfigurations]] = 1
    corner = np.zeros(len(number), dtype=np.bool_)
    corner[held.edges.corner] = True
    piece, share = np.cumsum(begins), np.full(len(q), np.nan)
    return TrackedPath(replace(path, corner=corner), q, poses, azimuth, tilt, piece, lost & ~skipped, share)


def _nearest_branch(queries: CellQueries, poses: Poses, tool: Indices, reference: Joints) -> tuple[Joints, Flags]:
    """Solve poses (k, 4, 4); give the branch next to a reference row, and where there is none within the limits."""
    q, lost = reference.copy(), np.zeros(len(poses), dtype=np.bool_)
    for rows in row_pieces(len(poses)):
        found, _ = solve_by_tool(queries, poses[rows], tool[rows])
        fitted = nearest_turns(queries.cell.robot, found, reference[rows, None])
        far = np.max(np.abs(fitted - reference[rows, None]), axis=2)
        far = np.where(np.isfinite(far), far, np.inf)
        row = np.arange(len(far))
        best = np.argmin(np.round(far, 9), axis=1)
        lost[rows] = ~np.isfinite(far[row, best])
        q[rows] = np.where(lost[rows, None], reference[rows], fitted[row, best])
    return q, lost
