"""Steps of a robot's controller: lines with events on them, pauses, outputs, loops. Board frame, mm, s."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from math import degrees
from typing import Literal, TypeAlias

import numpy as np

from programs.motion.installation import Channel, Contact, Sensor
from programs.motion.samples import SampledLine
from programs.plan import Origin
from programs.pose import Pose, Position, angle, between, distance
from programs.timing.forecast import SHORT_S
from specs.finding import Finding
from specs.source import Source

Reference: TypeAlias = Literal["start", "end"]
SAME_MM = 1e-6
"""A line shorter than this goes nowhere."""
LEAST_S = 1.05 * SHORT_S
"""Time of a line that languages do not round to less than a short one."""
GOES_MM = 0.3
"""Way of a line from which on the tool turns evenly with that, as controllers turn it."""
RESOLUTION_MM = 2e-3
"""A shorter way may vanish in a robot's program: all languages are given places to 0.001 mm in each coordinate."""


@dataclass(frozen=True, slots=True)
class Event:
    """An output that changes while the line that holds it is driven.

    The signal leaves ``offset_s`` after the TCP is ``offset_mm`` past the reference; both are negative for before.
    """

    channel: Channel
    value: float
    reference: Reference
    offset_mm: float
    offset_s: float
    share: float
    """The place of ``offset_mm`` as a share of the line; also where the line turns on the spot."""
    signal_s: float
    """When it is to leave, seconds from the line's beginning in the planned motion: the offsets as a time."""
    speed_mm_s: float
    """Of the orifice at the requested moment of the jet's begin or end."""
    made_by: Source
    early_s: float = 0.0
    """By how much that is earlier than in the planned motion, as the controller drives otherwise there."""


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """Straight in position and by slerp in orientation, from where the last step ended."""

    start: Pose
    target: Pose
    speed_mm_s: float
    """Commanded speed of the TCP: the plateau that the plan reaches on this line; 0 if it turns on the spot."""
    turn_rad_s: float
    """The plateau of the turn; 0 if it does not turn."""
    blend_mm: float
    """The target is passed within this; 0 is a stop."""
    samples: SampledLine
    time_s: float
    """When it begins, in the program's own time."""
    made_by: Source
    events: tuple[Event, ...] = ()
    """In the order of their signals."""
    even: bool = False
    """Whether the turning axes go evenly along it; then the orientations between its ends are those of its joints."""

    @property
    def length_mm(self) -> float:
        """Way of the orifice."""
        return distance(self.start, self.target)

    @property
    def direction(self) -> Position:
        """Unit vector of the way, of a line that has a length."""
        (x, y, z), (a, b, c), size = self.start.position, self.target.position, self.length_mm
        return ((a - x) / size, (b - y) / size, (c - z) / size)

    @property
    def angle_rad(self) -> float:
        """Angle of the tool's turn."""
        return angle(self.start, self.target)

    @property
    def turns_on_the_spot(self) -> bool:
        """Whether only the orientation changes, as far as a program resolves it: then its speed is that of the turn.

        Of a way that is lost in the last digit no speed can be kept, and it would leave the turn as fast as it can be.
        """
        way = self.length_mm
        return way <= SAME_MM or (way <= RESOLUTION_MM and degrees(self.angle_rad) > way)

    @property
    def duration_s(self) -> float:
        """Planned time."""
        return float(self.samples.seconds[-1])

    @property
    def joints(self) -> tuple[float, ...]:
        """At the target; empty if not known."""
        return tuple(self.samples.joints[-1].tolist())

    def pose_at(self, share: float) -> Pose:
        """Pose where this share of the line is done."""
        return between(self.start, self.target, share)

    def speed_at(self, seconds: float) -> float:
        """Planned speed of the orifice, mm/s."""
        if self.turns_on_the_spot:
            return 0.0
        times = self.samples.seconds
        at = int(np.clip(np.searchsorted(times, seconds, side="right"), 1, len(times) - 1))
        rate = (self.samples.shares[at] - self.samples.shares[at - 1]) / (times[at] - times[at - 1])
        return float(rate) * self.length_mm


@dataclass(frozen=True, slots=True)
class Moment:
    """Where a robot is during a joint motion."""

    seconds: float
    """Since its beginning."""
    pose: Pose
    joints: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Reach:
    """Come to this pose by a joint motion: first, after a new tool or board or a call, and to another configuration."""

    target: Pose
    joints: tuple[float, ...]
    """Empty if not known."""
    made_by: Source
    way: tuple[Moment, ...] = ()
    """The planned motion where it is known, its end included."""
    start: tuple[float, ...] = ()
    """Joints where that motion begins; empty if not known."""

    @property
    def duration_s(self) -> float:
        """Planned time; 0 where the motion is not known."""
        return self.way[-1].seconds if self.way else 0.0


@dataclass(frozen=True, slots=True)
class Pause:
    """Hold the pose."""

    duration_s: float
    made_by: Source


@dataclass(frozen=True, slots=True)
class Switch:
    """Set an output while the robot stands."""

    channel: Channel
    value: float
    made_by: Source
    what: str = ""
    """The command it comes from, such as ``pressure_bar = 3.500``; empty for a valve."""


@dataclass(frozen=True, slots=True)
class UseTool:
    """The TCP is that of this tool from now on."""

    number: int
    nozzle: str
    made_by: Source


@dataclass(frozen=True, slots=True)
class Mount:
    """Have this tool mounted: the robot goes on when it is on the flange."""

    number: int
    nozzle: str
    made_by: Source

    @property
    def words(self) -> str:
        """The message for a person."""
        return f"mount tool {self.number} {self.nozzle}"


@dataclass(frozen=True, slots=True)
class Hold:
    """Stop until the operator goes on: before a step of the sequence, in a first run."""

    number: int
    """Of the step, from 1."""
    made_by: Source

    @property
    def words(self) -> str:
        """The message for a person."""
        return f"first run step {self.number}"


@dataclass(frozen=True, slots=True)
class Await:
    """Wait for a contact, as long as it takes."""

    contact: Contact
    state: bool
    made_by: Source


@dataclass(frozen=True, slots=True)
class UseBoard:
    """The board lies elsewhere from now on."""

    placement: str
    """The ``CALL`` that moved it; empty for where it lies first."""
    T_base_board: Pose
    made_by: Source


@dataclass(frozen=True, slots=True)
class Call:
    """Run a routine that the integrator provides."""

    name: str
    made_by: Source


@dataclass(frozen=True, slots=True)
class Repeat:
    """Do what follows up to EndRepeat at least once and at most ``count`` times, until the sensor shows ``least``."""

    count: int
    key: str
    least: float
    sensor: Sensor | None
    """``None`` where the cell has no such input: then all ``count`` are done."""
    made_by: Source


@dataclass(frozen=True, slots=True)
class EndRepeat:
    """The end of the innermost Repeat."""

    made_by: Source


@dataclass(frozen=True, slots=True)
class Note:
    """A comment for the reader of the program: FUNCTION, SOLUTION, and what has no channel."""

    text: str
    made_by: Source


Step: TypeAlias = (
    Line | Reach | Pause | Switch | Mount | Hold | Await | UseTool | UseBoard | Call | Repeat | EndRepeat | Note
)


IsClear: TypeAlias = Callable[[tuple[tuple[float, ...], ...], int, str], bool]
"""Whether joints (radians, mm) go straight from row to row clear of everything, with a tool and a place of a board."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionProgram:
    """A program as steps, with the findings of its making."""

    origin: Origin
    duration_s: float
    """As planned, each loop once."""
    steps: tuple[Step, ...]
    findings: tuple[Finding, ...]
    is_clear: IsClear | None = None
    """Check of the ways from home into the program; ``None`` where there is none."""
    first_run: str = ""
    """How it differs from the program that it is the first run of, with ``; `` between; empty where it is none."""

    @property
    def lines(self) -> tuple[Line, ...]:
        """The straight lines, in order."""
        return tuple(step for step in self.steps if isinstance(step, Line))


def split_line(line: Line, shares: tuple[float, ...], blend_mm: float) -> list[Line]:
    """Divide a line at collinear points that are passed within ``blend_mm``; its events are left out.

    Args:
        line: The line.
        shares: Where, increasing, each between 0 and 1 and none of them either.
        blend_mm: Zone at the new points.
    """
    poses = [line.start, *(line.pose_at(share) for share in shares), line.target]
    parts: list[Line] = []
    for number, (begin, end) in enumerate(pairwise((0.0, *shares, 1.0))):
        part = replace(line, start=poses[number], target=poses[number + 1], samples=_part_of(line.samples, begin, end))
        if end < 1.0:
            part = replace(part, blend_mm=blend_mm)
        if begin > 0.0:
            part = replace(part, time_s=line.time_s + line.samples.second_at(begin))
        parts.append(replace(part, events=()))
    return parts


def limit_speed(line: Line, least_s: float = LEAST_S, share: float = 1.0, lasts_s: float = 0.0) -> Line:
    """Command a line no faster than evenly in 21 ms, or in its time if that is less: at that speed it is no short move.

    Args:
        line: The line.
        least_s: A line that takes less is left as it is.
        share: Of the line that is commanded by itself.
        lasts_s: Time of that share; 0 for the line's.
    """
    lasts_s = lasts_s or line.duration_s
    if lasts_s < least_s:
        return line
    even_s = min(lasts_s, LEAST_S)
    speed, turn = share * line.length_mm / even_s, share * line.angle_rad / even_s
    return replace(line, speed_mm_s=min(line.speed_mm_s, speed), turn_rad_s=min(line.turn_rad_s, turn))


def _part_of(samples: SampledLine, begin: float, end: float) -> SampledLine:
    """The stretch of a line between two shares, counted from its own beginning."""
    first = samples.second_at(begin) if begin else 0.0
    last = samples.second_at(end) if end < 1 else samples.seconds[-1]
    inside = (samples.seconds > first + 1e-9) & (samples.seconds < last - 1e-9)
    seconds = np.concatenate(([first], samples.seconds[inside], [last]))
    shares = np.concatenate(([begin], samples.shares[inside], [end]))
    return SampledLine(
        seconds=seconds - first,
        shares=np.clip((shares - begin) / (end - begin), 0.0, 1.0),
        joints=samples.joints_when(seconds),
    )
