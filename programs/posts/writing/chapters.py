"""A long program in routines that a controller can hold, and a main that calls them."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count, pairwise
from typing import TypeAlias, TypeGuard

from programs.motion.steps import EndRepeat, Event, Line, MotionProgram, Note, Reach, Repeat, Step, UseBoard, UseTool


@dataclass(frozen=True, slots=True, eq=False)
class Chapter:
    """Steps that run one after the other; the robot stands at the beginning and at the end."""

    number: int
    """From 1, in the order of the program."""
    title: str
    """The function it serves; ``start`` before the first."""
    steps: tuple[Step, ...]
    tool: UseTool | None
    """In use when it begins; ``None`` before the first."""
    board: UseBoard | None
    """Where the board lies when it begins; ``None`` before the first."""


Part: TypeAlias = Chapter | Repeat | EndRepeat
"""A part of main: run a chapter, or begin or end a loop around some."""


@dataclass(frozen=True, slots=True)
class LoopEnd:
    """One end of a loop of main."""

    number: int
    """Of the loop, from 1 in the order of the program."""
    loop: Repeat
    begins: bool


def nest(parts: tuple[Part, ...]) -> Iterator[tuple[str, Chapter | LoopEnd]]:
    """Number the loops of main and match ends with beginnings; with the indentation at which each part stands."""
    begun: list[LoopEnd] = []
    numbers = count(1)
    for part in parts:
        indent = "  " * len(begun)
        match part:
            case Chapter():
                yield indent, part
            case Repeat():
                begun.append(LoopEnd(next(numbers), part, begins=True))
                yield indent, begun[-1]
            case EndRepeat():
                yield indent[2:], replace(begun.pop(), begins=False)


def divide(motion: MotionProgram, most_steps: int) -> tuple[Part, ...]:
    """Divide a program at loops, at functions, and where the robot stands when a routine has grown long.

    Where it never stands for so long, it is made to stop.

    Args:
        motion: The program.
        most_steps: Of one routine.
    """
    parts: list[Part] = []
    numbers, title = count(1), "start"
    tool: UseTool | None = None
    board: UseBoard | None = None
    for piece in _pieces(motion.steps, most_steps):
        if isinstance(piece, Repeat | EndRepeat):
            parts.append(piece)
            continue
        title = next((name for name in map(_function, piece) if name), title)
        parts.append(Chapter(next(numbers), title, tuple(piece), tool, board))
        tool, board = _frames_after(piece, tool, board)
    return tuple(parts)


def rest_within(motion: MotionProgram, most_steps: int) -> tuple[MotionProgram, int]:
    """Let the robot stand at least once in so many steps, so that routines can end there.

    Args:
        motion: The program, before it is lowered.
        most_steps: Of one routine; 0 where that is not limited.

    Returns:
        The program, and how many of its lines stop for that alone.
    """
    steps: list[Step] = []
    passed = stops = 0
    for step in motion.steps:
        passed = passed + 1 if _passes(step) else 0
        if most_steps and passed >= max(most_steps // 2, 1):  # lowering divides lines
            steps.append(replace(step, blend_mm=0.0))
            passed, stops = 0, stops + 1
        else:
            steps.append(step)
    return (replace(motion, steps=tuple(steps)) if stops else motion), stops


def _pieces(steps: tuple[Step, ...], most: int) -> Iterator[list[Step] | Repeat | EndRepeat]:
    piece: list[Step] = []
    for step in steps:
        moves = bool(_function(step)) and any(
            isinstance(each, Line) or (isinstance(each, Reach) and each.way) for each in piece
        )
        if piece and (isinstance(step, Repeat | EndRepeat) or moves):
            yield piece
            piece = []
        if isinstance(step, Repeat | EndRepeat):
            yield step
            continue
        piece.append(step)
        if len(piece) >= most:
            stands = (at for at in range(len(piece), 0, -1) if not _passes(piece[at - 1]))
            end = next(stands, len(piece))
            if _passes(last := piece[end - 1]):
                piece[-1] = replace(last, blend_mm=0.0)
            yield piece[:end]
            piece = piece[end:]
    if piece:
        yield piece


def _passes(step: Step) -> TypeGuard[Line]:
    """Whether the robot does not stand after a step."""
    return isinstance(step, Line) and step.blend_mm > 0.0


def _function(step: Step) -> str:
    return step.text.removeprefix("function ") if isinstance(step, Note) and step.text.startswith("function ") else ""


def part_at_boards(parts: tuple[Part, ...]) -> tuple[Part, ...]:
    """Divide chapters where the board is put elsewhere, for languages in which a routine has one user frame."""
    pieces = [piece for part in parts for piece in (_by_board(part) if isinstance(part, Chapter) else [part])]
    numbers = count(1)
    return tuple(replace(piece, number=next(numbers)) if isinstance(piece, Chapter) else piece for piece in pieces)


def _by_board(chapter: Chapter) -> Iterator[Chapter]:
    first = next((at for at, step in enumerate(chapter.steps) if isinstance(step, Line | Reach)), len(chapter.steps))
    cuts = [at for at, step in enumerate(chapter.steps) if isinstance(step, UseBoard) and at > first]
    tool, board = chapter.tool, chapter.board
    for begin, end in pairwise([0, *cuts, len(chapter.steps)]):
        steps = chapter.steps[begin:end]
        yield replace(chapter, steps=steps, tool=tool, board=board)
        tool, board = _frames_after(steps, tool, board)


def _frames_after(
    steps: Sequence[Step], tool: UseTool | None, board: UseBoard | None
) -> tuple[UseTool | None, UseBoard | None]:
    """Tool and board in use after some steps."""
    for step in steps:
        tool = step if isinstance(step, UseTool) else tool
        board = step if isinstance(step, UseBoard) else board
    return tool, board


_STRAIGHT = 1e-3
"""Radians between two directions that count as one."""


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
    """Move outputs from the end of a line that is passed to the beginning of the next line."""
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


def follow(steps: Sequence[Step]) -> dict[int, Line]:
    """Find the line right after each line that is passed, by the identity (``id``) of the latter."""
    return {
        id(step): after
        for step, after in pairwise(steps)
        if isinstance(step, Line) and isinstance(after, Line) and step.blend_mm > 0.0
    }


def is_straight(line: Line, after: Line | None) -> bool:
    """Whether the next line has the same direction."""
    if after is None or line.turns_on_the_spot or after.turns_on_the_spot:
        return False
    return math.dist(line.direction, after.direction) <= _STRAIGHT


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
