"""Why a robot cannot carry out a program, or not as programmed: where, and caused by what.

Cheap rules come before the search for a motion; each is necessary for any motion:

1. No body of the base lies inside a fixture: bodies are solid, and the base never moves.
2. Every pose that sprays is reached by a configuration within the joints' limits: the search takes its configurations
   from the same azimuths, and does not tilt the jet where it sprays but is out of reach.
3. Every pose that sprays is clear in one of its configurations, at twice as many azimuths as the search tries. This one
   is left out where the jet may be tilted while it sprays.
4. The place at which the tool is changed is clear with the tool before and the one after: every way leads there.

The second and the third look at some poses of the path, the outermost and those next to fixtures; what they do not see
the search finds.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import corners_of
from robotcell.collision.collision import fixtures_through_base
from robotcell.motion.cell_queries import CellQueries
from robotcell.motion.ladder_graph import AZIMUTHS, STRAIGHT, Nodes, choose_nodes, node_poses, solve_states, tilted
from robotcell.motion.ladder_search import Ladder
from robotcell.motion.retime import Retiming
from robotcell.motion.sampled_path import SampledPath, TrackedPath
from robotcell.motion.track_attempt import Motion
from robotcell.placement.reachability import spread_samples
from robotcell.robot.robot import TURN, Poses, is_inside
from specs.finding import Finding, FindingRule, Severity
from specs.finding_rules import (
    COLLISION,
    CONFIGURATION_JUMP,
    FIXTURE_IN_BASE,
    JET_TILTED,
    JOINT_LIMIT,
    JUMP,
    NEAR_SINGULAR,
    OUT_OF_REACH,
    SPEED_NOT_HELD,
    TRANSFER_BLOCKED,
)
from specs.source import Source

_SLOW = 0.98
_LATE_S = 0.05
"""Least delay over all that one recipe entry causes for a finding."""
_SLOWEST_M_S = 5e-4
"""Slower than this the nozzle only turns on the spot: it sprays longer there, not elsewhere."""
_LEAST_TURN, _EVEN_TURN = np.radians(0.1), np.radians(12.0)
"""Tilts that are none: of a line, and where a gantry turns on the spot with its axes going evenly."""
_NEAR_SINGULAR = 0.02
_FAR_M = np.array([0.005, 0.01, 0.02, 0.03, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8, 1.2, 2.0, 5.0])
_TILTS_DEG = (5.0, 10.0, 15.0, 20.0, 30.0, 40.0)
DEEP_M = 0.02
"""m that a fixture may reach into the robot's base: models are no more exact than this."""
_MOST_NODES = 48
_NEAREST = 3
"""Poses that are looked at next to each fixture, besides."""
_MOST_REPORTED = 600
"""Poses that are looked at once one of them is out of reach."""
_FEW_AZIMUTHS = 6
"""Collisions are checked at these first: most poses are clear at one of them."""
_MOST_IN_DOUBT = 8
"""Poses that collide at all of these, and are looked at again."""
_MOST_PAIRS = 24
"""Configurations of a pose of which the first pair of bodies that collides is looked for."""


@dataclass(frozen=True, slots=True, eq=False)
class PathInCell:
    """The subject of findings: a path, and queries to the cell."""

    queries: CellQueries
    path: SampledPath

    def made_by(self, sample: int) -> Source:
        """Give the recipe path that a sample comes from."""
        return self.queries.program.instructions[int(self.path.instruction[sample])].made_by

    def finding(self, rule: FindingRule, message: str, sample: int, severity: Severity | None = None) -> Finding:
        """Give a finding at a sample: with its recipe path, and its place in the board frame, mm."""
        T_base_board = self.path.T_base_board[int(self.path.placement[sample])]
        point = np.linalg.inv(T_base_board) @ self.path.T_base_tcp[sample, :, 3]
        x, y, z = (np.round(point[:3] * 1e3, 3) + 0.0).tolist()
        return Finding(rule, message, self.made_by(sample), (x, y, z), severity)

    def grouped(self, samples: Indices) -> Iterator[Indices]:
        """Group samples by the recipe path they come from, in order of their first."""
        groups: dict[Source, list[int]] = {}
        for sample in samples.tolist():
            groups.setdefault(self.made_by(sample), []).append(sample)
        for members in groups.values():
            yield np.array(members, dtype=np.int64)

    def configurations(self, sample: int, poses: Poses) -> NDArray[np.float64]:
        """Give the joints (k, azimuths * b, dof) of poses (k, 4, 4) at every azimuth that a sample allows."""
        count = AZIMUTHS if self.path.free[sample] else 1
        azimuth = np.tile(TURN * np.arange(count) / AZIMUTHS, len(poses))
        turned = tilted(np.repeat(poses, count, axis=0), azimuth, np.zeros((len(azimuth), 2)))
        found, _ = self.queries.configurations(turned, int(self.path.tool[sample]))
        return found.reshape(len(poses), -1, found.shape[2])


def unreachable(subject: PathInCell, samples: Indices) -> Iterator[Finding]:
    """Report poses that no configuration reaches, and what keeps the robot from them."""
    robot = subject.queries.cell.robot
    for members in subject.grouped(samples):
        worst = int(members[len(members) // 2])
        rows = subject.configurations(worst, subject.path.T_base_tcp[worst][None])[0]
        rows = rows[np.isfinite(rows[:, 0])]
        rule, text = OUT_OF_REACH, "out of the robot's reach"
        if len(rows):  # the configuration in which the joint that is farthest beyond its limit is least so
            turned = rows + np.array([-2.0, -1.0, 0.0, 1.0, 2.0])[:, None, None] * TURN * robot.turning
            over = np.min(np.maximum(np.maximum(robot.lowest - turned, turned - robot.highest), 0.0), axis=0)
            over = over[int(np.argmin(np.round(over.max(axis=1), 9)))]
            joint = robot.joints[int(np.argmax(over))]
            excess = f"{joint.unit.per_si * over.max():.1f} {joint.unit.word}"
            rule, text = JOINT_LIMIT, f"reached only beyond a joint's limit: {joint.name} by {excess}"
        count = f"{len(members)} points, such as this, are" if len(members) > 1 else "this point is"
        yield subject.finding(rule, f"{count} {text}; {_what_reaches(subject, worst)}.", worst)


def _what_reaches(subject: PathInCell, sample: int) -> str:
    """Describe the smallest shift, and the smallest tilt, by which a pose would be reached."""
    pose = subject.path.T_base_tcp[sample]
    flat = np.array([pose[0, 3], pose[1, 3], 0.0])
    inward = -flat / max(float(np.linalg.norm(flat)), 1e-9)
    up = np.linalg.inv(subject.queries.cell.T_cell_base)[:3, 2]
    axis = "the robot's axis"
    ways = ((inward, f"nearer to {axis}"), (-inward, f"farther from {axis}"), (up, "higher"), (-up, "lower"))
    tried = np.tile(pose, (len(ways), len(_FAR_M), 1, 1))
    for number, (way, _) in enumerate(ways):
        tried[number, :, :3, 3] += _FAR_M[:, None] * way
    turns = np.tile(np.radians(np.arange(0.0, 360.0, 45.0)), len(_TILTS_DEG))
    size = np.repeat(np.radians(_TILTS_DEG), len(turns) // len(_TILTS_DEG))
    tilts = size[:, None] * np.column_stack((np.cos(turns), np.sin(turns)))
    leaning = tilted(np.repeat(pose[None], len(turns), axis=0), 0.0 * turns, tilts)
    found = subject.configurations(sample, np.concatenate((tried.reshape(-1, 4, 4), leaning)))
    every = np.any(is_inside(subject.queries.cell.robot, found), axis=1)
    shifted, leaned = np.split(every, [len(ways) * len(_FAR_M)])
    shifts = [
        (float(_FAR_M[np.argmax(reached)]), text)
        for (_, text), reached in zip(ways, shifted.reshape(len(ways), -1), strict=True)
        if reached.any()
    ]
    helps = [f"{far * 1e3:g} mm {text}" for far, text in sorted(shifts, key=lambda shift: shift[0])[:1]]
    for degrees, reached in zip(_TILTS_DEG, leaned.reshape(len(_TILTS_DEG), -1), strict=True):
        if reached.any():
            helps.append(f"with the jet tilted by {degrees:g} degrees more or less")
            break
    if not helps:
        return "no shift up to 5 m and no tilt helps: check the frames"
    return f"it would be reached {', or '.join(helps)}"


def collisions(subject: PathInCell, motion: Motion) -> Iterator[Finding]:
    """Report the pairs that collide in every configuration, once for each pair and recipe path.

    A hit is at a sample, or on the way from there to the next.
    """
    seen: dict[tuple[Source, str, str], list[int]] = {}
    path, rows = subject.path, motion.tracked.q
    for sample in motion.hits.tolist():
        at = int(path.tool[sample]), int(path.placement[sample])
        touch = subject.queries.first_touch(rows[sample], *at)
        if touch is None and sample + 1 < len(rows):
            touch = subject.queries.touch_between(rows[sample], rows[sample + 1], *at)
        if touch is not None:
            seen.setdefault((subject.made_by(sample), touch.body, touch.other), []).append(sample)
    for (_, body, other), samples in seen.items():
        text = f"{body} collides with {other} at {len(samples)} of the points checked, in every configuration."
        yield subject.finding(COLLISION, text, samples[0])


def breaks(subject: PathInCell, motion: Motion) -> Iterator[Finding]:
    """Report where the path cannot be tracked in one go."""
    jump = (
        "the robot would have to change its configuration here while the jet is on: no configuration before this place "
        "continues into one after it. Move or turn the board, let the stroke end here, or raise hose_turns if a joint "
        "winds up and its hose allows it."
    )
    blocked = (
        "the robot has to change its configuration or its tool here, and every way that was tried, straight and by way "
        "of home, collides. Choose another home, or another place for the board."
    )
    for rule, text, nodes in (
        (CONFIGURATION_JUMP, jump, motion.discontinuities),
        (TRANSFER_BLOCKED, blocked, motion.blocked),
    ):
        for sample in motion.nodes.sample[nodes].tolist():
            yield subject.finding(rule, text, sample)
    for members in subject.grouped(motion.lost):
        text = f"no configuration continues the one before at {_points(len(members))}, within the joints' limits."
        yield subject.finding(JUMP, text, int(members[0]))


def slowness(subject: PathInCell, retiming: Retiming) -> Iterator[Finding]:
    """Report where the robot sprays more slowly than programmed, once for each recipe path."""
    path = subject.path
    length = np.linalg.norm(np.diff(path.T_base_tcp[:, :3, 3], axis=0), axis=1)
    lasting = np.diff(path.times)
    spraying = path.jet_on[1:] & path.jet_on[:-1] & (lasting > 1e-6)
    slow = np.flatnonzero(spraying & (retiming.share < _SLOW)) + 1
    for members in subject.grouped(slow):
        interval = members - 1
        late = retiming.lasting[interval] - lasting[interval]
        if late.sum() < _LATE_S:
            continue
        moving = interval[length[interval] > _SLOWEST_M_S * lasting[interval]]
        candidates = moving if len(moving) else interval
        worst = int(candidates[np.argmin(np.round(retiming.share[candidates], 6))])
        joint = subject.queries.cell.robot.joints[int(retiming.joint[worst])].name
        limit = "greatest speed" if retiming.by_speed[worst] else "greatest acceleration"
        programmed, share = length[worst] / lasting[worst] * 1e3, retiming.share[worst]
        speeds = f"turning at {share:.0%} of the programmed rate"
        if len(moving):
            speeds = f"{programmed * share:.1f} instead of {programmed:.1f} mm/s"
        text = (
            f"the robot takes {late.sum():.2f} s longer than programmed; slowest here, {speeds}: {joint} is at its "
            f"{limit}."
        )
        yield subject.finding(SPEED_NOT_HELD, text, worst, "warning" if len(moving) else "info")


def tilts(subject: PathInCell, tracked: TrackedPath) -> Iterator[Finding]:
    """Report where the jet is tilted from the programmed direction."""
    tilt = np.linalg.norm(tracked.tilt, axis=1)
    least = np.where(np.isfinite(tracked.share), _EVEN_TURN, _LEAST_TURN)
    for members in subject.grouped(np.flatnonzero((tilt > least) & subject.path.jet_on)):
        worst = int(members[np.argmax(tilt[members])])
        text = (
            f"the jet is tilted by up to {np.degrees(tilt[worst]):.1f} degrees from the programmed direction: nothing "
            "else is clear, or the hose would wind up."
        )
        yield subject.finding(JET_TILTED, text, worst)


def nearly_singular(subject: PathInCell, condition: Scalars) -> Iterator[Finding]:
    """Report where the robot sprays near a singular configuration."""
    for members in subject.grouped(np.flatnonzero(subject.path.jet_on & (condition < _NEAR_SINGULAR))):
        worst = int(members[np.argmin(condition[members])])
        text = (
            f"near a singular configuration at {_points(len(members))}, inverse condition {condition[worst]:.4f} at "
            "the worst: the joints move far for a short way. Move or turn the board."
        )
        yield subject.finding(NEAR_SINGULAR, text, worst)


def _points(count: int) -> str:
    return f"{count} point" if count == 1 else f"{count} points"


@dataclass(frozen=True, slots=True, eq=False)
class Refusal:
    """Why no motion can exist."""

    findings: tuple[Finding, ...]
    nodes: Indices
    """Samples of the path at which the search chooses configurations."""
    wrong: Indices
    """Those that are not reached, or not clear; none where no other place of anything would help."""
    through_base: tuple[str, ...] = ()
    """Fixtures that reach into the robot's base."""


def find_refusal(subject: PathInCell, tilt: float) -> Refusal | None:
    """Apply the cheap rules one after the other; ``None`` where none refuses the cell.

    Args:
        subject: The path in its cell.
        tilt: rad that the jet may be tilted while it sprays.
    """
    nodes = choose_nodes(subject.path, subject.queries.cell.robot.dof)
    own = np.flatnonzero(subject.path.jet_on[nodes.sample])
    if not len(own):
        return None
    through = fixtures_through_base(subject.queries.colliders[0], DEEP_M)
    if through:
        message = (
            "{0} reaches more than {1:g} mm into the robot's base: no robot can stand there. Correct where {0} or the "
            "base is, or the size of {0}."
        )
        findings = [
            Finding(FIXTURE_IN_BASE, message.format(name, 1e3 * DEEP_M), Source(entry=f"fixtures.{name}"))
            for name in through
        ]
        return Refusal(tuple(findings), nodes.sample, nodes.sample[own[:1]], through)
    chosen = _chosen_nodes(subject, nodes, own)
    states = _states_at(subject, nodes, chosen)
    if len(_empty(states, chosen)):
        every = own[np.unique(np.linspace(0, len(own) - 1, min(len(own), _MOST_REPORTED)).astype(np.int64))]
        every = np.union1d(every, chosen)
        wrong = nodes.sample[_empty(_states_at(subject, nodes, every), every)]
        return Refusal(tuple(unreachable(subject, wrong)), nodes.sample, wrong)
    blocked = chosen[:0] if tilt > 0.0 else _blocked(subject, nodes, states, chosen)
    if len(blocked):
        findings = tuple(_describe_blocked(subject, nodes, blocked, len(chosen)))
        return Refusal(findings, nodes.sample, nodes.sample[blocked])
    return _blocked_change(subject, nodes)


def _blocked_change(subject: PathInCell, nodes: Nodes) -> Refusal | None:
    """Refuse a cell in which something collides where the tool is changed."""
    path, queries = subject.path, subject.queries
    cell, seen = queries.cell, set[tuple[int, int]]()
    for end in np.flatnonzero(path.changed).tolist():
        carried = {(int(path.tool[at]), int(path.placement[at])) for at in (end - 1, end)}
        if len({tool for tool, _ in carried}) < 2:
            continue
        for tool, placement in sorted(carried - seen):
            touch = queries.first_touch(cell.change_place, tool, placement)
            if touch is None:
                continue
            key, advice = "tool_change_deg_mm", "State other joints under tool_change_deg_mm"
            if cell.tool_change is None:
                key, advice = "home_deg_mm", "State clear joints under tool_change_deg_mm, or another home"
            elif queries.first_touch(cell.home, tool, placement) is None:
                advice += ", or leave that key out: home is clear"
            text = (
                f"the tool is changed at {key} of cell {cell.name}, where {touch.body} collides with {touch.other} "
                f"while {cell.tools[tool].name} is carried: every way there is blocked. {advice}."
            )
            wrong = np.array([end] if cell.tool_change is None else [], dtype=np.int64)
            return Refusal((subject.finding(TRANSFER_BLOCKED, text, end),), nodes.sample, wrong)
        seen |= carried
    return None


def _chosen_nodes(subject: PathInCell, nodes: Nodes, own: Indices) -> Indices:
    """Choose among the nodes that spray: the outermost, those far from one another, and the nearest to each fixture."""
    sample = nodes.sample[own]
    chosen = [spread_samples(subject.path, sample, _MOST_NODES)]
    cell = subject.queries.cell
    places = subject.path.T_base_tcp[sample, :3, 3] @ cell.T_cell_base[:3, :3].T + cell.T_cell_base[:3, 3]
    for body in cell.fixtures:
        corners = corners_of(body)
        outside = np.maximum(np.maximum(corners.min(axis=0) - places, places - corners.max(axis=0)), 0.0)
        chosen.append(np.argsort(np.round(np.linalg.norm(outside, axis=1), 6), kind="stable")[:_NEAREST])
    return own[np.unique(np.concatenate(chosen))]


def _states_at(subject: PathInCell, nodes: Nodes, chosen: Indices) -> Ladder:
    """Give the configurations that the search has at some nodes."""
    return solve_states(subject.queries, subject.path, nodes, [node_poses(nodes, chosen, STRAIGHT)])


def _empty(states: Ladder, chosen: Indices) -> Indices:
    """Give those of the chosen nodes that have no configuration."""
    return chosen[np.diff(states.first)[chosen] == 0]


def _blocked(subject: PathInCell, nodes: Nodes, states: Ladder, chosen: Indices) -> Indices:
    """Give nodes at which every configuration collides, a few at most: first some, then all, then twice as many."""

    def without_clear(states: Ladder, rows: Indices, chosen: Indices) -> Indices:
        """Give those of the chosen nodes of which no state among some (k,) is clear."""
        sample, path = nodes.sample[states.node[rows]], subject.path
        hits = subject.queries.collide(states.q[rows], path.tool[sample], path.placement[sample])
        return np.setdiff1d(chosen, states.node[rows[~hits]])

    rows = np.concatenate([np.arange(*states.first[node : node + 2]) for node in chosen.tolist()])
    turn = np.round(states.azimuth[rows] / (2.0 * np.pi) * _FEW_AZIMUTHS, 6)
    first = np.isclose(turn, np.round(turn)) | (nodes.azimuths[states.node[rows]] == 1)
    doubtful = without_clear(states, rows[first], chosen)
    if not len(doubtful):
        return doubtful
    doubtful = doubtful[np.unique(np.linspace(0, len(doubtful) - 1, _MOST_IN_DOUBT).astype(np.int64))]
    finer = replace(nodes, azimuths=np.where(nodes.azimuths > 1, 2 * nodes.azimuths, 1))
    every = _states_at(subject, finer, doubtful)
    return without_clear(every, np.arange(len(every.node)), doubtful)


def _describe_blocked(subject: PathInCell, nodes: Nodes, blocked: Indices, count: int) -> Iterator[Finding]:
    """Report, once for each recipe path and pair, what collides in the configuration that the fewest bodies keep."""
    path, states = subject.path, _states_at(subject, nodes, blocked)
    found: dict[tuple[Source, str], list[int]] = {}
    for node in blocked.tolist():
        sample, (low, high) = int(nodes.sample[node]), states.first[node : node + 2].tolist()
        rows = np.unique(np.linspace(low, high - 1, _MOST_PAIRS).astype(np.int64))
        touches = subject.queries.obstacles(states.q[rows], int(path.tool[sample]), int(path.placement[sample]))
        pairs = " and ".join(f"{touch.body} collides with {touch.other}" for touch in touches)
        found.setdefault((subject.made_by(sample), pairs), []).append(sample)
    for (_, pairs), samples in found.items():
        text = (
            f"every configuration collides here; in the one that the fewest bodies block, {pairs}. {len(samples)} of "
            f"the {count} poses that were looked at first are so."
        )
        yield subject.finding(COLLISION, text, samples[0])
