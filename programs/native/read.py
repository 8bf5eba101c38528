"""Reads the text of a native program, ``.wash``."""

import re
from difflib import get_close_matches
from pathlib import Path

from programs.columns import columns_of, rounded
from programs.errors import ProgramError
from programs.plan import Origin
from programs.program import Command, Instruction, MoveTo, SetNozzle, TimedProgram, Totals, Wait
from programs.soundness import COMMANDS, first_fault, wrong_arguments
from specs.source import Source

MAGIC = "WASHBOARD 1"
FIXED_HEADER = ("UNITS mm s", "FRAME board")
BEGIN = "BEGIN"
END = "END"

_BOARD_AT, _RECIPE_AT, _TOTALS_AT = 3, 4, 5
_NUMBERS = {"MOVE": (8, "numbers (x y z qw qx qy qz v)"), "WAIT": (1, "number (seconds)")}
_KEYWORDS = ("MOVE", "SPRAY", "WAIT", *COMMANDS)
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_AMOUNT = r"(\d+(?:\.\d+)?)"
_BOARD = re.compile(r"BOARD (\S|\S.*\S) sha256 (\S+)")
_RECIPE = re.compile(r"RECIPE (\S|\S.*\S) sha256 (\S+)")
_TOTALS = re.compile(
    rf"TOTALS duration_s {_AMOUNT} spray_s {_AMOUNT} travel_mm {_AMOUNT} moves (\d{{1,9}})", flags=re.ASCII
)
_LIQUID = re.compile(rf"LIQUID (\S+) {_AMOUNT} l", flags=re.ASCII)


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
        at = _TOTALS_AT if fault.index is None else tuple(read)[fault.index]
        raise ProgramError(fault.message, file=file, line=at + 1)
    return program


def _read_header(lines: list[str]) -> tuple[Origin, Totals, int]:
    """Read up to BEGIN, and give its line."""
    if lines[0] != MAGIC:
        if lines[0].startswith("WASHBOARD "):
            raise _LineError(0, f"this is {lines[0][:40]!r}; only {MAGIC!r} can be read. Plan the board again.")
        raise _LineError(0, f"this is not a Washboard program: its first line is not {MAGIC!r}.")
    for at, fixed in enumerate(FIXED_HEADER, start=1):
        _match_line(lines, at, re.compile(re.escape(fixed)), fixed)
    board = _match_line(lines, _BOARD_AT, _BOARD, "BOARD name sha256 hash")
    recipe = _match_line(lines, _RECIPE_AT, _RECIPE, "RECIPE name sha256 hash")
    totals = _match_line(
        lines, _TOTALS_AT, _TOTALS, "TOTALS duration_s seconds spray_s seconds travel_mm length moves count"
    )
    at = _TOTALS_AT + 1
    liquid: list[tuple[str, float]] = []
    while at < len(lines) and lines[at].startswith("LIQUID"):
        name, litres = _match_line(lines, at, _LIQUID, "LIQUID function litres l").groups()
        liquid.append((name, float(litres)))
        at += 1
    _match_line(lines, at, re.compile(BEGIN), "LIQUID function litres l, or BEGIN")
    duration_s, spray_s, travel_mm, moves = totals.groups()
    return (
        Origin(board[1], board[2], recipe[1], recipe[2]),
        Totals(float(duration_s), float(spray_s), float(travel_mm), int(moves), tuple(liquid)),
        at,
    )


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
        if words == [END]:
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
