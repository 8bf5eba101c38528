"""A timed program cut where the robot has to stand: stretches of motion, pauses, commands, wishes for the jet."""

from dataclasses import dataclass, field
from math import dist, inf
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.frames import align_signs, rotation_angles
from programs.motion.tracks import Track
from programs.playback import ToolStates, build_timeline, play
from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait
from programs.soundness import TICK_S

_STILL_MM, _STILL_RAD = 1e-6, 1e-6
"""Samples nearer than this are one pose."""
_SHORTEST_HOLD_S = 0.02
"""A pose held for less is the slow beginning or end of a motion, rounded."""
_JUMP_S = 1e-4
"""A move that takes no time is given this: nothing moves at once."""


@dataclass(frozen=True, slots=True)
class Hold:
    """The pose is held: a WAIT, or the same pose twice."""

    time_s: float
    duration_s: float
    made_by: str


@dataclass(frozen=True, slots=True)
class Wanted:
    """The jet is wanted, or no longer, at this time; it stands after all that is done by then."""

    time_s: float
    spraying: bool
    made_by: str


Item: TypeAlias = Track | Hold | Wanted | Command


@dataclass(frozen=True, slots=True)
class Layout:
    """Items in order. A ``Wanted`` that falls into a track or a hold stands right after it."""

    items: tuple[Item, ...]
    makers: tuple[str, ...]
    """What ``Track.maker`` counts."""


def lay_out(program: TimedProgram, joints: NDArray[np.float64]) -> Layout:
    """Cut a program at everything that happens at rest.

    Args:
        program: Any sound program.
        joints: (moves, dof) aligned with its moves; dof is 0 where they are not known.

    Raises:
        ProgramError: the program has no move.
    """
    cuts = [item for item in program.instructions if isinstance(item, Wait | Command)]
    states = play(build_timeline(program), np.array([item.time_s for item in cuts]))
    moves = [item for item in program.instructions if isinstance(item, MoveTo)]
    targets, due = [(*move.position, *move.quaternion) for move in moves], [move.time_s for move in moves]
    layer = _Layer(states, joints, targets, [*due, inf])
    for instruction in program.instructions:
        match instruction:
            case MoveTo():
                layer.move(instruction)
            case Wait():
                layer.wait(instruction)
            case Command():
                layer.command(instruction)
            case SetNozzle():
                layer.want(instruction)
    layer.cut()
    return Layout(tuple(layer.items), tuple(layer.makers))


@dataclass(slots=True)
class _Layer:
    """The samples of the stretch that is being laid, and what lies before it."""

    states: ToolStates
    """At every wait and command, in order."""
    joints: NDArray[np.float64]
    targets: list[tuple[float, ...]]
    """Poses of all moves."""
    due: list[float]
    """Times of all moves, then infinity."""
    items: list[Item] = field(default_factory=list[Item])
    makers: dict[str, int] = field(default_factory=dict[str, int])
    times: list[float] = field(default_factory=list[float])
    poses: list[tuple[float, ...]] = field(default_factory=list[tuple[float, ...]])
    maker: list[int] = field(default_factory=list[int])
    node: list[float] = field(default_factory=list[float])
    """Row of the joints that belongs to each sample; between two rows where it lies between two moves."""
    wanted: list[Wanted] = field(default_factory=list[Wanted])
    tool: str = ""
    """Number of the tool that is carried."""
    asked: int = 0
    """How many waits and commands are behind."""
    moved: int = 0
    """How many moves are behind."""

    def move(self, move: MoveTo) -> None:
        """Lay the pose of a move."""
        self.moved += 1
        self.sample(move.time_s, (*move.position, *move.quaternion), move.made_by)

    def wait(self, wait: Wait) -> None:
        """Hold the pose reached, then go on from it."""
        done = self.is_due(wait.time_s + wait.duration_s)
        pose = self.arrive(wait.time_s, wait.made_by, self.targets[self.moved] if done else ())
        self.cut()
        if wait.duration_s > 0:
            self.items.append(Hold(wait.time_s, wait.duration_s, wait.made_by))
        if pose:
            self.sample(wait.time_s + wait.duration_s, pose, wait.made_by)

    def command(self, command: Command) -> None:
        """Stand while a command is carried out."""
        tool = command.arguments[2] if command.keyword == "NOZZLE" else self.tool
        done = self.is_due(command.time_s)
        # Another orifice, or a board that was moved: where it is now, only a move at the same time says.
        elsewhere = done and (command.keyword == "CALL" or tool != self.tool)
        self.tool = tool
        pose = self.arrive(command.time_s, command.made_by, self.targets[self.moved] if done and not elsewhere else ())
        self.cut()
        self.items.append(command)
        if pose and not elsewhere:
            self.sample(command.time_s, pose, command.made_by)

    def want(self, switch: SetNozzle) -> None:
        """Remember what is wanted of the jet until the stretch is cut."""
        self.wanted.append(Wanted(switch.time_s, switch.spraying, switch.made_by))
        if not self.times:
            self.cut()

    def is_due(self, time_s: float) -> bool:
        """Whether the next move is done by then, but for less than a file can tell."""
        return self.due[self.moved] < time_s + 0.5 * TICK_S

    def arrive(self, time_s: float, made_by: str, target: tuple[float, ...]) -> tuple[float, ...]:
        """Lay the pose at the time of a wait or a command; give it, empty where only the next move says it.

        Args:
            time_s: When.
            made_by: Who asked for it.
            target: Where the next move ends, if that is all but reached.
        """
        at = self.asked
        self.asked += 1
        if not self.times:
            return ()
        if time_s > self.times[-1] + TICK_S:
            there = (*self.states.tcp[at].tolist(), *self.states.quaternion[at].tolist())
            self.sample(time_s, target or there, made_by)
        return self.poses[-1]

    def sample(self, time_s: float, pose: tuple[float, ...], made_by: str) -> None:
        """Add a sample."""
        self.times.append(time_s)
        self.poses.append(pose)
        self.maker.append(self.makers.setdefault(made_by, len(self.makers)))
        self.node.append(self.row_of(pose))

    def row_of(self, pose: tuple[float, ...]) -> float:
        """Say which row of the joints belongs to a pose between the last move and the next."""
        before, after = self.targets[self.moved - 1], self.targets[min(self.moved, len(self.targets) - 1)]
        done, left = _apart(before, pose), _apart(pose, after)
        return self.moved - 1 + (done / (done + left) if done > _STILL_MM else 0.0)

    def cut(self) -> None:
        """End the stretch; what was wanted during it follows it."""
        if self.times:
            self.items += _stretch(self)
            self.times, self.poses, self.maker, self.node = [], [], [], []
        self.items += self.wanted
        self.wanted = []


def _apart(one: tuple[float, ...], other: tuple[float, ...]) -> float:
    """How far two poses are from each other, in mm and units of a quaternion, whichever sign that has."""
    x, y, z, *turn = other
    return min(dist(one, other), dist(one, (x, y, z, *(-value for value in turn))))


def _stretch(layer: _Layer) -> list[Item]:
    """Tracks and holds of the samples laid; each track begins where the one before it ended."""
    poses = np.array(layer.poses)
    quaternion = align_signs(poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1, keepdims=True))
    times = np.array(layer.times)
    still = np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1) <= _STILL_MM
    still &= rotation_angles(quaternion[:-1], quaternion[1:]) <= _STILL_RAD
    holds = still & (np.diff(times) >= _SHORTEST_HOLD_S)
    makers = tuple(layer.makers)
    items: list[Item] = []
    first = 0
    for last in [*np.flatnonzero(holds).tolist(), len(times) - 1]:
        # Of samples with one pose the first is kept, so that the time they take belongs to the motion after them.
        rows = first + np.concatenate(([0], 1 + np.flatnonzero(~still[first:last])))
        if len(rows) > 1 or not items:
            clock = _rising(times[rows], ends=float(times[last]))
            maker = np.array(layer.maker)[rows]
            joints = _between_rows(layer.joints, np.array(layer.node)[rows])
            items.append(Track(clock, poses[rows, :3], quaternion[rows], maker, joints))
        if last < len(times) - 1:
            hold = Hold(float(times[last]), float(times[last + 1] - times[last]), makers[layer.maker[last + 1]])
            items.append(hold)
        first = last + 1
    return items


def _between_rows(joints: NDArray[np.float64], node: NDArray[np.float64]) -> NDArray[np.float64]:
    low = np.floor(node).astype(np.int64)
    high = np.minimum(low + 1, len(joints) - 1)
    return joints[low] + (node - low)[:, None] * (joints[high] - joints[low])


def _rising(times: NDArray[np.float64], ends: float) -> NDArray[np.float64]:
    """Give every segment some time, and the last the time of the still samples after it."""
    if len(times) < 2:
        return times
    lasting = np.maximum(np.diff(times), _JUMP_S)
    lasting[-1] = max(lasting[-1], ends - times[-2]) if ends - times[-1] < _SHORTEST_HOLD_S else lasting[-1]
    return times[0] + np.concatenate(([0.0], np.cumsum(lasting)))
