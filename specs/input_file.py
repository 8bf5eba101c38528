"""``InputFile``: the one way in. Regular files of a bounded size, opened without waiting for anyone."""

import io
import os
import stat
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from specs.confinement import refusal
from specs.errors import ErrorFactory, JobError, LocatedError

_CHUNK = 1 << 20
_OTHERS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


@dataclass(frozen=True, slots=True)
class InputFile:
    """A file to read, with what it may be. Its errors are of its kind: what, which file, and what to do."""

    path: Path
    """As it was named; links are followed."""
    error: ErrorFactory = LocatedError
    noun: str = "file"
    """What it is, such as ``"recipe"``."""
    largest: int = sys.maxsize
    """Bytes."""
    missing: str = ""
    """What to do where there is no such file; left out, to give the path of one."""

    def check(self) -> None:
        """Refuse what is no regular file of at most so many bytes, or not among those of a page.

        Raises:
            JobError: by ``error``: it is missing, not readable, a directory, a pipe, a device, a socket, or too large,
                or lies outside of what this process may read.
        """
        if reason := refusal(self.path):
            raise self.error(reason, file=self.path)
        try:
            self._check_status(Path(self.path).stat())
        except (OSError, ValueError) as reason:
            raise self._unreadable(reason) from None

    def check_kind(self) -> None:
        """Refuse what no reader takes, before any work begins; what is not there, and folders, are left to readers.

        Raises:
            JobError: by ``error``: it is a pipe, a device, a socket, a link that leads nowhere, or cannot be looked at.
        """
        try:
            status = self.path.stat()
        except (OSError, ValueError) as reason:
            if os.path.lexists(self.path):
                raise self.error("is a link that leads nowhere; give the path of a file", file=self.path) from None
            if not isinstance(reason, FileNotFoundError | NotADirectoryError):
                raise self._unreadable(reason) from None
            return
        if not stat.S_ISDIR(status.st_mode):
            self._check_status(status)

    def read(self) -> bytes:
        """Read all of it; errors are those of ``check``."""
        with self.stream() as stream:
            try:
                status = os.fstat(stream.fileno())
                parts: list[bytes] = []
                total = 0
                # One byte more than it has: the first part is all of it, and the second is empty unless it grows.
                while part := stream.read(max(status.st_size + 1 - total, _CHUNK)):
                    parts.append(part)
                    total += len(part)
                    if total > self.largest:
                        raise self._too_large(total)
                return b"".join(parts)
            except OSError as reason:
                raise self._unreadable(reason) from None

    def text(self, refused: str = "is not UTF-8 text; save it as UTF-8", encoding: str = "utf-8-sig") -> str:
        """Read all of it as text, without the byte order mark that some editors put in front.

        Args:
            refused: Of a file in another encoding.
            encoding: ``"utf-8-sig"`` or ``"ascii"``.

        Raises:
            JobError: by ``error``: as ``check``, or it is no text; the message names the line.
        """
        content = self.read()
        try:
            return content.decode(encoding)
        except UnicodeDecodeError as error:
            line = content.count(b"\n", 0, error.start) + 1
            raise self.error(refused, file=self.path, line=line) from None

    @contextmanager
    def stream(self) -> Generator[io.RawIOBase]:
        """Open it to read in pieces; errors, those of reading as well, are those of ``check``.

        A pipe or a device that takes the file's place meanwhile is neither waited for nor read.
        """
        self.check()
        try:
            file = io.FileIO(os.open(self.path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC))
        except (OSError, ValueError) as reason:
            raise self._unreadable(reason) from None
        with file:
            self._check_status(os.fstat(file.fileno()))
            yield _Stream(file, self._unreadable)

    def head(self, size: int) -> bytes:
        """Read the first bytes, to see what it is; none of a folder, or of what is not there.

        Raises:
            JobError: by ``error``: as ``check_kind``, or it cannot be opened or read.
        """
        self.check_kind()
        if not self.path.is_file():
            return b""
        with self.stream() as stream:
            return stream.read(size) or b""

    def _check_status(self, status: os.stat_result) -> None:
        if stat.S_ISDIR(status.st_mode):
            raise self.error(f"is a directory, not a file; give the path of a {self.noun}", file=self.path)
        for is_other, word in _OTHERS:
            if is_other(status.st_mode):
                message = f"is {word}, not a file; save its content and give the path of that"
                raise self.error(message, file=self.path)
        if status.st_size > self.largest:
            raise self._too_large(status.st_size)

    def _too_large(self, size: int) -> JobError:
        return self.error(f"{size:,} bytes are too many; a {self.noun} has at most {self.largest:,}", file=self.path)

    def _unreadable(self, reason: OSError | ValueError) -> JobError:
        if isinstance(reason, FileNotFoundError):
            return self.error(f"no such file; {self.missing or f'give the path of a {self.noun}'}", file=self.path)
        return self.error(f"cannot be read: {getattr(reason, 'strerror', None) or reason}", file=self.path)


class _Stream(io.RawIOBase):
    """A file that libraries read: what the system refuses is no error of theirs, such as of a damaged archive."""

    def __init__(self, file: io.FileIO, refused: Callable[[OSError], JobError]) -> None:
        self._file, self._refused = file, refused

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._file.fileno()

    def seek(self, offset: int, whence: int = os.SEEK_SET, /) -> int:
        return self._file.seek(offset, whence)

    def readinto(self, buffer: Any, /) -> int:
        try:
            return self._file.readinto(buffer) or 0
        except OSError as reason:
            raise self._refused(reason) from None


def own_text(package: str, name: str) -> str:
    """Read a text that comes with a package of ours."""
    return files(package).joinpath(name).read_text("utf-8")
