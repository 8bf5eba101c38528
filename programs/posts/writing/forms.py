"""Forms of statements: one text states how a line of a language looks, for what writes it and what reads it back.

``{name}``: a text; where it is read, of the pattern that the language has for its name.
``{name:2}``: a number with two decimals; ``{name:~2}`` with two at most. It has no sign unless one stands in front:
``{name:-2}``. Numbers without decimals are whole.
``{name: C_DIS}``: the text after the colon, which may have fields of its own, or nothing where the name has no value.
A text in quotes is for the operator: any other is read as well.
"""

import re
from collections.abc import Iterator, Mapping
from functools import lru_cache
from string import Formatter

NUMBER = r"-?\d+(?:\.\d+)?"
POSE = rf"{NUMBER}(?:, ?{NUMBER}){{5}}"
"""Six numbers with commas between them."""
_NUMBER_WORDS = re.compile(r"(-?)(~?)(\d)")
_OPERATORS_TEXT = re.compile(r'"[^"{}]*"')


_DECIMALS = re.compile(r"\d+\.\d")
_ZEROS = re.compile(r"(\d+)\\\.(\d+)")
"""A number with decimals, in a text that is escaped for a pattern."""


def fixed(value: float, digits: int) -> str:
    """Write a number with so many decimals, never a negative zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def short(value: float, digits: int) -> str:
    """Write a number with at most so many decimals and no zeros at its end."""
    text = fixed(value, digits)
    return text.rstrip("0").rstrip(".") if "." in text else text


def fill(form: str, /, **words: object) -> str:
    """Write a statement by its form."""
    written = ""
    for text, name, words_of_it in _fields_of(form):
        written += text
        value = words.get(name) if name else ""
        if match := _NUMBER_WORDS.fullmatch(words_of_it):
            number = float(value) if isinstance(value, float) else float(f"{value}")
            written += (short if match[2] else fixed)(number, int(match[3]))
        elif words_of_it:
            written += fill(words_of_it, **words) if value else ""
        else:
            written += str(value)
    return written


def pattern_of(form: str, fields: Mapping[str, str]) -> str:
    """Give the pattern of what a form writes: each field is a group of its name, and is the same where it comes again.

    Args:
        form: As the writer has it.
        fields: Pattern of each text by its name; a field without a name is ``it``.
    """
    return "".join(_patterns_of(_OPERATORS_TEXT.sub('"{}"', form.strip()), fields, set()))


def beginning_of(form: str) -> str:
    """Give the text that everything begins with that a form writes, up to a number that may have other zeros."""
    return _DECIMALS.split(_fields_of(_OPERATORS_TEXT.sub('"{}"', form.strip()))[0][0])[0]


def _any_zeros(number: re.Match[str]) -> str:
    """Give the pattern of a number with any zeros after its last decimal."""
    decimals = number[2].rstrip("0")
    return rf"{number[1]}\.{decimals}0*" if decimals else rf"{number[1]}(?:\.0*)?"


def _patterns_of(form: str, fields: Mapping[str, str], seen: set[str]) -> Iterator[str]:
    for text, name, words in _fields_of(form):
        yield _ZEROS.sub(_any_zeros, re.escape(text))
        if name is None:
            continue
        match = _NUMBER_WORDS.fullmatch(words)
        if not name and text.endswith('"'):
            yield '[^"]*'
        elif words and match is None:
            yield f"(?P<{name}>{''.join(_patterns_of(words, fields, seen))})?"
        elif name in seen:
            yield f"(?P={name})"
        else:
            seen.add(name)
            number = rf"{match[1] and '-?'}\d+" + (r"(?:\.\d+)?" if match[3] != "0" else "") if match else ""
            yield f"(?P<{name or 'it'}>{number or fields[name or 'it']})"


@lru_cache(maxsize=4096)
def _fields_of(form: str) -> tuple[tuple[str, str | None, str], ...]:
    """Give each text of a form, and the name and words of the field after it."""
    return tuple((text, name, words or "") for text, name, words, _ in Formatter().parse(form))
