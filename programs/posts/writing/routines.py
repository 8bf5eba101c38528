"""What posts have in common that write one statement after the other."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.motion.installation import Channel, Installation
from programs.motion.steps_of_robot import (
    Call,
    Event,
    Line,
    MotionProgram,
    Pause,
    Reach,
    Step,
    Switch,
    UseBoard,
    UseTool,
)
from programs.pose import Pose
from programs.posts.writing.axes import in_controller_units
from programs.posts.writing.chapters import Chapter
from programs.posts.writing.wording import fixed, make_name


@dataclass(slots=True)
class Names:
    """The names given so far; a thing has the same name each time, unlike all others."""

    longest: int
    """Characters that the language allows."""
    taken: set[str]
    """Names in use, and the words of the language; lower case."""
    given: dict[tuple[str, object], str] = field(default_factory=dict[tuple[str, object], str])

    def give(self, kind: str, key: object, wanted: str) -> str:
        """Name a thing."""
        if (kind, key) not in self.given:
            chosen = make_name(wanted, self.longest, self.taken)
            self.taken.add(chosen.lower())
            self.given[kind, key] = chosen
        return self.given[kind, key]

    def reserve_calls(self, motion: MotionProgram) -> None:
        """Name the integrator's routines first: only theirs have names that are known outside the program."""
        for step in motion.steps:
            if isinstance(step, Call):
                self.give("call", step.name, step.name)

    def routine(self, chapter: Chapter) -> str:
        """Name the routine of a chapter."""
        title = make_name(chapter.title, self.longest - 3).rstrip("_")
        return self.give("routine", chapter.number, f"{title}_{chapter.number:02d}")


@dataclass(frozen=True, slots=True)
class Placed:
    """A step, and where on it outputs change."""

    step: Step
    begins: tuple[Event, ...] = ()
    """Where it begins: its own, and those of the end of the line before it if that is passed."""
    inside: tuple[Event, ...] = ()
    ends: tuple[Event, ...] = ()
    """Where it stops."""


def place_events(steps: Sequence[Step]) -> Iterator[Placed]:
    """Give what changes in a line's last moment to the next line, unless the robot stops there."""
    carried: tuple[Event, ...] = ()
    for step in steps:
        if not isinstance(step, Line):
            yield Placed(step)
            continue
        begins = (*carried, *(event for event in step.events if event.share <= 0.0))
        inside = tuple(event for event in step.events if 0.0 < event.share < 1.0)
        last = tuple(event for event in step.events if event.share >= 1.0)
        carried = last if step.blend_mm > 0.0 else ()
        yield Placed(step, begins, inside, () if carried else last)


def tell_steps(
    steps: Sequence[Step], comment: Callable[[str], str], write: Callable[[Step], Iterable[str]]
) -> list[str]:
    """Write steps, and the recipe path wherever another one moves the robot."""
    lines: list[str] = []
    maker = ""
    for step in steps:
        if step.made_by != maker and isinstance(step, Line | Reach | Pause):
            maker = step.made_by
            lines.append(comment(maker))
        lines += write(step)
    return lines


def tell(steps: Sequence[Step], comment: Callable[[str], str], write: Callable[[Placed], Iterable[str]]) -> list[str]:
    """Write steps as ``tell_steps`` does, with the places where outputs change."""
    placed = place_events(steps)
    return tell_steps(steps, comment, lambda _: write(next(placed)))


@dataclass(slots=True)
class Slots:
    """The controller's numbers for tools and places of the board, and those in use."""

    tools: dict[int, int]
    """By the number in ``NOZZLE name TOOL number``: the same where the controller has it, else the first free one."""
    boards: dict[str, tuple[int, Pose]]
    """Number, from 1 in the order of use, and ``T_base_board``, by the placement."""
    tool: int = 0
    board: int = 0

    def use(self, step: UseTool | UseBoard | None) -> None:
        """Use another tool or board from now on."""
        if isinstance(step, UseTool):
            self.tool = self.tools[step.number]
        elif isinstance(step, UseBoard):
            self.board = self.boards[step.placement][0]


def number_slots(motion: MotionProgram, most: int) -> Slots:
    """Number the tools and boards of a program.

    Args:
        motion: The program.
        most: Numbers that the controller has, from 1.

    Raises:
        ProgramError: they are too few.
    """
    boards: dict[str, tuple[int, Pose]] = {}
    numbers = list(dict.fromkeys(step.number for step in motion.steps if isinstance(step, UseTool)))
    for step in motion.steps:
        if isinstance(step, UseBoard) and step.placement not in boards:
            boards[step.placement] = (len(boards) + 1, step.T_base_board)
    if max(len(numbers), len(boards)) > most:
        used = f"{len(numbers)} tools and {len(boards)} places of the board"
        raise ProgramError(f"the program uses {used}; this controller has {most} of each.")
    tools = {number: number for number in numbers if 1 <= number <= most}
    free = iter([slot for slot in range(1, most + 1) if slot not in tools])
    return Slots({number: tools[number] if number in tools else next(free) for number in numbers}, boards)


def joint_words(joints: tuple[float, ...], installation: Installation, digits: int) -> list[str]:
    """Write joint values: degrees and mm."""
    return [fixed(value, digits) for value in in_controller_units(joints, installation)]


def turn_limit(line: Line) -> float | None:
    """Rate that a turn may have where it is not to slow the line down, degrees/s; ``None`` where it hardly turns.

    A tenth more than planned on a line with a length, so that the speed of the TCP decides; rounded up to a tenth.
    """
    if line.turns_on_the_spot:
        return degrees_per_s(line)
    if math.degrees(line.angle_rad) <= 0.5:
        return None
    return max(math.ceil(11.0 * math.degrees(line.turn_rad_s)) / 10.0, 0.1)


def degrees_per_s(line: Line) -> float:
    """Rate of a line's turn, rounded up to a tenth so that rounding never slows it down; at least 0.1."""
    return max(math.ceil(10.0 * math.degrees(line.turn_rad_s)) / 10.0, 0.1)


def outputs_of(motion: MotionProgram) -> list[str]:
    """List the outputs that a program sets, by name, for its header."""
    return [f"Output {channel.name}: {channel.kind} {channel.number}" for channel in channels_of(motion)]


def channels_of(motion: MotionProgram) -> list[Channel]:
    """Give the outputs that a program sets, by kind and number."""
    used = {step.channel: None for step in motion.steps if isinstance(step, Switch)}
    used |= {event.channel: None for line in motion.lines for event in line.events}
    return sorted(used, key=lambda channel: (channel.kind, channel.number))
