"""The error that stops the reading of a board, and the reading of bytes that raises it."""

from dataclasses import dataclass
from pathlib import Path

from specs.errors import LocatedError
from specs.input_file import InputFile

MAX_BYTES = 2_000_000_000
"""A board file of more than this is refused: nothing that holds a board is so large."""


class BoardError(LocatedError):
    """A board file, or the board in it, cannot be used."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line of a board file, or of a table."""

    file: Path
    line: int
    """From 1."""

    def error(self, message: str) -> BoardError:
        """Error that names this line."""
        return BoardError(message, file=self.file, line=self.line)


def read_bytes(file: Path, noun: str = "board file") -> bytes:
    """Read a file of a board, or a table of its parts.

    Raises:
        BoardError: It cannot be read, or is no file of at most 2 GB.
    """
    return InputFile(file, BoardError, noun, MAX_BYTES).read()
