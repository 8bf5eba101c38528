"""The root of every error that stops a job, that of those which have a place in a file, and names safe to print."""

from pathlib import Path
from typing import Protocol

_LONGEST_LINE = 1000
_LONGEST_PATH = 300
"""Of a place in a file."""


def printable(text: str) -> str:
    """Escape what would break or forge a line, steer a terminal, or be no text, as in a Python string.

    Backslashes stay as they are, so that a text that was escaped once does not change any more.
    """
    return text if text.isprintable() else "".join(map(_escape, text))


def _escape(letter: str) -> str:
    if letter.isprintable():
        return letter
    code = ord(letter)
    # Python stands U+DC80 to U+DCFF for bytes of a file's name that are no UTF-8.
    return f"\\x{code - 0xDC00:02x}" if 0xDC80 <= code <= 0xDCFF else letter.encode("unicode_escape").decode()


def shorten_line(line: str, longest: int = _LONGEST_LINE) -> str:
    """Make a line safe to print; of a very long one, which quotes its input, the middle is left out."""
    line, half = printable(line), longest // 2
    return line if len(line) <= longest else f"{line[:half]} … {line[-half:]}"


class JobError(Exception):
    """Something in the input stops the job: the message states what, where and what to do.

    Each noun has its own: ``BoardError``, ``RecipeError``, ``ProgramError``. The command line prints the message
    and exits with 2; nothing else in the house may print one as a traceback.
    """


class LocatedError(JobError):
    """Something in a file stops the job: the message begins with the file, the line and the place in it, if known."""

    def __init__(
        self, message: str, *, path: str = "", file: Path | str | None = None, line: int | None = None
    ) -> None:
        """Prefix the message with ``file:line: path:`` as far as they are known."""
        name = printable(str(file))
        place = "" if file is None else f"{name}:{line}: " if line is not None else f"{name}: "
        inside = f"{shorten_line(path, _LONGEST_PATH)}: " if path else ""
        super().__init__(place + inside + "\n".join(map(shorten_line, message.split("\n"))))
        self.path = path
        self.file = file
        self.line = line


class ErrorFactory(Protocol):
    """Creates the error of one kind of file."""

    def __call__(
        self, message: str, *, path: str = "", file: Path | str | None = None, line: int | None = None
    ) -> JobError:
        """Prefix the message with ``file:line: path:`` as far as they are known."""
        ...


class EditError(LocatedError):
    """A text cannot be changed as requested: the message names the YAML path."""
