"""Conditions that every timed program meets, in memory as in its file."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from programs.program import Columns, Command, TimedProgram

TICK_S = 1e-4
"""The last digit of a time in the file."""
LARGEST_BYTES = 200_000_000
"""Of a program's file: a larger one is neither written nor read."""
LARGEST = 1e9
"""No number of a program is larger: mm, s, mm/s."""

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
COMMANDS: dict[str, tuple[str, re.Pattern[str]]] = {
    "FUNCTION": ("FUNCTION name", re.compile(r"\S+")),
    "NOZZLE": ("NOZZLE name TOOL number", re.compile(r"\S+ TOOL \d{1,4}", re.ASCII)),
    "SOLUTION": ("SOLUTION name", re.compile(r"\S+")),
    "SET": ("SET key value", re.compile(r"\S+ (?![+-]?(?:nan|inf|infinity)$)\S+", re.IGNORECASE)),
    "GRIP": ("GRIP open or GRIP close", re.compile(r"open|close")),
    "CALL": ("CALL name", re.compile(r"\S+")),
    "REPEAT": ("REPEAT number UNTIL key >= value", re.compile(rf"[1-9]\d{{0,5}} UNTIL \S+ >= {_NUMBER}", re.ASCII)),
    "ENDREPEAT": ("ENDREPEAT alone", re.compile(r"")),
}
"""Every other instruction by its keyword: how it is written, and the pattern of its arguments joined by spaces."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A violated condition, and where."""

    message: str
    index: int | None = None
    """The instruction; ``None`` where it is the totals."""


def first_fault(program: TimedProgram, columns: Columns) -> Fault | None:
    """Find what makes a program unreadable; the earliest instruction first.

    Args:
        program: The program.
        columns: Its numbers, rounded as the file has them, so that a program that may be written may be read.
    """
    wild = next(_wild_numbers(columns), None)
    if wild is not None:
        return wild
    faults = [*_wrong_times(columns), *_wrong_moves(columns), *_wrong_words(program), *_wrong_repeats(program)]
    if len(columns.spray) and columns.spray[-1]:
        faults.append(Fault("the program ends with the jet on; add SPRAY OFF.", len(columns.times) - 1))
    if faults:
        return min(faults, key=lambda fault: fault.index or 0)
    return next(_wrong_header(program), None) or next(_wrong_totals(program, columns), None)


def _wild_numbers(columns: Columns) -> Iterator[Fault]:
    for at, table in (
        (np.arange(len(columns.times)), columns.times[:, None]),
        (columns.move_at, columns.moves),
        (columns.wait_at, columns.waits[:, None]),
    ):
        for row in np.flatnonzero(~(np.abs(table) <= LARGEST).all(axis=1))[:1]:  # the negation catches NaN too
            yield Fault("a number is not finite or is beyond 1e9; give a finite one.", int(at[row]))


def _wrong_times(columns: Columns) -> Iterator[Fault]:
    times = columns.times
    if len(times) and times[0] < 0:
        yield Fault(f"the time {times[0]:.4f} s is negative; a program begins at 0 s or later.", 0)
    for row in np.flatnonzero(np.diff(times) < 0)[:1]:
        message = f"time runs back from {times[row]:.4f} to {times[row + 1]:.4f} s; order the instructions by time."
        yield Fault(message, int(row) + 1)
    for row in np.flatnonzero(columns.waits < 0)[:1]:
        yield Fault(f"WAIT {columns.waits[row]:.4f} is negative; wait 0 s or longer.", int(columns.wait_at[row]))
    follows = columns.wait_at + 1 < len(times)
    at, ends = columns.wait_at[follows], (times[columns.wait_at] + columns.waits)[follows]
    for row in np.flatnonzero(times[at + 1] < ends - 1.5 * TICK_S)[:1]:  # three numbers rounded by half a tick each
        begins_s = times[at[row] + 1]
        message = f"the wait before it ends at {ends[row]:.4f} s; move this instruction from {begins_s:.4f} s."
        yield Fault(message, int(at[row]) + 1)


def _wrong_moves(columns: Columns) -> Iterator[Fault]:
    for row in np.flatnonzero(columns.moves[:, 7] < 0)[:1]:
        yield Fault(f"the speed {columns.moves[row, 7]:.3f} is negative.", int(columns.move_at[row]))
    lengths = np.linalg.norm(columns.moves[:, 3:7], axis=1)
    for row in np.flatnonzero(np.abs(lengths - 1) > 1e-6)[:1]:
        message = f"the quaternion's length is {lengths[row]:.7f}, not 1 within 1e-6; normalise qw qx qy qz."
        yield Fault(message, int(columns.move_at[row]))


def wrong_arguments(keyword: str, arguments: tuple[str, ...]) -> str | None:
    """Describe how a command is written where this is not; ``None`` where it is."""
    usage, pattern = COMMANDS[keyword]
    text = " ".join(arguments)
    is_clean = text.split() == list(arguments) and ";" not in arguments and (text.isprintable())
    if is_clean and pattern.fullmatch(text):
        return None
    found = " ".join(f"{keyword} {text}".split())
    return f"found {found!r}; it is written {usage}."


def _wrong_words(program: TimedProgram) -> Iterator[Fault]:
    makers = {str(item.made_by) for item in program.instructions}
    bad = {made_by for made_by in makers if not made_by.isprintable() or made_by != made_by.strip()}
    for index, item in enumerate(program.instructions):
        if bad and str(item.made_by) in bad:
            yield Fault(
                f"{str(item.made_by)!r} cannot stand in a line; use printable characters, no space at an end.", index
            )
        if isinstance(item, Command):
            if item.keyword not in COMMANDS:
                yield Fault(f"unknown command {item.keyword!r}; known are {', '.join(COMMANDS)}.", index)
            elif message := wrong_arguments(item.keyword, item.arguments):
                yield Fault(message, index)


def _wrong_repeats(program: TimedProgram) -> Iterator[Fault]:
    opened: list[int] = []
    for index, item in enumerate(program.instructions):
        if not isinstance(item, Command):
            continue
        if item.keyword == "REPEAT":
            opened.append(index)
        elif item.keyword == "ENDREPEAT":
            if not opened:
                yield Fault("ENDREPEAT without a REPEAT before it; remove it.", index)
                return
            opened.pop()
    if opened:
        yield Fault("this REPEAT has no ENDREPEAT; add one.", opened[-1])


def _wrong_header(program: TimedProgram) -> Iterator[Fault]:
    origin = program.origin
    named = [("board", origin.board), ("recipe", origin.recipe)]
    for what, name in [*named, ("cell", origin.cell)] if origin.cell or origin.cell_sha256 else named:
        if not name or not name.isprintable() or name != name.strip():
            yield Fault(f"{name!r} cannot be the name of a {what}; use printable characters, no space at an end.")
    for what, token in (
        ("the board's sha256", origin.board_sha256),
        ("the recipe's sha256", origin.recipe_sha256),
        *([("the cell's sha256", origin.cell_sha256)] if origin.cell else []),
        *(("a function's name", name) for name, _ in program.totals.liquid_l),
    ):
        if token.split() != [token] or not token.isprintable():
            yield Fault(f"{token!r} cannot be {what}; use one word.")


def _wrong_totals(program: TimedProgram, columns: Columns) -> Iterator[Fault]:
    totals = program.totals
    numbers = (totals.duration_s, totals.spray_s, totals.travel_mm, *(litres for _, litres in totals.liquid_l))
    if not all(0 <= number <= LARGEST for number in numbers):
        yield Fault("a total is negative, not finite or beyond 1e9.")
        return
    if not len(columns.moves):
        yield Fault("the program has no MOVE; it needs at least the pose at which it begins.")
        return
    if totals.moves != len(columns.moves):
        yield Fault(f"the totals state {totals.moves} moves, the program has {len(columns.moves)}; a line is missing.")
    end_s = columns.times[-1]
    held_s = columns.waits[-1] if len(columns.wait_at) and columns.wait_at[-1] == len(columns.times) - 1 else 0.0
    if not end_s - 1.5 * TICK_S <= totals.duration_s <= end_s + held_s + 1.5 * TICK_S:
        yield Fault(f"the totals state {totals.duration_s:.4f} s, the program ends at {end_s:.4f} s; make them agree.")
