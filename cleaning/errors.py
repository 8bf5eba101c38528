"""What stops an analysis."""

from pathlib import Path

from geometry.errors import JobError


class CleaningError(JobError):
    """Parameters or measurements cannot be used: the message names the file, the line and the path."""

    def __init__(
        self, message: str, *, path: str = "", file: Path | str | None = None, line: int | None = None
    ) -> None:
        """Prefix the message with ``file:line: path:`` as far as they are known."""
        place = "" if file is None else f"{file}:{line}: " if line is not None else f"{file}: "
        super().__init__(place + (f"{path}: " if path else "") + message)
        self.path = path
        self.file = file
        self.line = line
