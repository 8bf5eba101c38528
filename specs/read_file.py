"""Reading of the files that a person names: regular ones of a bounded size, opened without waiting for anyone."""

import io
import os
import stat
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

from specs.confinement import refusal
from specs.errors import ErrorFactory, JobError, LocatedError

_CHUNK = 1 << 20
_OTHERS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def check_file(file: Path, error: ErrorFactory, noun: str, largest: int, *, missing: str = "") -> None:
    """Refuse what is no regular file of at most so many bytes, or not among those of a page, before anything opens it.

    Args:
        file: As it was named; links are followed.
        error: Of the kind of file.
        noun: What the file is, such as ``"recipe"``.
        largest: Bytes.
        missing: What to do where there is no such file; left out, to give the path of one.

    Raises:
        JobError: by ``error``: it is missing, not readable, a directory, a pipe, a device, a socket, or too large, or
            lies outside of what this process may read.
    """
    if reason := refusal(file):
        raise error(reason, file=file)
    try:
        _check_status(Path(file).stat(), file, error, (noun, largest))
    except (OSError, ValueError) as reason:
        raise _unreadable(reason, file, error, (noun, missing)) from None


def read_file(file: Path, error: ErrorFactory, noun: str, largest: int, *, missing: str = "") -> bytes:
    """Read a regular file as a whole; arguments and errors are those of ``check_file``."""
    with open_file(file, error, noun, largest, missing=missing) as stream:
        try:
            status = os.fstat(stream.fileno())
            parts: list[bytes] = []
            total = 0
            # One byte more than it has: the first part is all of it, and the second is empty unless the file grows.
            while part := stream.read(max(status.st_size + 1 - total, _CHUNK)):
                parts.append(part)
                total += len(part)
                if total > largest:
                    raise _too_large(total, file, error, (noun, largest))
            return b"".join(parts)
        except (OSError, ValueError) as reason:
            raise _unreadable(reason, file, error, (noun, missing)) from None


@contextmanager
def open_file(file: Path, error: ErrorFactory, noun: str, largest: int, *, missing: str = "") -> Generator[io.FileIO]:
    """Open a regular file to read it in pieces; arguments and errors are those of ``check_file``.

    A pipe or a device that takes the file's place meanwhile is neither waited for nor read.
    """
    check_file(file, error, noun, largest, missing=missing)
    try:
        stream = io.FileIO(os.open(file, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC))
    except (OSError, ValueError) as reason:
        raise _unreadable(reason, file, error, (noun, missing)) from None
    with stream:
        _check_status(os.fstat(stream.fileno()), file, error, (noun, largest))
        yield stream


def read_head(file: Path, size: int) -> bytes:
    """Read the first bytes of a regular file, to see what it is; none of anything else, or where it cannot be read."""
    with suppress(JobError), open_file(file, LocatedError, "file", sys.maxsize) as stream:
        return stream.read(size) or b""
    return b""


def _check_status(status: os.stat_result, file: Path, error: ErrorFactory, kind: tuple[str, int]) -> None:
    noun, _ = kind
    if stat.S_ISDIR(status.st_mode):
        raise error(f"is a directory, not a file; give the path of a {noun}", file=file)
    for is_other, word in _OTHERS:
        if is_other(status.st_mode):
            raise error(f"is {word}, not a file; save its content and give the path of that", file=file)
    if status.st_size > kind[1]:
        raise _too_large(status.st_size, file, error, kind)


def _too_large(size: int, file: Path, error: ErrorFactory, kind: tuple[str, int]) -> JobError:
    noun, largest = kind
    return error(f"{size:,} bytes are too many; a {noun} has at most {largest:,}", file=file)


def _unreadable(reason: OSError | ValueError, file: Path, error: ErrorFactory, words: tuple[str, str]) -> JobError:
    noun, missing = words
    if isinstance(reason, FileNotFoundError):
        return error(f"no such file; {missing or f'give the path of a {noun}'}", file=file)
    return error(f"cannot be read: {getattr(reason, 'strerror', None) or reason}", file=file)
