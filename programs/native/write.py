"""The native program, ``.wash``: the one dialect that is also read back."""

from dataclasses import replace

from programs.columns import Columns, columns_of, rounded
from programs.errors import ProgramError
from programs.native.read import BEGIN, END, FIXED_HEADER, MAGIC, parse
from programs.program import Command, Instruction, MoveTo, SetNozzle, TimedProgram, Wait
from programs.soundness import first_fault

__all__ = ["parse", "render", "render_line"]

_COMMENT_COLUMN = 56
"""Where the recipe path begins; longer lines are followed by three spaces and then their own."""


def render(program: TimedProgram) -> str:
    """Write a program as the text of a ``.wash`` file.

    Numbers are rounded to the file's digits; reading the text and writing it again gives the same text.

    Raises:
        ProgramError: the program is one that the reader would refuse.
    """
    columns = rounded(columns_of(program))
    fault = first_fault(program, columns)
    if fault is not None:
        place = "" if fault.index is None else f" at instruction {fault.index + 1}"
        raise ProgramError(f"this program cannot be written{place}: {fault.message}")
    return "\n".join([*_header(program), BEGIN, *_body(program.instructions, columns), END, ""])


def render_line(program: TimedProgram, index: int) -> str:
    """Write one instruction of a program as its line of the file."""
    alone = replace(program, instructions=program.instructions[index : index + 1])
    return _body(alone.instructions, rounded(columns_of(alone)))[0]


def _header(program: TimedProgram) -> list[str]:
    origin, totals = program.origin, program.totals
    return [
        MAGIC,
        *FIXED_HEADER,
        f"BOARD {origin.board} sha256 {origin.board_sha256}",
        f"RECIPE {origin.recipe} sha256 {origin.recipe_sha256}",
        f"TOTALS duration_s {totals.duration_s:.4f} spray_s {totals.spray_s:.4f} "
        f"travel_mm {totals.travel_mm:.3f} moves {totals.moves}",
        *(f"LIQUID {name} {litres:.3f} l" for name, litres in totals.liquid_l),
    ]


def _body(instructions: tuple[Instruction, ...], columns: Columns) -> list[str]:
    words = [""] * len(instructions)
    move = "MOVE %.3f %.3f %.3f %.7f %.7f %.7f %.7f %.3f"
    for index, numbers in zip(columns.move_at.tolist(), columns.moves.tolist(), strict=True):
        words[index] = move % tuple(numbers)
    for index, duration_s in zip(columns.wait_at.tolist(), columns.waits.tolist(), strict=True):
        words[index] = f"WAIT {duration_s:.4f}"
    lines: list[str] = []
    for time_s, word, item in zip(columns.times.tolist(), words, instructions, strict=True):
        line = f"{time_s:.4f} {word or _words(item)}"
        lines.append(f"{line:<{_COMMENT_COLUMN - 3}}   ; {item.made_by}" if item.made_by else line)
    return lines


def _words(instruction: Instruction) -> str:
    match instruction:
        case SetNozzle():
            return "SPRAY ON" if instruction.spraying else "SPRAY OFF"
        case Command():
            return " ".join((instruction.keyword, *instruction.arguments))
        case MoveTo() | Wait():
            raise AssertionError("moves and waits are written from their columns")
