"""Findings that say why a robot cannot do a program, or not as asked: where, who asked for it, what would help."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.motion.attempt import Motion
from robotcell.motion.cell_queries import Questions
from robotcell.motion.ladder_graph import AZIMUTHS, leant
from robotcell.motion.retime import Pace
from robotcell.motion.sampled_path import Course, Flags
from robotcell.motion.track_branch import Followed
from robotcell.robot.full_turns import is_inside
from robotcell.robot.robot import Robot
from specs.finding import Finding, FindingRule, Severity
from specs.finding_rules import (
    COLLISION,
    CONFIGURATION_JUMP,
    JET_LEANT,
    JOINT_LIMIT,
    JUMP,
    NEAR_SINGULAR,
    OUT_OF_REACH,
    SPEED_NOT_HELD,
    TRANSFER_BLOCKED,
)

Made: TypeAlias = Callable[[int], str]
"""Gives the recipe path that asked for a sample."""

_SLOW = 0.98
_LATE_S = 0.05
"""What the robot takes longer for all that one recipe line asks for, before anybody is told."""
_SLOWEST_M_S = 5e-4
"""Slower than this the nozzle only turns on the spot: it sprays longer there, not elsewhere."""
_LEAST_TURN = np.radians(0.1)
_NEAR_SINGULAR = 0.02
_FAR_M = np.array([0.005, 0.01, 0.02, 0.03, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8, 1.2, 2.0, 5.0])
_TILTS_DEG = (5.0, 10.0, 15.0, 20.0, 30.0, 40.0)


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """What findings are about."""

    ask: Questions
    course: Course

    def made_by(self, sample: int) -> str:
        """Give the recipe path that asked for a sample."""
        return self.ask.program.instructions[int(self.course.instruction[sample])].made_by

    def place(self, sample: int) -> tuple[float, float, float]:
        """Give where a sample is, board frame, mm."""
        T_base_board = self.course.T_base_board[int(self.course.placement[sample])]
        point = np.linalg.inv(T_base_board) @ self.course.T_base_tcp[sample, :, 3]
        x, y, z = (np.round(point[:3] * 1e3, 3) + 0.0).tolist()
        return x, y, z

    def grouped(self, samples: Indices) -> Iterator[tuple[str, Indices]]:
        """Give samples by who asked for them, in order of their first."""
        groups: dict[str, list[int]] = {}
        for sample in samples.tolist():
            groups.setdefault(self.made_by(sample), []).append(sample)
        for made_by, members in groups.items():
            yield made_by, np.array(members, dtype=np.int64)


def unreachable(scene: Scene, samples: Indices) -> list[Finding]:
    """Say of poses that no posture reaches what keeps the robot from them."""
    findings: list[Finding] = []
    for made_by, members in scene.grouped(samples):
        worst = int(members[len(members) // 2])
        rule, text = _why_unreachable(scene, worst)
        count = f"{len(members)} points, such as this, are" if len(members) > 1 else "this point is"
        findings.append(Finding(rule, f"{count} {text}.", made_by, scene.place(worst)))
    return findings


def _why_unreachable(scene: Scene, sample: int) -> tuple[FindingRule, str]:
    robot = scene.ask.cell.robot
    found, _ = scene.ask.postures(_around(scene, sample), int(scene.course.tool[sample]))
    rows = found.reshape(-1, robot.dof)
    rows = rows[np.isfinite(rows[:, 0])]
    if len(rows):
        return JOINT_LIMIT, f"reached only beyond a joint's limit: {_beyond(robot, rows)}; {_nearest(scene, sample)}"
    return OUT_OF_REACH, f"out of the robot's reach; {_nearest(scene, sample)}"


def _around(scene: Scene, sample: int) -> NDArray[np.float64]:
    """(k, 4, 4) a pose at every azimuth that is tried."""
    count = AZIMUTHS if scene.course.free[sample] else 1
    azimuth = 2.0 * np.pi * np.arange(count) / AZIMUTHS
    return leant(np.repeat(scene.course.T_base_tcp[sample : sample + 1], count, axis=0), azimuth, np.zeros((count, 2)))


def _beyond(robot: Robot, rows: NDArray[np.float64]) -> str:
    """Say which joint is beyond its limit, by how much, in the posture in which that is least."""
    low = np.array([joint.lowest for joint in robot.joints])
    high = np.array([joint.highest for joint in robot.joints])
    turning = np.array([joint.kind == "revolute" for joint in robot.joints])
    shifts = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])[:, None, None] * 2.0 * np.pi * turning
    over = np.min(np.maximum(np.maximum(low - (rows + shifts), (rows + shifts) - high), 0.0), axis=0)
    worst = over.max(axis=1)
    row = int(np.argmin(np.round(worst, 9)))
    joint = int(np.argmax(over[row]))
    excess = f"{np.degrees(over[row, joint]):.1f} degrees" if turning[joint] else f"{over[row, joint] * 1e3:.1f} mm"
    return f"{robot.joints[joint].name} by {excess}"


def _nearest(scene: Scene, sample: int) -> str:
    """Say by which shift, or which lean, a pose would be reached."""
    moved = _nearest_shift(scene, sample)
    tilted = _nearest_tilt(scene, sample)
    told = [text for text in (moved, tilted) if text]
    return (
        "it would be reached " + ", or ".join(told)
        if told
        else "no shift up to 5 m and no tilt helps: look at the frames"
    )


def _nearest_shift(scene: Scene, sample: int) -> str:
    pose = scene.course.T_base_tcp[sample]
    flat = np.array([pose[0, 3], pose[1, 3], 0.0])
    inward = -flat / max(float(np.linalg.norm(flat)), 1e-9)
    up = np.linalg.inv(scene.ask.cell.T_cell_base)[:3, 2]
    ways = (
        (inward, "nearer to the robot's axis"),
        (-inward, "farther from the robot's axis"),
        (up, "higher"),
        (-up, "lower"),
    )
    best: tuple[float, str] | None = None
    for way, text in ways:
        tried = np.repeat(pose[None], len(_FAR_M), axis=0)
        tried[:, :3, 3] += _FAR_M[:, None] * way
        good = np.flatnonzero(_reached(scene, sample, tried))
        if len(good) and (best is None or _FAR_M[good[0]] < best[0]):
            best = (float(_FAR_M[good[0]]), text)
    return "" if best is None else f"{best[0] * 1e3:g} mm {best[1]}"


def _nearest_tilt(scene: Scene, sample: int) -> str:
    turns = np.radians(np.arange(0.0, 360.0, 45.0))
    for degrees in _TILTS_DEG:
        leans = np.radians(degrees) * np.column_stack((np.cos(turns), np.sin(turns)))
        tried = leant(np.repeat(scene.course.T_base_tcp[sample][None], len(turns), axis=0), np.zeros(len(turns)), leans)
        if _reached(scene, sample, tried).any():
            return f"with the jet tilted by {degrees:g} degrees more or less"
    return ""


def _reached(scene: Scene, sample: int, poses: NDArray[np.float64]) -> Flags:
    """(k,) whether poses are reached within the limits at some azimuth that is allowed."""
    count = AZIMUTHS if scene.course.free[sample] else 1
    azimuth = np.tile(2.0 * np.pi * np.arange(count) / AZIMUTHS, len(poses))
    asked = leant(np.repeat(poses, count, axis=0), azimuth, np.zeros((len(azimuth), 2)))
    found, _ = scene.ask.postures(asked, int(scene.course.tool[sample]))
    inside = is_inside(scene.ask.cell.robot, found).any(axis=1)
    return np.asarray(inside.reshape(len(poses), count).any(axis=1))


def collisions(scene: Scene, motion: Motion) -> list[Finding]:
    """Name the pairs that collide in whatever posture, once for each pair and who asked."""
    seen: dict[tuple[str, str, str], list[int]] = {}
    for sample in motion.hits.tolist():
        touch = scene.ask.pair(
            motion.done.q[sample], int(scene.course.tool[sample]), int(scene.course.placement[sample])
        )
        if touch is not None:
            seen.setdefault((scene.made_by(sample), *touch), []).append(sample)
    return [
        Finding(
            COLLISION,
            f"{body} collides with {other} at {len(samples)} of the points looked at, in every posture that was tried.",
            made_by,
            scene.place(samples[0]),
        )
        for (made_by, body, other), samples in seen.items()
    ]


def breaks(scene: Scene, motion: Motion) -> list[Finding]:
    """Say where the course cannot be followed in one go."""
    findings: list[Finding] = []
    for node in motion.torn.tolist():
        sample = int(motion.nodes.sample[node])
        text = (
            "the robot would have to change its configuration here while the jet is on: no posture before this place "
            "goes over into one after it. Move or turn the board, or let the stroke end here."
        )
        findings.append(Finding(CONFIGURATION_JUMP, text, scene.made_by(sample), scene.place(sample)))
    for node in motion.blocked.tolist():
        sample = int(motion.nodes.sample[node])
        text = (
            "the robot has to change its configuration or its tool here, and every way that was tried, straight and by "
            "way of home, collides. Choose another home, or another place for the board."
        )
        findings.append(Finding(TRANSFER_BLOCKED, text, scene.made_by(sample), scene.place(sample)))
    for made_by, members in scene.grouped(motion.lost):
        text = f"no posture goes on from the one before it at {_points(len(members))}, within the joints' limits."
        findings.append(Finding(JUMP, text, made_by, scene.place(int(members[0]))))
    return findings


def slowness(scene: Scene, pace: Pace) -> list[Finding]:
    """Say where the robot sprays more slowly than the program asks, once for each who asked."""
    course = scene.course
    length = np.linalg.norm(np.diff(course.T_base_tcp[:, :3, 3], axis=0), axis=1)
    lasting = np.diff(course.times)
    wet = course.wet[1:] & course.wet[:-1] & (lasting > 1e-6)
    slow = np.flatnonzero(wet & (pace.share < _SLOW)) + 1
    findings: list[Finding] = []
    for made_by, members in scene.grouped(slow):
        interval = members - 1
        late = pace.lasting[interval] - lasting[interval]
        if late.sum() < _LATE_S:
            continue
        on_the_way = length[interval] > _SLOWEST_M_S * lasting[interval]
        told = interval[on_the_way] if on_the_way.any() else interval
        worst = int(told[np.argmin(np.round(pace.share[told], 6))])
        joint = scene.ask.cell.robot.joints[int(pace.joint[worst])].name
        what = "greatest speed" if pace.by_speed[worst] else "greatest acceleration"
        asked = length[worst] / lasting[worst] * 1e3
        severity: Severity = "warning" if on_the_way.any() else "info"
        speeds = (
            f"{asked * pace.share[worst]:.1f} instead of {asked:.1f} mm/s"
            if on_the_way.any()
            else (f"turning at {pace.share[worst]:.0%} of the asked rate")
        )
        text = (
            f"the robot is {late.sum():.2f} s longer under way than asked; slowest here, {speeds}: "
            f"{joint} is at its {what}."
        )
        findings.append(Finding(SPEED_NOT_HELD, text, made_by, scene.place(worst), override=severity))
    return findings


def leaning(scene: Scene, done: Followed) -> list[Finding]:
    """Say where the jet leans from what was asked."""
    lean = np.linalg.norm(done.lean, axis=1)
    findings: list[Finding] = []
    for made_by, members in scene.grouped(np.flatnonzero((lean > _LEAST_TURN) & scene.course.wet)):
        worst = int(members[np.argmax(lean[members])])
        text = (
            f"the jet leans by up to {np.degrees(lean[worst]):.1f} degrees from what was asked: nothing else is clear."
        )
        findings.append(Finding(JET_LEANT, text, made_by, scene.place(worst)))
    return findings


def nearly_singular(scene: Scene, condition: Scalars) -> list[Finding]:
    """Say where the robot sprays near a singular posture."""
    near = np.flatnonzero(scene.course.wet & (condition < _NEAR_SINGULAR))
    findings: list[Finding] = []
    for made_by, members in scene.grouped(near):
        worst = int(members[np.argmin(condition[members])])
        text = (
            f"near a singular posture at {_points(len(members))}, inverse condition {condition[worst]:.4f} at the "
            "worst: the joints move much for little. Move or turn the board."
        )
        findings.append(Finding(NEAR_SINGULAR, text, made_by, scene.place(worst)))
    return findings


def _points(count: int) -> str:
    return f"{count} point" if count == 1 else f"{count} points"
