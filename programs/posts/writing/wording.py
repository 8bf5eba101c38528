"""Names, comments and numbers that a controller accepts."""

import re
import unicodedata
from collections.abc import Collection

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


def plain(text: str) -> str:
    """Say a text in printable ASCII: letters without their accents, a question mark for what has no letter."""
    spelt = "".join(_LETTERS.get(letter, letter) for letter in text)
    flat = "".join(letter for letter in unicodedata.normalize("NFKD", spelt) if not unicodedata.combining(letter))
    return "".join(letter if " " <= letter <= "~" else "?" for letter in flat)


def cut(text: str, longest: int) -> str:
    """Shorten a comment to what a line holds, and show that something is missing."""
    words = plain(text)
    return words if len(words) <= longest else words[: max(longest - 3, 0)] + "..."[:longest]


def make_name(text: str, longest: int, taken: Collection[str] = ()) -> str:
    """Make an identifier: letters, digits and underscores, a letter first, unlike those taken whatever their case.

    Args:
        text: What it is to remind of.
        longest: Characters that the language allows.
        taken: Names in use.
    """
    words = re.sub(r"_{2,}", "_", re.sub(r"[^A-Za-z0-9]", "_", plain(text))).strip("_")
    name = words if words[:1].isalpha() else f"W{words}"
    known = {each.lower() for each in taken}
    chosen, number = name[:longest].rstrip("_"), 2
    while chosen.lower() in known:
        end = f"_{number}"
        chosen, number = name[: longest - len(end)].rstrip("_") + end, number + 1
    return chosen


def fixed(value: float, digits: int) -> str:
    """Write a number with so many decimals, never a negative zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def short(value: float, digits: int) -> str:
    """Write a number with at most so many decimals and no zeros at its end."""
    text = fixed(value, digits)
    return text.rstrip("0").rstrip(".") if "." in text else text
