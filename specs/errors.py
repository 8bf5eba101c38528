"""The root of every error that stops a job, and that of those which have a place in a file."""

from pathlib import Path


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
        place = "" if file is None else f"{file}:{line}: " if line is not None else f"{file}: "
        super().__init__(place + (f"{path}: " if path else "") + message)
        self.path = path
        self.file = file
        self.line = line


class EditError(LocatedError):
    """A text cannot be changed as requested: the message names the YAML path."""
