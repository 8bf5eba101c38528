"""Random corruptions of a program's text, as a faulty writer, a disk or an editor would make them."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random

_DIGIT = re.compile(r"\d")
_SIGNED = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?")
_NAME = re.compile(r"[A-Za-z_]\w*")

Corrupt = Callable[[list[str], int, Random], list[str] | None]
"""Gives lines with one of them corrupted, by its index; nothing where that is not possible there."""


@dataclass(frozen=True)
class Corrupted:
    """A text with one corruption."""

    kind: str
    files: Mapping[str, str]
    before: str
    """The line as it was."""
    after: str
    """What stands there now."""


def change_digit(lines: list[str], at: int, random: Random) -> list[str] | None:
    """Change one digit to another."""
    if not (found := list(_DIGIT.finditer(lines[at]))):
        return None
    match = random.choice(found)
    digit = random.choice([each for each in "0123456789" if each != match[0]])
    return _with(lines, at, lines[at][: match.start()] + digit + lines[at][match.end() :])


def flip_sign(lines: list[str], at: int, random: Random) -> list[str] | None:
    """Flip the sign of one number that is not zero."""
    found = [match for match in _SIGNED.finditer(lines[at]) if float(match[0])]
    if not found:
        return None
    match = random.choice(found)
    number = match[0][1:] if match[0].startswith("-") else f"-{match[0]}"
    return _with(lines, at, lines[at][: match.start()] + number + lines[at][match.end() :])


def change_name(lines: list[str], at: int, random: Random) -> list[str] | None:
    """Replace one name by another one of the text, or change its last letter."""
    if not (found := list(_NAME.finditer(lines[at]))):
        return None
    match = random.choice(found)
    others = [other for other in _NAME.findall(random.choice(lines)) if other != match[0]]
    name = random.choice([*others, match[0][:-1] + ("x" if match[0][-1] != "x" else "y")])
    return _with(lines, at, lines[at][: match.start()] + name + lines[at][match.end() :])


def lose_line(lines: list[str], at: int, random: Random) -> list[str] | None:
    """Leave a line out."""
    return [*lines[:at], *lines[at + 1 :]]


def double_line(lines: list[str], at: int, random: Random) -> list[str] | None:
    """Write a line twice."""
    return [*lines[: at + 1], *lines[at:]]


def swap_lines(lines: list[str], at: int, random: Random) -> list[str] | None:
    """Swap two lines, mostly neighbours."""
    other = at + 1 if random.random() < 0.7 else random.randrange(len(lines))
    if other >= len(lines) or lines[other].strip() == lines[at].strip():
        return None
    swapped = list(lines)
    swapped[at], swapped[other] = lines[other], lines[at]
    return swapped


def swap_numbers(lines: list[str], at: int, random: Random) -> list[str] | None:
    """Swap two numbers of a line."""
    found = list(_SIGNED.finditer(lines[at]))
    if len({match[0] for match in found}) < 2:
        return None
    first, second = sorted(random.sample(found, 2), key=re.Match.start)
    if first[0] == second[0]:
        return None
    line = lines[at]
    between = line[first.end() : second.start()]
    return _with(lines, at, line[: first.start()] + second[0] + between + first[0] + line[second.end() :])


KINDS: Mapping[str, Corrupt] = {
    made.__name__: made
    for made in (change_digit, flip_sign, change_name, lose_line, double_line, swap_lines, swap_numbers)
}


def corrupt(files: Mapping[str, str], random: Random) -> Corrupted:
    """Corrupt a text once, anywhere."""
    while True:
        kind = random.choice(list(KINDS))
        file = random.choices(list(files), weights=[text.count("\n") for text in files.values()])[0]
        lines = files[file].splitlines()
        at = random.randrange(len(lines))
        changed = KINDS[kind](lines, at, random)
        if changed is not None and changed != lines:
            after = changed[at] if at < len(changed) else ""
            return Corrupted(kind, {**files, file: "\n".join(changed) + "\n"}, lines[at], after)


def _with(lines: list[str], at: int, line: str) -> list[str]:
    return [*lines[:at], line, *lines[at + 1 :]]
