"""The native program file, ``.wash``: written and read back."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path

from programs.errors import ProgramError
from programs.plan import Origin
from programs.program import (
    Columns,
    Command,
    Instruction,
    MoveTo,
    SetNozzle,
    TimedProgram,
    Totals,
    Wait,
    columns_of,
    rounded,
)
from programs.soundness import COMMANDS, LARGEST_BYTES, first_fault, wrong_arguments
from specs.source import Source

_MAGIC = "WASHBOARD 1"
_FIXED_HEADER = ("UNITS mm s", "FRAME board")
_BEGIN = "BEGIN"
_END = "END"

_BOARD_AT, _RECIPE_AT, _CELL_AT = 3, 4, 5
_NUMBERS = {"MOVE": (8, "numbers (x y z qw qx qy qz v)"), "WAIT": (1, "number (seconds)")}
_KEYWORDS = ("MOVE", "SPRAY", "WAIT", *COMMANDS)
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_AMOUNT = r"(\d+(?:\.\d+)?)"
_BOARD = re.compile(r"BOARD (\S|\S.*\S) sha256 (\S+)")
_RECIPE = re.compile(r"RECIPE (\S|\S.*\S) sha256 (\S+)")
_CELL = re.compile(r"CELL (\S|\S.*\S) sha256 (\S+)")
_TOTALS = re.compile(
    rf"TOTALS duration_s {_AMOUNT} spray_s {_AMOUNT} travel_mm {_AMOUNT} moves (\d{{1,9}})", flags=re.ASCII
)
_LIQUID = re.compile(rf"LIQUID (\S+) {_AMOUNT} l", flags=re.ASCII)
_COMMENT_COLUMN = 56
"""Where the recipe path begins; longer lines are followed by three spaces and then their own."""
_LINES_AT_ONCE = 10_000


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
    text = "\n".join([*_header(program), _BEGIN, *_body(program.instructions, columns), _END, ""])
    if (size := len(text.encode())) > LARGEST_BYTES:
        raise ProgramError(
            f"this program would have {size / 1e6:.0f} MB; at most {LARGEST_BYTES / 1e6:.0f} MB are read. Plan "
            "fewer steps, or lower what multiplies its moves: passes, repeats, components followed apart."
        )
    return text


def render_line(program: TimedProgram, index: int) -> str:
    """Write one instruction of a program as its line of the file."""
    alone = replace(program, instructions=program.instructions[index : index + 1])
    return _body(alone.instructions, rounded(columns_of(alone)))[0]


def _header(program: TimedProgram) -> list[str]:
    origin, totals = program.origin, program.totals
    return [
        _MAGIC,
        *_FIXED_HEADER,
        f"BOARD {origin.board} sha256 {origin.board_sha256}",
        f"RECIPE {origin.recipe} sha256 {origin.recipe_sha256}",
        *([f"CELL {origin.cell} sha256 {origin.cell_sha256}"] if origin.cell else []),
        f"TOTALS duration_s {totals.duration_s:.4f} spray_s {totals.spray_s:.4f} "
        f"travel_mm {totals.travel_mm:.3f} moves {totals.moves}",
        *(f"LIQUID {name} {litres:.3f} l" for name, litres in totals.liquid_l),
    ]


def _body(instructions: Sequence[Instruction], columns: Columns) -> list[str]:
    """Lines of instructions, some thousand joined in each text: lines by themselves take five times the memory."""
    texts: list[str] = []
    for begin in range(0, len(instructions), _LINES_AT_ONCE):
        some = slice(begin, begin + _LINES_AT_ONCE)
        texts.append("\n".join(_lines(instructions[some], columns.part(begin, begin + _LINES_AT_ONCE))))
    return texts


def _lines(instructions: Sequence[Instruction], columns: Columns) -> Iterator[str]:
    words = [""] * len(instructions)
    move = "MOVE %.3f %.3f %.3f %.7f %.7f %.7f %.7f %.3f"
    for index, numbers in zip(columns.move_at.tolist(), columns.moves.tolist(), strict=True):
        words[index] = move % tuple(numbers)
    for index, duration_s in zip(columns.wait_at.tolist(), columns.waits.tolist(), strict=True):
        words[index] = f"WAIT {duration_s:.4f}"
    for time_s, word, item in zip(columns.times.tolist(), words, instructions, strict=True):
        line = f"{time_s:.4f} {word or _words(item)}"
        yield f"{line:<{_COMMENT_COLUMN - 3}}   ; {item.made_by}" if item.made_by else line


def _words(instruction: Instruction) -> str:
    match instruction:
        case SetNozzle():
            return "SPRAY ON" if instruction.spraying else "SPRAY OFF"
        case Command():
            return " ".join((instruction.keyword, *instruction.arguments))
        case MoveTo() | Wait():
            raise AssertionError("moves and waits are written from their columns")


class _LineError(Exception):
    """A line that cannot be read; ``parse`` adds the name of the file."""

    def __init__(self, index: int, message: str) -> None:
        super().__init__(message)
        self.index = index


def parse(text: str, *, file: Path | str | None = None) -> TimedProgram:
    """Read the text of a ``.wash`` file.

    Blank lines after BEGIN and Windows line ends are accepted; everything else is as it is written.

    Args:
        text: The whole file.
        file: Its name, for the messages.

    Raises:
        ProgramError: the text is not a program; the message names the line.
    """
    lines = text.replace("\r\n", "\n").split("\n")
    try:
        origin, totals, begin = _read_header(lines)
        read = _read_body(lines, begin + 1)
    except _LineError as refused:
        raise ProgramError(str(refused), file=file, line=refused.index + 1) from None
    program = TimedProgram(origin, totals, tuple(read.values()))
    fault = first_fault(program, rounded(columns_of(program)))
    if fault is not None:
        at = _totals_at(lines) if fault.index is None else tuple(read)[fault.index]
        raise ProgramError(fault.message, file=file, line=at + 1)
    return program


def _read_header(lines: list[str]) -> tuple[Origin, Totals, int]:
    """Read up to BEGIN, and give its line."""
    if lines[0] != _MAGIC:
        if lines[0].startswith("WASHBOARD "):
            raise _LineError(0, f"this is {lines[0][:40]!r}; only {_MAGIC!r} can be read. Plan the board again.")
        raise _LineError(0, f"this is not a Washboard program: its first line is not {_MAGIC!r}.")
    for at, fixed in enumerate(_FIXED_HEADER, start=1):
        _match_line(lines, at, re.compile(re.escape(fixed)), fixed)
    board = _match_line(lines, _BOARD_AT, _BOARD, "BOARD name sha256 hash")
    recipe = _match_line(lines, _RECIPE_AT, _RECIPE, "RECIPE name sha256 hash")
    at = _totals_at(lines)
    cell = _match_line(lines, _CELL_AT, _CELL, "CELL name sha256 hash") if at > _CELL_AT else ("", "", "")
    totals = _match_line(lines, at, _TOTALS, "TOTALS duration_s seconds spray_s seconds travel_mm length moves count")
    at += 1
    liquid: list[tuple[str, float]] = []
    while at < len(lines) and lines[at].startswith("LIQUID"):
        name, litres = _match_line(lines, at, _LIQUID, "LIQUID function litres l").groups()
        liquid.append((name, float(litres)))
        at += 1
    _match_line(lines, at, re.compile(_BEGIN), "LIQUID function litres l, or BEGIN")
    duration_s, spray_s, travel_mm, moves = totals.groups()
    return (
        Origin(board[1], board[2], recipe[1], recipe[2], cell[1], cell[2]),
        Totals(float(duration_s), float(spray_s), float(travel_mm), int(moves), tuple(liquid)),
        at,
    )


def _totals_at(lines: list[str]) -> int:
    """Give the line of the totals: after that of the cell, if there is one."""
    return _CELL_AT + (len(lines) > _CELL_AT and lines[_CELL_AT].startswith("CELL "))


def _match_line(lines: list[str], at: int, pattern: re.Pattern[str], usage: str) -> re.Match[str]:
    found = lines[at] if at < len(lines) else ""
    match = pattern.fullmatch(found)
    if match is None:
        raise _LineError(min(at, len(lines) - 1), f"expected '{usage}', found {found[:80]!r}.")
    return match


def _read_body(lines: list[str], start: int) -> dict[int, Instruction]:
    """Read the instructions by the index of their line."""
    read: dict[int, Instruction] = {}
    for at in range(start, len(lines)):
        body, _, made_by = lines[at].partition(" ; ")
        words = body.split()
        if not words:
            if made_by:
                raise _LineError(at, "a recipe path without an instruction before it; remove the line.")
            continue
        if words == [_END]:
            rest = next((after for after in range(at + 1, len(lines)) if lines[after].strip()), None)
            if rest is not None:
                raise _LineError(rest, f"text after END: {lines[rest][:80]!r}; remove it.")
            return read
        try:
            read[at] = _read_instruction(words, Source.parse(made_by.strip()))
        except ValueError as error:
            raise _LineError(at, str(error)) from None
    raise _LineError(len(lines) - 1, "the file ends without END: it is cut off. Write it again.")


def _read_instruction(words: list[str], made_by: Source) -> Instruction:
    """Read one line.

    Raises:
        ValueError: it is not an instruction; the message gives the reason.
    """
    keyword = words[1] if len(words) > 1 else ""
    arguments = words[2:]
    count, usage = _NUMBERS.get(keyword, (0, ""))
    if count and len(arguments) != count:
        raise ValueError(f"{keyword} needs {count} {usage}, found {len(arguments)}.")
    time_s, *numbers = _numbers([words[0], *arguments[:count]])
    match keyword:
        case "MOVE":
            x, y, z, qw, qx, qy, qz, speed = numbers
            return MoveTo(time_s, (x, y, z), (qw, qx, qy, qz), speed, made_by)
        case "WAIT":
            return Wait(time_s, numbers[0], made_by)
        case "SPRAY":
            if arguments not in (["ON"], ["OFF"]):
                raise ValueError(f"expected SPRAY ON or SPRAY OFF, found {' '.join(words[1:])!r}.")
            return SetNozzle(time_s, arguments == ["ON"], made_by)
        case _:
            return _read_command(time_s, keyword, tuple(arguments), made_by)


def _read_command(time_s: float, keyword: str, arguments: tuple[str, ...], made_by: Source) -> Command:
    if not keyword:
        raise ValueError("a time without an instruction after it; add one or remove the line.")
    if keyword not in COMMANDS:
        nearest = get_close_matches(keyword.upper(), _KEYWORDS, n=1, cutoff=0.5)
        hint = f"did you mean {nearest[0]}?" if nearest else f"known are {', '.join(_KEYWORDS)}."
        raise ValueError(f"unknown instruction {keyword[:40]!r}; {hint}")
    message = wrong_arguments(keyword, arguments)
    if message:
        raise ValueError(message)
    return Command(time_s, keyword, arguments, made_by)


def _numbers(words: list[str]) -> list[float]:
    """Read decimal numbers; ``float`` alone would take ``1_000`` and the digits of other scripts too."""
    text = " ".join(words)
    if text.isascii() and "_" not in text:
        try:
            return [float(word) for word in words]
        except ValueError:
            pass
    wrong = next(word for word in words if not _NUMBER.fullmatch(word))
    raise ValueError(f"{wrong[:40]!r} is not a number.")
