"""Cheap rules that refuse a cell before the search for a motion begins. Each is necessary for any motion.

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

from geometry.arrays import Indices
from robotcell.cell.cell import Cell
from robotcell.collision.collision import fixtures_through_base
from robotcell.diagnosis.findings import PathInCell, unreachable
from robotcell.diagnosis.plausibility import corners_of
from robotcell.diagnosis.remedies import DEEP_M, spread_samples
from robotcell.motion.ladder_graph import STRAIGHT, Nodes, States, choose_nodes, node_poses, solve_states
from specs.finding import Finding
from specs.finding_rules import COLLISION, FIXTURE_IN_BASE, TRANSFER_BLOCKED
from specs.source import Source

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
    """Apply the rules one after the other; ``None`` where none refuses the cell.

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
        findings = tuple(_describe_through_base(name) for name in through)
        return Refusal(findings, nodes.sample, nodes.sample[own[:1]], through)
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
            pair = queries.first_pair(cell.change_place, tool, placement)
            if pair is not None:
                at_home = queries.first_pair(cell.home, tool, placement)
                text = _describe_change(cell, cell.tools[tool].name, pair, home_is_clear=at_home is None)
                finding = Finding(TRANSFER_BLOCKED, text, subject.made_by(end), subject.place(end))
                wrong = np.array([end] if cell.tool_change is None else [], dtype=np.int64)
                return Refusal((finding,), nodes.sample, wrong)
        seen |= carried
    return None


def _describe_change(cell: Cell, tool: str, pair: tuple[str, str], *, home_is_clear: bool) -> str:
    own = "tool_change_deg_mm"
    key, advice = own, f"State other joints under {own}"
    if cell.tool_change is None:
        key, advice = "home_deg_mm", f"State clear joints under {own}, or another home"
    elif home_is_clear:
        advice += ", or leave that key out: home is clear"
    return (
        f"the tool is changed at {key} of cell {cell.name}, where {pair[0]} collides with {pair[1]} while {tool} is "
        f"carried: every way there is blocked. {advice}."
    )


def _describe_through_base(name: str) -> Finding:
    message = (
        f"{name} reaches more than {1e3 * DEEP_M:g} mm into the robot's base: no robot can stand there. Correct where "
        f"{name} or the base is, or the size of {name}."
    )
    return Finding(FIXTURE_IN_BASE, message, Source(entry=f"fixtures.{name}"))


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


def _states_at(subject: PathInCell, nodes: Nodes, chosen: Indices) -> States:
    """Give the configurations that the search has at some nodes."""
    queries = subject.queries
    poses = node_poses(nodes, chosen, STRAIGHT)
    return solve_states(queries.cell.robot, subject.path, nodes, [poses], queries.configurations)


def _empty(states: States, chosen: Indices) -> Indices:
    """Give those of the chosen nodes that have no configuration."""
    return chosen[np.diff(states.ladder.first)[chosen] == 0]


def _blocked(subject: PathInCell, nodes: Nodes, states: States, chosen: Indices) -> Indices:
    """Give nodes at which every configuration collides, a few at most: first some, then all, then twice as many."""
    rows = np.concatenate([np.arange(*states.ladder.first[node : node + 2]) for node in chosen.tolist()])
    turn = np.round(states.ladder.azimuth[rows] / (2.0 * np.pi) * _FEW_AZIMUTHS, 6)
    first = np.isclose(turn, np.round(turn)) | (nodes.azimuths[states.node[rows]] == 1)
    doubtful = _without_clear(subject, nodes, states, rows[first], chosen)
    if not len(doubtful):
        return doubtful
    doubtful = doubtful[np.unique(np.linspace(0, len(doubtful) - 1, _MOST_IN_DOUBT).astype(np.int64))]
    finer = replace(nodes, azimuths=np.where(nodes.azimuths > 1, 2 * nodes.azimuths, 1))
    every = _states_at(subject, finer, doubtful)
    return _without_clear(subject, nodes, every, np.arange(len(every.node)), doubtful)


def _without_clear(subject: PathInCell, nodes: Nodes, states: States, rows: Indices, chosen: Indices) -> Indices:
    """Give those of the chosen nodes of which no state among some (k,) is clear."""
    sample = nodes.sample[states.node[rows]]
    path = subject.path
    hits = subject.queries.collide(states.ladder.q[rows], path.tool[sample], path.placement[sample])
    return np.setdiff1d(chosen, states.node[rows[~hits]])


def _describe_blocked(subject: PathInCell, nodes: Nodes, blocked: Indices, count: int) -> Iterator[Finding]:
    """Report, once for each recipe path and pair, what collides in the configuration that the fewest bodies keep."""
    path, states = subject.path, _states_at(subject, nodes, blocked)
    found: dict[tuple[Source, str], list[int]] = {}
    for node in blocked.tolist():
        sample, (low, high) = int(nodes.sample[node]), states.ladder.first[node : node + 2].tolist()
        rows = np.unique(np.linspace(low, high - 1, _MOST_PAIRS).astype(np.int64))
        touches = subject.queries.obstacles(states.ladder.q[rows], int(path.tool[sample]), int(path.placement[sample]))
        pairs = " and ".join(f"{touch.body} collides with {touch.other}" for touch in touches)
        found.setdefault((subject.made_by(sample), pairs), []).append(sample)
    for (made_by, pairs), samples in found.items():
        text = (
            f"every configuration collides here; in the one that the fewest bodies block, {pairs}. {len(samples)} of "
            f"the {count} poses that were looked at first are so."
        )
        yield Finding(COLLISION, text, made_by, subject.place(samples[0]))
