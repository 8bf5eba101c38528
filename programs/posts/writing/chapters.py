"""A long program in routines that a controller can hold, and a main that calls them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count, pairwise
from typing import TypeAlias

from programs.motion.steps import EndRepeat, Line, MotionProgram, Note, Reach, Repeat, Step, UseBoard, UseTool


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
    """Where the board lies when it begins; ``None`` before that is said."""


Part: TypeAlias = Chapter | Repeat | EndRepeat
"""What main does: run a chapter, or begin or end a loop around some."""


@dataclass(frozen=True, slots=True)
class Begin:
    """Where a loop of main begins."""

    number: int
    """From 1, in the order of the program."""
    step: Repeat


@dataclass(frozen=True, slots=True)
class End:
    """Where a loop of main ends."""

    number: int
    step: Repeat
    """How it began."""


def nest(parts: tuple[Part, ...]) -> Iterator[tuple[str, Chapter | Begin | End]]:
    """Number the loops of main and tell each end its beginning; with the indentation at which each part stands."""
    begun: list[Begin] = []
    count = 0
    for part in parts:
        indent = "  " * len(begun)
        match part:
            case Chapter():
                yield indent, part
            case Repeat():
                count += 1
                begun.append(Begin(count, part))
                yield indent, begun[-1]
            case EndRepeat():
                loop = begun.pop()
                yield indent[2:], End(loop.number, loop.step)


def divide(motion: MotionProgram, most_steps: int) -> tuple[Part, ...]:
    """Divide a program at loops, at functions, and where the robot stands when a routine has grown long.

    Where it never stands for so long, it is made to stop.

    Args:
        motion: The program.
        most_steps: Of one routine.
    """
    return tuple(_parts(motion.steps, most_steps))


def _parts(steps: tuple[Step, ...], most: int) -> Iterator[Part]:
    number, title = 0, "start"
    tool: UseTool | None = None
    board: UseBoard | None = None
    for piece in _pieces(steps, most):
        if isinstance(piece, Repeat | EndRepeat):
            yield piece
            continue
        title = next((name for name in map(_function, piece) if name), title)
        number += 1
        yield Chapter(number, title, tuple(piece), tool, board)
        tool, board = _frames_after(piece, tool, board)


def _pieces(steps: tuple[Step, ...], most: int) -> Iterator[list[Step] | Repeat | EndRepeat]:
    piece: list[Step] = []
    for step in steps:
        if piece and (isinstance(step, Repeat | EndRepeat) or (_function(step) and any(map(_moves, piece)))):
            yield piece
            piece = []
        if isinstance(step, Repeat | EndRepeat):
            yield step
            continue
        piece.append(step)
        if len(piece) >= most:
            rest = _last_rest(piece)
            if rest == 0:
                rest, last = len(piece), piece[-1]
                piece[-1] = replace(last, blend_mm=0.0) if isinstance(last, Line) else last
            yield piece[:rest]
            piece = piece[rest:]
    if piece:
        yield piece


def _last_rest(piece: list[Step]) -> int:
    """How many steps there are up to the last one after which the robot stands."""
    for index in range(len(piece), 0, -1):
        step = piece[index - 1]
        if not isinstance(step, Line) or step.blend_mm == 0.0:
            return index
    return 0


def _function(step: Step) -> str:
    return step.text.removeprefix("function ") if isinstance(step, Note) and step.text.startswith("function ") else ""


def _moves(step: Step) -> bool:
    return isinstance(step, Line)


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
