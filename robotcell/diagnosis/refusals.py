"""Cheap rules before the search for a motion. Each is necessary for any motion.

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
from dataclasses import replace

import numpy as np

from geometry.arrays import Indices
from robotcell.cell.cell import corners_of
from robotcell.collision.collision import fixtures_through_base
from robotcell.diagnosis.reasons import Diagnosis, PathInCell, unreachable
from robotcell.motion.ladder_graph import STRAIGHT, Nodes, choose_nodes, node_poses, solve_states
from robotcell.motion.ladder_search import Ladder
from robotcell.placement.reachability import spread_samples
from specs.finding import Finding
from specs.finding_rules import COLLISION, FIXTURE_IN_BASE, TRANSFER_BLOCKED
from specs.source import Source

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


def find_refusal(subject: PathInCell, tilt: float) -> Diagnosis | None:
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
        return Diagnosis(tuple(findings), nodes.sample, nodes.sample[own[:1]], True, through)
    chosen = _chosen_nodes(subject, nodes, own)
    states = _states_at(subject, nodes, chosen)
    if len(_empty(states, chosen)):
        every = own[np.unique(np.linspace(0, len(own) - 1, min(len(own), _MOST_REPORTED)).astype(np.int64))]
        every = np.union1d(every, chosen)
        wrong = nodes.sample[_empty(_states_at(subject, nodes, every), every)]
        return Diagnosis(tuple(unreachable(subject, wrong)), nodes.sample, wrong, True)
    blocked = chosen[:0] if tilt > 0.0 else _blocked(subject, nodes, states, chosen)
    if len(blocked):
        findings = tuple(_describe_blocked(subject, nodes, blocked, len(chosen)))
        return Diagnosis(findings, nodes.sample, nodes.sample[blocked], True)
    return _blocked_change(subject, nodes)


def _blocked_change(subject: PathInCell, nodes: Nodes) -> Diagnosis | None:
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
            return Diagnosis((subject.finding(TRANSFER_BLOCKED, text, end),), nodes.sample, wrong, True)
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
