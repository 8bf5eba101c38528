"""What keeps a robot from a program, or changes it: where, and caused by what."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from geometry.arrays import Indices, Scalars
from robotcell.cell.hold import describe_held, plan_bounds_mm
from robotcell.diagnosis.plausibility import check_cell
from robotcell.motion.cell_queries import CellQueries, HomeMoves, Reconfiguration
from robotcell.motion.ladder_graph import AZIMUTHS, tilted
from robotcell.motion.plan_joints import OutOfReach
from robotcell.motion.retime import Retiming
from robotcell.motion.sampled_path import SampledPath, TrackedPath
from robotcell.motion.track_attempt import Motion
from robotcell.robot.robot import TURN, Poses, flange_poses, is_inside
from specs import finding_rules as rules
from specs.finding import Finding, FindingRule, Severity, worst_first
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
_MM = 1e3


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
        rule, text = rules.OUT_OF_REACH, "out of the robot's reach"
        if len(rows):  # the configuration in which the joint that is farthest beyond its limit is least so
            turned = rows + np.array([-2.0, -1.0, 0.0, 1.0, 2.0])[:, None, None] * TURN * robot.turning
            over = np.min(np.maximum(np.maximum(robot.lowest - turned, turned - robot.highest), 0.0), axis=0)
            over = over[int(np.argmin(np.round(over.max(axis=1), 9)))]
            joint = robot.joints[int(np.argmax(over))]
            size = joint.unit.per_si * over.max()
            excess = f"{f'{size:.1f}' if size >= 0.05 else 'less than 0.1'} {joint.unit.word}"
            rule, text = rules.JOINT_LIMIT, f"reached only beyond a joint's limit: {joint.name} by {excess}"
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
        yield subject.finding(rules.COLLISION, text, samples[0])


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
        (rules.CONFIGURATION_JUMP, jump, motion.discontinuities),
        (rules.TRANSFER_BLOCKED, blocked, motion.blocked),
    ):
        for sample in motion.nodes.sample[nodes].tolist():
            yield subject.finding(rule, text, sample)
    for members in subject.grouped(motion.lost):
        text = f"no configuration continues the one before at {_points(len(members))}, within the joints' limits."
        yield subject.finding(rules.JUMP, text, int(members[0]))


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
        yield subject.finding(rules.SPEED_NOT_HELD, text, worst, "warning" if len(moving) else "info")


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
        yield subject.finding(rules.JET_TILTED, text, worst)


def nearly_singular(subject: PathInCell, condition: Scalars) -> Iterator[Finding]:
    """Report where the robot sprays near a singular configuration."""
    for members in subject.grouped(np.flatnonzero(subject.path.jet_on & (condition < _NEAR_SINGULAR))):
        worst = int(members[np.argmin(condition[members])])
        text = (
            f"near a singular configuration at {_points(len(members))}, inverse condition {condition[worst]:.4f} at "
            "the worst: the joints move far for a short way. Move or turn the board."
        )
        yield subject.finding(rules.NEAR_SINGULAR, text, worst)


def _points(count: int) -> str:
    return f"{count} point" if count == 1 else f"{count} points"


@dataclass(frozen=True, slots=True, eq=False)
class Diagnosis:
    """What is wrong with a program in a cell, and where."""

    findings: tuple[Finding, ...]
    """Worst first."""
    nodes: Indices
    """Samples of the path at which configurations are chosen."""
    wrong: Indices
    """Those that are not reached, not clear or not in one go; none where no other place of anything would help."""
    is_refusal: bool = False
    """Whether a cheap rule refused the cell: no motion can exist."""
    through_base: tuple[str, ...] = ()
    """Fixtures that reach into the robot's base."""


def diagnose(
    subject: PathInCell,
    board: Workpiece | None,
    outcome: Diagnosis | OutOfReach | Motion,
    home: HomeMoves | None = None,
    carried_out: tuple[Retiming, Scalars] | None = None,
) -> Diagnosis:
    """Give the findings on a program in a cell, with their reasons.

    Args:
        subject: The path in the cell; as it is tracked where there is a motion.
        board: With which collisions were checked.
        outcome: Of the search for a motion, or of the cheap rule that refused the cell.
        home: Moves from and to home, if they were looked for.
        carried_out: How the motion is carried out, with the inverse condition (n,) at the samples, if it was timed.
    """
    match outcome:
        case Diagnosis():
            findings, nodes, wrong = [*outcome.findings], outcome.nodes, outcome.wrong
        case OutOfReach():
            nodes, wrong = outcome.nodes.sample, outcome.nodes.sample[outcome.empty]
            findings = [*unreachable(subject, wrong)]
        case Motion():
            nodes, wrong = outcome.nodes.sample, np.union1d(outcome.hits, outcome.broken)
            findings = [*breaks(subject, outcome), *collisions(subject, outcome)]
    if not isinstance(outcome, Motion) or len(outcome.broken):
        findings = [*check_cell(subject.queries.cell, board), *findings]
    elif home is not None:
        findings += _check_home(subject, home)
        if carried_out is not None:
            findings += [*tilts(subject, outcome.tracked)]
            findings += _check_tool_changes(subject, board, outcome.reconfigurations)
            findings += nearly_singular(subject, carried_out[1])
            findings += [*slowness(subject, carried_out[0]), *_check_board(subject, board)]
    if isinstance(outcome, Diagnosis):
        return replace(outcome, findings=worst_first(findings))
    return Diagnosis(worst_first(findings), nodes, wrong)


def _check_home(subject: PathInCell, home: HomeMoves) -> Iterator[Finding]:
    """Report where the way from home to the beginning, or back from the end, is blocked."""
    last = len(subject.path.times) - 1
    for at, way, text in ((0, home.out, "from home to the beginning"), (last, home.back, "from the end back home")):
        if len(way) < 2:
            message = f"every joint move {text} that was tried collides; choose another home, or move there by hand."
            yield subject.finding(rules.HOME_BLOCKED, message, at)


def _check_tool_changes(
    subject: PathInCell, board: Workpiece | None, moves: Sequence[Reconfiguration]
) -> Iterator[Finding]:
    """Report the first change of a tool whose orifice is above the board, or below it."""
    cell, path = subject.queries.cell, subject.path
    if board is None:
        return
    for move in moves:
        row = move.way[move.change : move.change + 1]
        for sample in (move.begin, move.end) if move.change else ():
            T_base_tcp = flange_poses(cell.robot, row)[0] @ cell.tools[int(path.tool[sample])].T_flange_tcp
            place = np.linalg.inv(path.T_base_board[int(path.placement[sample])]) @ T_base_tcp[:, 3]
            left, front, right, back, _ = plan_bounds_mm(board)
            if left <= _MM * place[0] <= right and front <= _MM * place[1] <= back:
                key = "home_deg_mm" if cell.tool_change is None else "tool_change_deg_mm"
                message = (
                    f"the tool is changed above {board.name}, at {key} of cell {cell.name}: what drips or falls there "
                    "lands on it. State joints beside the board under tool_change_deg_mm."
                )
                yield subject.finding(rules.TOOL_CHANGE_ABOVE_BOARD, message, move.end)
                return


def _check_board(subject: PathInCell, board: Workpiece | None) -> Iterator[Finding]:
    """Report a board that is not known, and what was taken for its place."""
    if board is None:
        name, held_by = subject.queries.program.origin.board, subject.queries.cell.held_by
        message = f"the board {name} was not found: collisions with it were not checked"
        if held_by != "origin":
            point = describe_held(held_by)
            message += f", and the origin of its file was taken for the {point} that the cell holds it by"
        yield Finding(rules.BOARD_NOT_CHECKED, f"{message}. Name it with --board.")
