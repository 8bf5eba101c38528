"""The error that stops the reading of a board, and the reading of bytes that raises it."""

from dataclasses import dataclass
from pathlib import Path

from specs.errors import LocatedError


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


def read_bytes(file: Path) -> bytes:
    """Read a file.

    Raises:
        BoardError: It cannot be read.
    """
    try:
        return file.read_bytes()
    except IsADirectoryError:
        raise BoardError("is a directory. Name the file inside it.", file=file) from None
    except OSError as error:
        raise BoardError(f"cannot be read ({error.strerror}).", file=file) from None
