"""What stops the reading of a board."""

from pathlib import Path

from geometry.errors import JobError


class BoardError(JobError):
    """A board file, or the board in it, cannot be used."""

    def __init__(self, message: str, *, file: Path | str | None = None, line: int | None = None) -> None:
        """Prefix the message with ``file:line:`` as far as they are known."""
        place = "" if file is None else f"{file}:{line}: " if line is not None else f"{file}: "
        super().__init__(place + message)
        self.file = file
        self.line = line
