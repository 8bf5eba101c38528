"""Writing files whole or not at all, and folders of several files as one."""

import ctypes
import errno
import os
import re
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path

from specs import ending
from specs.errors import JobError, printable
from specs.temporary import REPLACED, sweep, temporary_file, temporary_folder

_HERE = -100
_EXCHANGE = 2
"""AT_FDCWD and RENAME_EXCHANGE of Linux's renameat2."""


class OutputError(JobError):
    """A result cannot be written at the place that was given."""

    def __init__(self, path: Path, reason: str, advice: str = "Name another place.") -> None:
        """State which file, why, and what to do."""
        super().__init__(printable(f"{path}: cannot be written: {reason}. {advice}"))
        self.path = path


@contextmanager
def output_errors(path: Path) -> Generator[None]:
    """Turn what the system refuses at a path into an ``OutputError``.

    Raises:
        OutputError: the path cannot be used.
    """
    try:
        yield
    except (OSError, ValueError) as error:
        raise OutputError(path, getattr(error, "strerror", None) or str(error)) from None


def write_outputs(contents: Mapping[Path | None, str | bytes | None]) -> None:
    """Write the results of a command, once all of them are rendered; those without path or content are left out.

    Raises:
        OutputError: one of them cannot be written.
    """
    for path, content in contents.items():
        if path is not None and content is not None:
            data = content.encode("utf-8", errors="replace") if isinstance(content, str) else content
            write_bytes_atomically(path, data)


def write_text_atomically(path: Path, text: str) -> None:
    """Write UTF-8 text; see ``write_bytes_atomically``. Line ends stay as they are.

    Raises:
        OutputError: the file cannot be written; what stood there before still does.
    """
    write_bytes_atomically(path, text.encode("utf-8", errors="replace"))


def write_bytes_atomically(path: Path, content: bytes, known_as: Path | None = None) -> None:
    """Write a file so that it is there as a whole or, after any failure, as it was before.

    The content goes to a temporary file in the same folder, is flushed to the disk and renamed. A link is followed;
    a device or pipe, such as ``/dev/stdout``, is written directly. What processes that were killed left in the folder
    is removed.

    Args:
        path: The file.
        content: What it is to hold.
        known_as: What an interrupt names as written in its place, such as the folder of many files.

    Raises:
        OutputError: the file cannot be written; what stood there before still does.
    """
    with output_errors(path):
        target = Path(os.path.realpath(path))
        if target.exists() and not target.is_file():
            target.write_bytes(content)
            return
        with temporary_file(target.parent) as (temporary, descriptor):
            if target.exists():
                os.fchmod(descriptor, target.stat().st_mode & 0o7777)
            _write_flushed(descriptor, content)
            with ending.lock:
                temporary.replace(target)
                ending.note_written(known_as or path)


def write_files(folder: Path, files: Mapping[str, str | bytes]) -> list[Path]:
    """Write files into a folder so that after any failure what stood there before still does; give their paths.

    Texts are ASCII. The folder is made where there is none. A single file joins what is in it; several are a set of
    their own, and replace an earlier set of the same files as a whole.

    Raises:
        OutputError: they cannot be written there, or something else is there.
    """
    with output_errors(folder):
        if folder.is_dir():
            sweep(folder)
        _check_folder(folder, files)
        if len(files) > 1:
            _replace_folder(folder, files)
            return [folder / name for name in files]
        folder.mkdir(exist_ok=True)
    ((name, text),) = files.items()
    write_bytes_atomically(folder / name, _bytes_of(text))
    return [folder / name]


def _check_folder(out: Path, files: Mapping[str, str | bytes]) -> None:
    """Refuse a place that is no folder, or for several files one that holds anything but earlier versions of them."""
    if not out.exists():
        if not out.parent.is_dir():
            raise OutputError(out, f"there is no folder {out.parent}", "Make it, or name another place.")
        return
    if not out.is_dir():
        raise OutputError(out, "a folder is to be written and this is a file", "Name a folder.")
    if len(files) == 1:
        return
    known = {_family(name) for name in files}
    for entry in sorted(out.iterdir()):
        if entry.is_symlink() or not entry.is_file() or _family(entry.name) not in known:
            raise OutputError(out, f"the folder holds something else, {entry.name}", "Name a folder of its own.")


def _bytes_of(content: str | bytes) -> bytes:
    return content.encode("ascii") if isinstance(content, str) else content


def _family(name: str) -> str:
    """A file's name without the numbers that count the parts of a program."""
    return re.sub(r"\d+", "#", name.lower())


def _replace_folder(out: Path, files: Mapping[str, str | bytes]) -> None:
    target = Path(os.path.realpath(out))
    with temporary_folder(target.parent, replaces=target.name) as folder:
        fresh, kept = folder / "new", folder / REPLACED
        fresh.mkdir()
        for name, text in files.items():
            with (fresh / name).open("xb") as file:
                _write_flushed(file.fileno(), _bytes_of(text))
        with ending.lock:
            if not target.exists():
                fresh.rename(target)
            elif not _exchange(fresh, target):  # a moment in between without either; the next sweep would mend it
                target.rename(kept)
                try:
                    fresh.rename(target)
                except OSError:
                    kept.rename(target)
                    raise
            ending.note_written(out)


def _exchange(one: Path, other: Path) -> bool:
    """Exchange two folders in one step; ``False`` where the file system or the C library cannot.

    Raises:
        OSError: it is refused.
    """
    try:
        rename = ctypes.CDLL(None, use_errno=True).renameat2
    except (AttributeError, OSError):
        return False
    if rename(_HERE, os.fsencode(one), _HERE, os.fsencode(other), _EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in (errno.EINVAL, errno.ENOSYS, errno.EOPNOTSUPP):
        return False
    raise OSError(number, os.strerror(number))


def _write_flushed(descriptor: int, content: bytes) -> None:
    """Write all of a new file, down to the disk."""
    with open(descriptor, "wb", closefd=False) as file:
        file.write(content)
        file.flush()
        os.fsync(descriptor)
