"""The robot of a reader: what it has done so far, and where it is."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.pose import Pose, distance
from programs.posts.reading.rebuilt import (
    ReadBoard,
    ReadLine,
    ReadPause,
    ReadReach,
    ReadRepeat,
    ReadSignal,
    ReadStep,
    ReadTool,
)

SAME_PLACE_MM = 5e-4
"""Places nearer than this are written with the same three decimals."""


@dataclass(slots=True)
class Arm:
    """Collects steps as a reader executes a program."""

    steps: list[ReadStep] = field(default_factory=list[ReadStep])
    pose: Pose | None = None
    tool: ReadTool | None = None
    board: ReadBoard | None = None
    used: tuple[ReadTool | None, ReadBoard | None] = (None, None)
    """The frames of the last motion."""
    jointed: bool = False
    """Whether it came to where it is by joint values, so that the next motion ends where it is."""

    def reach(self, pose: Pose) -> None:
        """Come to a pose by a joint motion."""
        self._frames()
        self.steps.append(ReadReach(pose))
        self.pose, self.jointed = pose, False

    def line(self, pose: Pose, stops: bool, speed_mm_s: float, signals: tuple[ReadSignal, ...] = ()) -> None:
        """Go straight to a pose; after joint values it is there already."""
        if self.jointed or self.pose is None:
            self.reach(pose)
            return
        self._frames()
        self.steps.append(ReadLine(pose, stops, speed_mm_s, signals))
        self.pose = pose

    def length_to(self, pose: Pose) -> float:
        """Millimetres to a pose; 0 where the tool only turns.

        Raises:
            ProgramError: it is not known where the robot is.
        """
        if self.pose is None:
            raise ProgramError("the program moves in a line before it is anywhere.")
        length_mm = distance(self.pose, pose)
        return length_mm if length_mm > SAME_PLACE_MM else 0.0

    def wait(self, seconds: float, longest_s: float) -> None:
        """Hold the pose; what follows a wait of the longest time there is belongs to it."""
        last = self.steps[-1] if self.steps else None
        if isinstance(last, ReadPause) and last.duration_s > 0 and _is_whole(last.duration_s / longest_s):
            self.steps[-1] = ReadPause(last.duration_s + seconds)
        else:
            self.steps.append(ReadPause(seconds))

    def _frames(self) -> None:
        if self.tool is None or self.board is None:
            raise ProgramError("the program moves before it says with which tool and board.")
        if (self.tool, self.board) != self.used:
            self.steps += [self.tool, self.board]
            self.used = (self.tool, self.board)


def _is_whole(value: float) -> bool:
    return value > 0.5 and abs(value - round(value)) < 1e-9


def read_repeat(count: str, condition: Sequence[str | None]) -> ReadRepeat:
    """Begin a loop.

    Args:
        count: How often at most.
        condition: Scale, offset and least value of the quantity as they were read; nothing where it only counts.
    """
    numbers = [float(number) for number in condition if number is not None]
    if len(numbers) < 3:
        return ReadRepeat(int(count), None)
    scale, offset, least = numbers
    return ReadRepeat(int(count), least, (scale, offset))


def split_wait(seconds: float, longest_s: float, digits: int) -> list[float]:
    """Divide a time into waits that an instruction can hold: whole longest ones, then the rest."""
    left, waits = round(seconds, digits), list[float]()
    while left > longest_s:
        waits.append(longest_s)
        left = round(left - longest_s, digits)
    return [*waits, left]
