"""What stops the reading of a program."""

from pathlib import Path

from geometry.errors import JobError


class ProgramError(JobError):
    """A program file cannot be used."""

    def __init__(self, message: str, *, file: Path | str | None = None, line: int | None = None) -> None:
        """Prefix the message with ``file:line:`` as far as they are known."""
        place = "" if file is None else f"{file}:{line}: " if line is not None else f"{file}: "
        super().__init__(place + message)
        self.file = file
        self.line = line
