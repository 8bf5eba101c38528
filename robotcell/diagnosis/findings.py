"""Findings on why a robot cannot carry out a program, or not as programmed: where, caused by what, what would help."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.motion.cell_queries import CellQueries
from robotcell.motion.ladder_graph import AZIMUTHS, tilted
from robotcell.motion.retime import Retiming
from robotcell.motion.sampled_path import Flags, SampledPath, TrackedPath
from robotcell.motion.track_attempt import Motion
from robotcell.robot.full_turns import TURN, is_inside
from robotcell.robot.robot import Poses, Robot
from specs.finding import Finding, Severity
from specs.finding_rules import (
    COLLISION,
    CONFIGURATION_JUMP,
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


@dataclass(frozen=True, slots=True, eq=False)
class PathInCell:
    """The subject of findings: a path, and queries to the cell."""

    queries: CellQueries
    path: SampledPath

    def made_by(self, sample: int) -> Source:
        """Give the recipe path that a sample comes from."""
        return self.queries.program.instructions[int(self.path.instruction[sample])].made_by

    def place(self, sample: int) -> tuple[float, float, float]:
        """Give the place of a sample, board frame, mm."""
        T_base_board = self.path.T_base_board[int(self.path.placement[sample])]
        point = np.linalg.inv(T_base_board) @ self.path.T_base_tcp[sample, :, 3]
        x, y, z = (np.round(point[:3] * 1e3, 3) + 0.0).tolist()
        return x, y, z

    def grouped(self, samples: Indices) -> Iterator[tuple[Source, Indices]]:
        """Group samples by the recipe path they come from, in order of their first."""
        groups: dict[Source, list[int]] = {}
        for sample in samples.tolist():
            groups.setdefault(self.made_by(sample), []).append(sample)
        for made_by, members in groups.items():
            yield made_by, np.array(members, dtype=np.int64)

    def configurations(self, sample: int, poses: Poses) -> NDArray[np.float64]:
        """Give the joints (k, azimuths * b, dof) of poses (k, 4, 4) at every azimuth that a sample allows."""
        count = AZIMUTHS if self.path.free[sample] else 1
        azimuth = np.tile(TURN * np.arange(count) / AZIMUTHS, len(poses))
        turned = tilted(np.repeat(poses, count, axis=0), azimuth, np.zeros((len(azimuth), 2)))
        found, _ = self.queries.configurations(turned, int(self.path.tool[sample]))
        return found.reshape(len(poses), -1, found.shape[2])


def unreachable(subject: PathInCell, samples: Indices) -> Iterator[Finding]:
    """Report poses that no configuration reaches, and what keeps the robot from them."""
    for made_by, members in subject.grouped(samples):
        worst = int(members[len(members) // 2])
        rows = subject.configurations(worst, subject.path.T_base_tcp[worst][None])[0]
        rows = rows[np.isfinite(rows[:, 0])]
        rule, text = OUT_OF_REACH, "out of the robot's reach"
        if len(rows):
            beyond = _least_excess(subject.queries.cell.robot, rows)
            rule, text = JOINT_LIMIT, f"reached only beyond a joint's limit: {beyond}"
        count = f"{len(members)} points, such as this, are" if len(members) > 1 else "this point is"
        message = f"{count} {text}; {_what_reaches(subject, worst)}."
        yield Finding(rule, message, made_by, subject.place(worst))


def _least_excess(robot: Robot, rows: NDArray[np.float64]) -> str:
    """Name the joint beyond its limit, and by how much, in the configuration in which that is least."""
    turning = robot.turning
    turned = rows + np.array([-2.0, -1.0, 0.0, 1.0, 2.0])[:, None, None] * TURN * turning
    over = np.min(np.maximum(np.maximum(robot.lowest - turned, turned - robot.highest), 0.0), axis=0)
    row = int(np.argmin(np.round(over.max(axis=1), 9)))
    joint = int(np.argmax(over[row]))
    excess = f"{np.degrees(over[row, joint]):.1f} degrees" if turning[joint] else f"{over[row, joint] * 1e3:.1f} mm"
    return f"{robot.joints[joint].name} by {excess}"


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
    every = _reached(subject, sample, np.concatenate((tried.reshape(-1, 4, 4), leaning)))
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


def _reached(subject: PathInCell, sample: int, poses: Poses) -> Flags:
    """(k,) whether poses are reached within the limits at some azimuth that is allowed."""
    return np.any(is_inside(subject.queries.cell.robot, subject.configurations(sample, poses)), axis=1)


def collisions(subject: PathInCell, motion: Motion) -> Iterator[Finding]:
    """Report the pairs that collide in every configuration, once for each pair and recipe path.

    A hit is at a sample, or on the way from there to the next.
    """
    seen: dict[tuple[Source, str, str], list[int]] = {}
    path, rows = subject.path, motion.tracked.q
    for sample in motion.hits.tolist():
        at = int(path.tool[sample]), int(path.placement[sample])
        pair = subject.queries.first_pair(rows[sample], *at)
        if pair is None and sample + 1 < len(rows):
            pair = subject.queries.pair_between(rows[sample], rows[sample + 1], *at)
        if pair is not None:
            seen.setdefault((subject.made_by(sample), *pair), []).append(sample)
    for (made_by, body, other), samples in seen.items():
        text = f"{body} collides with {other} at {len(samples)} of the points checked, in every configuration."
        yield Finding(COLLISION, text, made_by, subject.place(samples[0]))


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
            yield Finding(rule, text, subject.made_by(sample), subject.place(sample))
    for made_by, members in subject.grouped(motion.lost):
        text = f"no configuration continues the one before at {_points(len(members))}, within the joints' limits."
        yield Finding(JUMP, text, made_by, subject.place(int(members[0])))


def slowness(subject: PathInCell, retiming: Retiming) -> Iterator[Finding]:
    """Report where the robot sprays more slowly than programmed, once for each recipe path."""
    path = subject.path
    length = np.linalg.norm(np.diff(path.T_base_tcp[:, :3, 3], axis=0), axis=1)
    lasting = np.diff(path.times)
    spraying = path.jet_on[1:] & path.jet_on[:-1] & (lasting > 1e-6)
    slow = np.flatnonzero(spraying & (retiming.share < _SLOW)) + 1
    for made_by, members in subject.grouped(slow):
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
        severity: Severity = "warning" if len(moving) else "info"
        speeds = f"turning at {share:.0%} of the programmed rate"
        if len(moving):
            speeds = f"{programmed * share:.1f} instead of {programmed:.1f} mm/s"
        text = (
            f"the robot takes {late.sum():.2f} s longer than programmed; slowest here, {speeds}: {joint} is at its "
            f"{limit}."
        )
        yield Finding(SPEED_NOT_HELD, text, made_by, subject.place(worst), override=severity)


def tilts(subject: PathInCell, tracked: TrackedPath) -> Iterator[Finding]:
    """Report where the jet is tilted from the programmed direction."""
    tilt = np.linalg.norm(tracked.tilt, axis=1)
    least = np.where(np.isfinite(tracked.share), _EVEN_TURN, _LEAST_TURN)
    for made_by, members in subject.grouped(np.flatnonzero((tilt > least) & subject.path.jet_on)):
        worst = int(members[np.argmax(tilt[members])])
        text = (
            f"the jet is tilted by up to {np.degrees(tilt[worst]):.1f} degrees from the programmed direction: nothing "
            "else is clear, or the hose would wind up."
        )
        yield Finding(JET_TILTED, text, made_by, subject.place(worst))


def nearly_singular(subject: PathInCell, condition: Scalars) -> Iterator[Finding]:
    """Report where the robot sprays near a singular configuration."""
    for made_by, members in subject.grouped(np.flatnonzero(subject.path.jet_on & (condition < _NEAR_SINGULAR))):
        worst = int(members[np.argmin(condition[members])])
        text = (
            f"near a singular configuration at {_points(len(members))}, inverse condition {condition[worst]:.4f} at "
            "the worst: the joints move far for a short way. Move or turn the board."
        )
        yield Finding(NEAR_SINGULAR, text, made_by, subject.place(worst))


def _points(count: int) -> str:
    return f"{count} point" if count == 1 else f"{count} points"
