"""The skeleton of every reader: what the statements of all languages do to motion and outputs."""

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose, Quaternion, distance
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.frame import FrameReader
from programs.posts.rebuilt import (
    Axes,
    Due,
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadHome,
    ReadLine,
    ReadPause,
    ReadReach,
    ReadRepeat,
    ReadSignal,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)

_SAME_PLACE_MM = 5e-4
"""Places nearer than this are written with the same three decimals."""

_MOST_DEGREES = 360.0
_UNIT = 3e-7
"""How far the length of a quaternion with seven decimals may be off."""


class Reader(FrameReader, ABC):
    """A controller while it executes one program; a language is a subclass with a grammar."""

    writes_lines: ClassVar[bool] = True
    """Whether a line of the plan is one motion, and not several of the axes."""
    goes_home: ClassVar[bool] = True
    """Whether the language can go to joint values, as those of home."""
    home_in_tool_points: ClassVar[bool] = True
    """Whether home is a tool point too, where the cell's controller takes those."""

    def __init__(self) -> None:
        super().__init__()
        self.homes: list[ReadHome] = []
        """Motions to joint values; those from which a pose is reached are taken out again."""
        self.rise_mm: float | None = None
        """Height to which the orifice is raised before anything else moves."""
        self.pose: Pose | None = None
        self.tool: ReadTool | None = None
        self.board: ReadBoard | None = None
        self.counted: tuple[float, ...] = ()
        """Joint values that it came to, as the controller counts them, degrees or mm: the next motion ends there.

        Empty where the last motion was no such one."""
        self.speed_share: float | None = None
        """Of joint motions, where their speed is modal or that of the last one to joint values."""
        self.lasts_s: float | None = None
        """Time that the last motion to joint values states."""
        self.terms = ReadLine(Axes(()), None, None)
        """Zone, turn rate and acceleration that are in force, or that the line to come states."""
        self.counters: dict[str, int] = {}
        """How often a loop's counter was raised, since it was set to 0."""
        self.loops: list[str] = []
        """Counters of the loops that run; empty for one that counts by itself."""
        self._used: tuple[ReadTool | None, ReadBoard | None] = (None, None)

    @classmethod
    def rebuild(cls, files: ProgramFiles) -> Rebuilt:
        """Execute a program's files, each loop once.

        Raises:
            ProgramError: a file is missing, or a statement is not as the writer writes it.
        """
        reader, main = cls.loaded(files)
        reader.run(main)
        steps, places = tuple(reader.steps), tuple(reader.places)
        frame = reader.read_frame(files)
        reader.finish()
        return Rebuilt(
            steps,
            places=places,
            frame=frame,
            dues=cls.due if cls.writes_lines else None,
            rise_mm=reader.rise_mm,
            homes=tuple(reader.homes) if cls.goes_home else None,
            home_in_tool_points=cls.home_in_tool_points,
        )

    @classmethod
    @abstractmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give what the text of a line has to state; another line may come right after it."""

    def finish(self) -> None:
        """Make sure at the end that nothing is left over.

        Raises:
            ProgramError: a loop has no end, a routine was never called, or a declaration was not used.
        """
        if self.loops:
            raise ProgramError("a loop has no end.")
        super().finish()

    # Statements that many languages have

    def refuse(self, match: re.Match[str]) -> None:
        """Refuse a statement."""
        raise ProgramError(f"unknown statement {match[0]!r}.")

    def call(self, match: re.Match[str]) -> None:
        """Call a routine by its name: one of the program's, or one of the integrator's."""
        if match[1] in self.routines:
            self.run(match[1])
        else:
            self.steps.append(ReadCall(match[1]))

    def pause(self, match: re.Match[str]) -> None:
        """Hold the pose for so many seconds."""
        self.steps.append(ReadPause(float(match[1])))

    def hold(self, seconds: float, longest_s: float) -> None:
        """Hold the pose; what follows a wait of the longest time there is belongs to it."""
        last = self.steps[-1] if self.steps else None
        waits = last.duration_s / longest_s if isinstance(last, ReadPause) else 0.0
        if isinstance(last, ReadPause) and waits > 0.5 and abs(waits - round(waits)) < 1e-9:
            self.steps[-1] = ReadPause(last.duration_s + seconds)
        else:
            self.steps.append(ReadPause(seconds))

    def switch(self, channel: str, value: float) -> None:
        """Set an output."""
        self.steps.append(ReadSwitch(channel, value))

    def use_tool(self, label: str, T_flange_tcp: Pose | None) -> None:  # noqa: N803
        """Use another tool from now on; its pose is not known where it is in the controller's table."""
        self.tool = ReadTool(label, T_flange_tcp)

    def use_board(self, T_base_board: Pose | None) -> None:  # noqa: N803
        """Use another frame from now on."""
        self.board = ReadBoard(T_base_board)

    # Loops

    def set_counter(self, match: re.Match[str]) -> None:
        """Set a loop's counter, the first group, to 0."""
        self.counters[match[1]] = 0

    def raise_counter(self, match: re.Match[str]) -> None:
        """Raise the counter, the first group, of the innermost loop.

        Raises:
            ProgramError: it is that of another one.
        """
        if not self.loops or self.loops[-1] != match[1]:
            raise ProgramError(f"{match[0]!r} does not count the innermost loop.")
        self.counters[match[1]] += 1

    def repeat(self, count: str, condition: Sequence[str | None] = (), counter: str = "") -> None:
        """Begin a loop.

        Args:
            count: How often at most.
            condition: Scale, input, offset and least value of the quantity; nothing where the loop only counts.
            counter: Its name; empty where the loop counts by itself.

        Raises:
            ProgramError: the counter was not set to 0.
        """
        if counter and self.counters.get(counter) != 0:
            raise ProgramError(f"the counter {counter} is not 0 where its loop begins.")
        self.loops.append(counter)
        words = [word for word in condition if word is not None]
        if not words:
            self.steps.append(ReadRepeat(int(count), None))
            return
        scale, channel, offset, least = words
        self.steps.append(ReadRepeat(int(count), float(least), (float(scale), float(offset)), channel))

    def end_repeat(self, match: re.Match[str]) -> None:
        """End the innermost loop.

        Raises:
            ProgramError: there is none, or it was not counted once.
        """
        counter = self.loops.pop() if self.loops else None
        if counter is None or (counter and self.counters.pop(counter) != 1):
            raise ProgramError(f"{match[0]!r} ends no loop, or one that is not counted once.")
        self.steps.append(ReadEndRepeat())

    # Joint motions

    def move_joints(self, match: re.Match[str]) -> None:
        """Come to joint values: a list with commas in the first group, percents of the speed in the last of more."""
        if match.re.groups > 1:
            self.set_share(match[match.re.groups])
        self.come_to(float(word) for word in match[1].split(","))

    def set_share(self, percent: str) -> None:
        """Set the speed of joint motions.

        Raises:
            ProgramError: it is none.
        """
        self.speed_share = 0.01 * float(percent)
        if not 0.0 < self.speed_share <= 1.0:
            raise ProgramError(f"{percent} percent is no speed of a joint motion.")

    def move_to(self, place: Pose | tuple[float, ...]) -> None:
        """Come to a pose, or to joint values, by a joint motion."""
        if isinstance(place, Pose):
            self.reach(place)
        else:
            self.come_to(place)

    def come_to(self, counted: Iterable[float]) -> None:
        """Come to joint values, as the controller counts them."""
        self.counted = self.come_home(counted)

    def come_home(self, counted: Iterable[float]) -> tuple[float, ...]:
        """Come to joint values from which no pose is reached, and give them."""
        joints = tuple(counted)
        self.homes.append(ReadHome(len(self.steps), joints, self.speed_share))
        return joints

    def reach(self, pose: Pose, counted: tuple[float, ...] = ()) -> None:
        """Come to a pose by a joint motion: to joint values, or to the pose itself where there are none."""
        if counted:
            self.homes.pop()
        self._use_frames()
        self.steps.append(ReadReach(pose, counted, self.speed_share, self.lasts_s))
        self.pose, self.counted, self.lasts_s = pose, (), None

    # Straight motions

    def rise(self, *patterns: str, unit_mm: float = 1.0) -> None:
        """Read how the orifice is raised before anything else moves; each pattern has one group, the height.

        Raises:
            ProgramError: the statements are others, or differ in their height.
        """
        heights = {found[1] for found in self.pass_on(*patterns)}
        if len(heights) != 1:
            raise ProgramError("the orifice is compared with one height and raised to another.")
        self.raise_to(unit_mm * float(heights.pop()))

    def raise_to(self, height_mm: float) -> None:
        """Raise the orifice to a height before anything else moves.

        Raises:
            ProgramError: something moved before.
        """
        if self.steps or self.homes or self.rise_mm is not None:
            raise ProgramError("the orifice is raised after other motions.")
        self.rise_mm = height_mm

    def line(self, pose: Pose, stops: bool, speed_mm_s: float, signals: tuple[ReadSignal, ...] = ()) -> None:
        """Go straight to a pose, under ``terms``; after joint values it is there already."""
        if self.counted or self.pose is None:
            self.reach(pose, self.counted)
            return
        self._use_frames()
        zone = 0.0 if stops else self.terms.zone
        self.steps.append(
            replace(self.terms, target=pose, stops=stops, speed_mm_s=speed_mm_s, signals=signals, zone=zone)
        )
        self.pose = pose

    def state(self, **terms: float | None) -> None:
        """Put terms of lines in force: ``zone``, ``turn_deg_s``, ``duration_s``, and accelerations."""
        self.terms = replace(self.terms, **terms)  # pyright: ignore[reportArgumentType]

    def length_to(self, pose: Pose) -> float:
        """Millimetres to a pose; 0 where the tool only turns, and where the robot's own pose is not known."""
        length_mm = distance(self.pose, pose) if self.pose is not None else 0.0
        return length_mm if length_mm > _SAME_PLACE_MM else 0.0

    def _use_frames(self) -> None:
        if self.tool is None or self.board is None:
            raise ProgramError("the program moves before it selects a tool and a frame.")
        if (self.tool, self.board) != self._used:
            self.steps += [self.tool, self.board]
            self._used = (self.tool, self.board)


def checked(quaternion: Quaternion) -> Quaternion:
    """Give a quaternion that is of unit length to its digits, as controllers demand it.

    Raises:
        ProgramError: it is not.
    """
    if abs(math.hypot(*quaternion) - 1.0) > _UNIT:
        raise ProgramError(f"the quaternion {quaternion} is not of unit length.")
    return quaternion


def read_pose(numbers: Iterable[str], orientation: Callable[[float, float, float], Quaternion]) -> Pose:
    """Read a pose: x, y, z in mm, then the angles of a maker."""
    x, y, z, a, b, c = map(float, numbers)
    if max(map(abs, (a, b, c))) > _MOST_DEGREES:
        raise ProgramError("an angle of a pose is more than a turn.")
    return Pose((x, y, z), orientation(a, b, c))
