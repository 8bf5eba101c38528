"""Brings a text to the layout in which its language is written here: blanks, commas, equals signs, decimal points.

Makers' grammars leave these free, and who edits a program by hand, or an editor that saves it, changes them. Lines stay
where they are, so that what is refused is refused at its own line; texts in quotes and lines that are a comment stay as
they are. A comment after a statement is left out, but one in brackets: that may be a message.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

_QUOTED = re.compile(r'("[^"]*")')
_BLANKS = re.compile(r"(?<=\S)[ \t]+")
_EQUALS = re.compile(r" ?(?<![<>=!:])(:?=)(?!=) ?")
_COMMA = re.compile(r" ?, ?")
_POINT = re.compile(r"(?<![\w.)\]])\.(?=\d)")


@dataclass(frozen=True, slots=True)
class Layout:
    """How a language is written here, where its grammar leaves that free; what is ``None`` is left as it is."""

    comments: str = ""
    """What begin a comment, to the end of the line, with blanks between them."""
    comma: str | None = None
    """A comma with its blanks."""
    equals: str | None = None
    """An equals sign, ``=`` or ``:=``, is written for the ``=`` in it."""
    single_blanks: bool = False
    """Whether words have one blank between them."""
    leading_zero: bool = False
    """Whether a number has a digit before its point."""


AS_IT_IS = Layout()


def tidy(files: Mapping[str, str], layout: Layout) -> Mapping[str, str]:
    """Give the files of a program in the layout of a language, without empty lines at their ends."""
    return {
        name: "\n".join(_tidy_line(line, layout) for line in text.rstrip().split("\n")) + "\n"
        for name, text in files.items()
    }


def _tidy_line(line: str, layout: Layout) -> str:
    """Give a line without blanks at its end, or its statement in the layout."""
    line = line.rstrip()
    stripped = line.lstrip()
    at = _comment_at(stripped, layout.comments.split())
    code, comment = stripped[:at], stripped[at:]
    if not code or layout is AS_IT_IS:
        return line
    if not comment.startswith("("):  # which may be a message
        code, comment = code.rstrip(), ""
    parts = _QUOTED.split(code)
    parts[::2] = [_tidy_code(part, layout) for part in parts[::2]]
    return line[: len(line) - len(stripped)] + "".join(parts) + comment


def _comment_at(line: str, marks: Sequence[str]) -> int:
    """Find where the comment of a line begins, which is not within a text in quotes; the line's end if it has none."""
    is_text = False
    for match in re.finditer("|".join(map(re.escape, ('"', *marks))), line):
        if match[0] == '"':
            is_text = not is_text
        elif not is_text:
            return match.start()
    return len(line)


def _tidy_code(code: str, layout: Layout) -> str:
    if layout.single_blanks:
        code = _BLANKS.sub(" ", code)
    if layout.comma is not None:
        code = _COMMA.sub(layout.comma, code)
    if (equals := layout.equals) is not None:
        code = _EQUALS.sub(lambda match: equals.replace("=", match[1]), code)
    if layout.leading_zero:
        code = _POINT.sub("0.", code)
    return code
