"""Names, comments and numbers that a controller accepts."""

import re
import unicodedata
from collections.abc import Callable, Collection, Iterable

from programs.pose import Pose, Position, Quaternion
from programs.posts.writing.forms import fixed

_LETTERS = {
    "\N{GREEK CAPITAL LETTER OMEGA}": "Ohm",
    "\N{OHM SIGN}": "Ohm",
    "\N{MICRO SIGN}": "u",
    "\N{GREEK SMALL LETTER MU}": "u",
    "ß": "ss",
    "ø": "o",
    "Ø": "O",
    "æ": "ae",
    "Æ": "Ae",
    "°": "deg",
    "…": "...",
}

_DEVICES = frozenset(
    {"con", "prn", "aux", "nul", *(f"{port}{number}" for port in ("com", "lpt") for number in range(10))}
)
"""Names that no file may have under Windows, on which many controllers and most makers' tools run."""


def plain(text: str) -> str:
    """Spell a text in printable ASCII: letters without their accents, a question mark for what has no letter."""
    if text.isascii() and text.isprintable():
        return text
    spelt = "".join(_LETTERS.get(letter, letter) for letter in text)
    flat = "".join(letter for letter in unicodedata.normalize("NFKD", spelt) if not unicodedata.combining(letter))
    return "".join(letter if " " <= letter <= "~" else "?" for letter in flat)


def cut(text: str, longest: int) -> str:
    """Shorten a comment to what a line holds, and show that something is missing."""
    words = plain(text)
    return words if len(words) <= longest else words[: max(longest - 3, 0)] + "..."[:longest]


def make_name(text: str, longest: int, taken: Collection[str] = (), link: str = "_") -> str:
    """Make an identifier: letters, digits and underscores, a letter first, unlike those taken whatever their case.

    A file may have it as its name.

    Args:
        text: What it describes.
        longest: Characters that the language allows.
        taken: Names in use.
        link: Character before the number of a name that is taken.
    """
    words = re.sub(r"_{2,}", "_", re.sub(r"[^A-Za-z0-9]", "_", plain(text))).strip("_")
    name = words if words[:1].isalpha() else f"W{words}"
    known = {*_DEVICES, *(each.lower() for each in taken)}
    chosen, number = name[:longest].rstrip("_"), 2
    while chosen.lower() in known:
        end = f"{link}{number}"
        chosen, number = name[: longest - len(end)].rstrip("_") + end, number + 1
    return chosen


def pose_words(pose: Pose, angles: Callable[[Quaternion], Position]) -> list[str]:
    """Write a pose as six numbers: mm with three decimals, and the angles of a maker, degrees with four."""
    return [
        *(fixed(value, 3) for value in pose.position),
        *(fixed(value, 4) for value in angles(pose.quaternion)),
    ]


def split_wait(seconds: float, longest_s: float, digits: int) -> list[float]:
    """Divide a time into waits that an instruction can hold: whole longest ones, then the rest."""
    left, waits = round(seconds, digits), list[float]()
    while left > longest_s:
        waits.append(longest_s)
        left = round(left - longest_s, digits)
    return [*waits, left]


def join_lines(lines: Iterable[str]) -> str:
    """Give the text of a file: each line with its end."""
    return "".join(f"{line}\n" for line in lines)


def indent(lines: Iterable[str]) -> list[str]:
    """Indent lines by two spaces; empty ones stay empty."""
    return [f"  {line}" if line else "" for line in lines]
