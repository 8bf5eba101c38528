"""Writing files whole or not at all."""

import os
from pathlib import Path

from specs.errors import JobError


class OutputError(JobError):
    """A result cannot be written where it was asked for."""

    def __init__(self, path: Path, reason: str, advice: str = "Name another place.") -> None:
        """Say which file, why, and what to do."""
        super().__init__(f"{path}: cannot be written: {reason}. {advice}")
        self.path = path


def write_text_atomically(path: Path, text: str) -> None:
    """Write UTF-8 text; see ``write_bytes_atomically``. Line ends stay as they are.

    Raises:
        OutputError: the file cannot be written; what stood there before still does.
    """
    write_bytes_atomically(path, text.encode("utf-8", errors="replace"))


def write_bytes_atomically(path: Path, content: bytes) -> None:
    """Write a file so that it is there as a whole or, after any failure, as it was before.

    The content goes to a temporary file in the same folder, is flushed to the disk and renamed. A link is followed;
    a device or pipe, such as ``/dev/stdout``, is written directly.

    Raises:
        OutputError: the file cannot be written; what stood there before still does.
    """
    try:
        target = Path(os.path.realpath(path))
        if target.exists() and not target.is_file():
            target.write_bytes(content)
            return
        _replace(target, content)
    except (OSError, ValueError) as error:
        raise OutputError(path, getattr(error, "strerror", None) or str(error)) from None


def _replace(target: Path, content: bytes) -> None:
    temporary = target.with_name(f".{target.name[:200]}.{os.getpid()}.tmp")
    try:
        with temporary.open("xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        if target.exists():
            temporary.chmod(target.stat().st_mode & 0o7777)
        temporary.replace(target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
