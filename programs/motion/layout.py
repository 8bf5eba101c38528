"""Cuts a timed program where the robot has to stand: tracks, waits, commands, switching of the jet."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import dist, inf, isnan
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from geometry.frames import align_signs, rotation_angles
from programs.motion.steps import IsClear, Moment, Reach
from programs.motion.tracks import Track, pose_of
from programs.playback import Timeline, ToolStates, play
from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait
from programs.soundness import TICK_S
from specs.source import Source

_STILL_MM, _STILL_RAD = 1e-6, 1e-6
"""Samples nearer than this are one pose."""
_SHORTEST_HOLD_S = 0.02
"""A pose held for less is the slow beginning or end of a motion, rounded."""
_JUMP_S = 1e-4
"""A move that takes no time is given this: nothing moves at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Tracking:
    """How a robot carries out a program, aligned with its m moves."""

    joints: NDArray[np.float64]
    """(m, dof) radians or mm"""
    clock: Scalars
    """(m,) s when the plan is there, where the robot takes other times; NaN within joint moves"""
    corner: NDArray[np.bool_] | None
    """(m,) whether a line of the plan, or a leg of a joint move, ends there; ``None`` where that is to be found"""
    share: Scalars | None = None
    """(m,) done of a line along which the turning axes go evenly, whatever the pose does; NaN elsewhere. ``None``: of
    none."""
    is_clear: IsClear | None = None
    """Check of the ways from home into the program; ``None`` where there is none."""


def on_time(program: TimedProgram, joints: NDArray[np.float64] | None = None) -> Tracking:
    """Give the tracking by a robot that keeps to a program's times, with its joints (m, dof) where they are known."""
    times = np.array([item.time_s for item in program.instructions if isinstance(item, MoveTo)], dtype=np.float64)
    rows = np.empty((len(times), 0)) if joints is None else np.asarray(joints, dtype=np.float64)
    return Tracking(rows, times, None)


Item: TypeAlias = Track | tuple[Reach, ...] | Wait | SetNozzle | Command
"""A ``Wait`` stands for the same pose twice too; a ``SetNozzle`` that falls into a track or a wait follows it."""


@dataclass(frozen=True, slots=True)
class Layout:
    """Items in order."""

    items: tuple[Item, ...]
    makers: tuple[Source, ...]
    """What ``Track.maker`` counts."""


def lay_out(program: TimedProgram, tracking: Tracking, timeline: Timeline) -> Layout:
    """Cut a program at everything that happens at rest.

    Args:
        program: Any sound program.
        tracking: Of its moves; dof is 0 where the joints are not known.
        timeline: Of the program.
    """
    cuts = [item for item in program.instructions if isinstance(item, Wait | Command)]
    states = play(timeline, np.array([item.time_s for item in cuts]))
    moves = [item for item in program.instructions if isinstance(item, MoveTo)]
    targets, due = [(*move.position, *move.quaternion) for move in moves], [move.time_s for move in moves]
    cutter = _Cutter(states, tracking, targets, [*due, inf])
    for instruction in program.instructions:
        match instruction:
            case MoveTo():
                cutter.move(instruction)
            case Wait():
                cutter.wait(instruction)
            case Command():
                cutter.command(instruction)
            case SetNozzle():
                cutter.switches.append(instruction)
                if not cutter.times:
                    cutter.cut()
    cutter.cut()
    return Layout(tuple(cutter.items), tuple(cutter.makers))


@dataclass(slots=True)
class _Cutter:
    """The samples of the stretch so far, and the items before it."""

    states: ToolStates
    """At every wait and command, in order."""
    tracking: Tracking
    targets: list[tuple[float, ...]]
    """Poses of all moves."""
    due: list[float]
    """Times of all moves, then infinity."""
    items: list[Item] = field(default_factory=list[Item])
    makers: dict[Source, int] = field(default_factory=dict[Source, int])
    times: list[float] = field(default_factory=list[float])
    poses: list[tuple[float, ...]] = field(default_factory=list[tuple[float, ...]])
    maker: list[int] = field(default_factory=list[int])
    clock: list[float] = field(default_factory=list[float])
    """When the plan is at each sample."""
    node: list[float] = field(default_factory=list[float])
    """Row of the joints that belongs to each sample; between two rows where it lies between two moves."""
    switches: list[SetNozzle] = field(default_factory=list[SetNozzle])
    """Of the stretch."""
    tool: str = ""
    """Number of the tool that is carried."""
    stopped: int = 0
    """Waits and commands so far."""
    moved: int = 0
    """Moves so far."""
    planned: float = 0.0
    """When the plan is at the last sample."""
    left_at: float = 0.0
    """When it is at the last sample that is not within a joint move."""

    def move(self, move: MoveTo) -> None:
        """Add the pose of a move."""
        self.moved += 1
        planned = float(self.tracking.clock[self.moved - 1])
        row = self.moved - 1
        self.sample(move.time_s, self.targets[row], move.made_by, planned, float(row))

    def wait(self, wait: Wait) -> None:
        """Hold the pose reached, then go on from it."""
        done = self.is_due(wait.time_s + wait.duration_s)
        pose = self.arrive(wait.time_s, wait.made_by, self.targets[self.moved] if done else ())
        self.cut()
        if wait.duration_s > 0:
            self.items.append(wait)
        if pose:
            after = wait.time_s + wait.duration_s
            self.sample(after, pose, wait.made_by, self.planned + wait.duration_s, self.row_of(pose))

    def command(self, command: Command) -> None:
        """Stand while a command is carried out."""
        tool = command.arguments[2] if command.keyword == "NOZZLE" else self.tool
        done = self.is_due(command.time_s)
        # Another orifice, or a board that was moved: only a move at the same time has its pose.
        elsewhere = done and (command.keyword == "CALL" or tool != self.tool)
        self.tool = tool
        pose = self.arrive(command.time_s, command.made_by, self.targets[self.moved] if done and not elsewhere else ())
        self.cut()
        self.items.append(command)
        if pose and not elsewhere:
            self.sample(command.time_s, pose, command.made_by, self.left_at, self.row_of(pose))

    def is_due(self, time_s: float) -> bool:
        """Whether the next move is done by then, but for less than a file resolves."""
        return self.due[self.moved] < time_s + 0.5 * TICK_S

    def arrive(self, time_s: float, made_by: Source, target: tuple[float, ...]) -> tuple[float, ...]:
        """Add the pose at the time of a wait or a command; give it, empty where only the next move has it.

        Args:
            time_s: When.
            made_by: Its recipe path.
            target: Where the next move ends, if that is all but reached.
        """
        at = self.stopped
        self.stopped += 1
        if not self.times:
            return ()
        if time_s > self.times[-1] + TICK_S:
            there = (*self.states.tcp[at].tolist(), *self.states.quaternion[at].tolist())
            due = self.tracking.clock[self.moved] if target else np.nan
            pose, planned = target or there, self.planned_at(time_s) if isnan(due) else float(due)
            self.sample(time_s, pose, made_by, planned, self.row_of(pose))
        return self.poses[-1]

    def planned_at(self, time_s: float) -> float:
        """When the plan is where the robot is at a time between its last sample and the next move."""
        begin_s, due_s = self.times[-1], self.due[self.moved]
        rate = (self.tracking.clock[self.moved] - self.planned) / (due_s - begin_s) if begin_s < due_s < inf else 1.0
        return self.planned + (time_s - begin_s) * (rate if rate >= 0.0 else 1.0)

    def sample(self, time_s: float, pose: tuple[float, ...], made_by: Source, planned: float, row: float) -> None:
        """Add a sample; ``row`` is that of its joints."""
        self.planned = planned
        self.left_at = self.left_at if isnan(planned) else planned
        self.clock.append(planned)
        self.times.append(time_s)
        self.poses.append(pose)
        self.maker.append(self.makers.setdefault(made_by, len(self.makers)))
        self.node.append(row)

    def row_of(self, pose: tuple[float, ...]) -> float:
        """Row of the joints that belongs to a pose between the last move and the next."""
        before, after = self.targets[self.moved - 1], self.targets[min(self.moved, len(self.targets) - 1)]
        done, left = _apart(before, pose), _apart(pose, after)
        return self.moved - 1 + (done / (done + left) if done > _STILL_MM else 0.0)

    def cut(self) -> None:
        """End the stretch; what was switched during it follows it."""
        if self.times:
            self.items += _stretch(self)
            self.times, self.poses, self.maker, self.clock, self.node = [], [], [], [], []
        self.items += self.switches
        self.switches = []


def _apart(one: tuple[float, ...], other: tuple[float, ...]) -> float:
    """How far two poses are from each other, in mm and units of a quaternion, whichever sign that has."""
    x, y, z, *turn = other
    return min(dist(one, other), dist(one, (x, y, z, *(-value for value in turn))))


def _stretch(cutter: _Cutter) -> Iterator[Item]:
    """Tracks and waits of the samples; each track begins where the one before it ended."""
    poses = np.array(cutter.poses)
    quaternion = align_signs(poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1, keepdims=True))
    times, maker, node = np.array(cutter.times), np.array(cutter.maker), np.array(cutter.node)
    still = np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1) <= _STILL_MM
    still &= rotation_angles(quaternion[:-1], quaternion[1:]) <= _STILL_RAD
    holds = still & (np.diff(times) >= _SHORTEST_HOLD_S)
    makers = tuple(cutter.makers)
    low = np.floor(node).astype(np.int64)
    joints, clock = cutter.tracking.joints[low], np.array(cutter.clock)
    following = cutter.tracking.joints[np.minimum(low + 1, len(cutter.tracking.joints) - 1)]
    joints = joints + (node - low)[:, None] * (following - joints)
    corner = None if cutter.tracking.corner is None else cutter.tracking.corner[low] | (node > low)
    share = None
    if cutter.tracking.share is not None:  # a line that is cut in two is as its poses are
        share = np.where(node > low, np.nan, cutter.tracking.share[low])
    whole = Track(times, poses[:, :3], quaternion, maker, joints, clock, node, corner, share)
    first = 0
    for last in [*np.flatnonzero(holds).tolist(), len(times) - 1]:
        # Of samples with one pose the first is kept, so that the time they take belongs to the motion after them.
        rows = first + np.concatenate(([0], 1 + np.flatnonzero(~still[first:last])))
        if len(rows) > 1 or first == 0:
            seconds = _rising(times[rows], ends=float(times[last]))
            yield from _motions(replace(whole.part(rows), times=seconds), makers)
        if last < len(times) - 1:
            yield Wait(float(times[last]), float(times[last + 1] - times[last]), makers[maker[last + 1]])
        first = last + 1


def _motions(whole: Track, makers: tuple[Source, ...]) -> Iterator[Track | tuple[Reach, ...]]:
    """Cut samples into tracks and joint moves; what follows a joint move begins at its last sample."""
    by_joints = np.isnan(whole.clock)
    borders = np.flatnonzero(np.diff(by_joints)) + 1
    for first, last in pairwise([0, *borders.tolist(), len(by_joints)]):
        if by_joints[first]:
            yield tuple(_legs(whole, first, min(last, len(by_joints) - 1), makers))
        elif last - first > 1 or len(borders) == 0:
            track = whole.part(slice(first, last))
            clock = _rising(track.clock, ends=float(track.clock[-1]))  # a segment takes some time in the plan too
            yield replace(track, clock=clock)


def _legs(whole: Track, first: int, last: int, makers: tuple[Source, ...]) -> Iterator[Reach]:
    """Give the joint motions of samples up to the last one: one to each at which the robot rests."""
    begin = max(first - 1, 0)
    for end in (at for at in range(first, last + 1) if at == last or whole.corner is None or whole.corner[at]):
        way = tuple(
            Moment(float(whole.times[at] - whole.times[begin]), pose_of(whole, at), tuple(whole.joints[at].tolist()))
            for at in range(begin + 1, end + 1)
        )
        joints, start = tuple(whole.joints[end].tolist()), tuple(whole.joints[begin].tolist())
        yield Reach(pose_of(whole, end), joints, makers[whole.maker[end]], way, start)
        begin = end


def _rising(times: Scalars, ends: float) -> Scalars:
    """Give every segment some time, and the last the time of the still samples after it."""
    if len(times) < 2:
        return times
    lasting = np.maximum(np.diff(times), _JUMP_S)
    lasting[-1] = max(lasting[-1], ends - times[-2]) if ends - times[-1] < _SHORTEST_HOLD_S else lasting[-1]
    return times[0] + np.concatenate(([0.0], np.cumsum(lasting)))
