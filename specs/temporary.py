"""Temporary files and folders that are known to be somebody's, or nobody's any more.

Each has an owner file ``.washboard-PID-SERIAL.tmp`` on which its process holds a lock (flock) as long as it lives: the
kernel drops the lock however the process ends, on this machine and on others that share the folder. What can be locked
by another belongs to no one and is removed at the next writing beside it. A temporary folder stands beside its owner
file, with ``.d`` at the end of its name.
"""

import errno
import fcntl
import os
import re
import secrets
import shutil
import stat
import tempfile
from collections.abc import Generator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

from specs import ending
from specs.errors import JobError

_NAME = re.compile(r"\.washboard-\d+-[0-9a-f]{16}\.tmp")
_FOLDER = ".d"
_NO_LOCKS = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL, errno.EACCES, errno.EPERM}
REPLACED = "replaced"
"""In a temporary folder: what the folder that it is to replace held, where the two cannot be exchanged at once."""


@contextmanager
def temporary_file(folder: Path) -> Generator[tuple[Path, int]]:
    """Give a new locked file and its descriptor; it is removed at the end of the block, unless it has been renamed.

    Raises:
        OSError: none can be made there.
    """
    sweep(folder)
    made: list[Path] = []
    with ending.undone_at_end(lambda: _remove(*made)):
        with ending.lock:
            path, descriptor = _make_owner(folder)
            made.append(path)
        try:
            yield path, descriptor
        finally:
            with ending.lock:
                _remove(path)
                os.close(descriptor)


@contextmanager
def temporary_folder(parent: Path | None = None, *, replaces: str = "") -> Generator[Path]:
    """Give a new empty folder; it is removed at the end of the block.

    Args:
        parent: Where it is made; left out, where temporary files of the system are, and only this user can read it.
        replaces: Name of the folder beside it that it is to replace.

    Raises:
        OSError: none can be made there.
        JobError: the system's place for temporary files is full, at any moment of the block, or cannot be used.
    """
    try:
        place = Path(tempfile.gettempdir()) if parent is None else parent
    except FileNotFoundError as error:  # its text lists the folders that were tried
        raise JobError(f"no folder takes temporary files ({error.strerror or error}): name one in TMPDIR.") from None
    try:
        with _folder_in(place, private=parent is None, replaces=replaces) as folder:
            yield folder
    except OSError as error:
        is_full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        if parent is not None or not (is_full or str(error.filename or "").startswith(f"{place}{os.sep}")):
            raise
        reason = "is full. Free some space" if is_full else f"cannot be used: {error.strerror}. Repair that"
        message = f"the folder for temporary files, {place}, {reason}, or name another one in the environment variable"
        raise JobError(f"{message} TMPDIR.") from None


@contextmanager
def _folder_in(place: Path, *, private: bool, replaces: str) -> Generator[Path]:
    with temporary_file(place) as (owner, descriptor):
        if replaces:
            os.write(descriptor, os.fsencode(replaces))
        folder = _folder_of(owner)
        with ending.undone_at_end(partial(shutil.rmtree, folder, ignore_errors=True)):
            with ending.lock:
                folder.mkdir(mode=0o700 if private else 0o777)
            try:
                yield folder
            finally:
                with ending.lock:
                    shutil.rmtree(folder, ignore_errors=True)


def write_temporary(folder: Path, name: str, content: bytes) -> Path:
    """Write a file into a temporary folder.

    Raises:
        OSError: it cannot be written; ``temporary_folder`` states so.
    """
    file = folder / name
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    except OSError as error:  # that of writing names no file
        raise OSError(error.errno, error.strerror, str(file)) from None
    return file


def read_temporary(folder: Path, name: str) -> bytes:
    """Read a file that a library wrote into a temporary folder.

    Raises:
        OSError: it cannot be read.
    """
    return (folder / name).read_bytes()


def sweep(folder: Path) -> None:
    """Remove what processes of this user that ended halfway left in a folder; links are not followed."""
    try:
        owners = [path for path in folder.iterdir() if _NAME.fullmatch(path.name)]
    except OSError:
        return
    for path in owners:
        with suppress(OSError):
            _sweep_one(path)


def _make_owner(folder: Path) -> tuple[Path, int]:
    """Make an owner file and lock it; again if a sweep of another process was between the two."""
    while True:
        path = folder / f".washboard-{os.getpid()}-{secrets.token_hex(8)}.tmp"
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(descriptor)
            continue
        except OSError as error:
            if error.errno in _NO_LOCKS:  # a file system without locks: nothing is swept there either
                return path, descriptor
            os.close(descriptor)
            path.unlink()
            raise OSError(error.errno, error.strerror, str(path)) from None  # that of locking names no file
        if os.fstat(descriptor).st_nlink:
            return path, descriptor
        os.close(descriptor)


def _sweep_one(path: Path) -> None:
    """Remove a temporary of a process that has ended.

    Raises:
        OSError: it is not this user's, is in use, or cannot be removed.
    """
    descriptor = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        found = os.fstat(descriptor)
        if not stat.S_ISREG(found.st_mode) or found.st_uid != os.geteuid():
            return
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        folder = _folder_of(path)
        if folder.is_dir() and not folder.is_symlink():
            # A folder that was moved away to be replaced is put back, if nothing stands in its place.
            name, kept = os.fsdecode(os.read(descriptor, 1024)), folder / REPLACED
            target = folder.with_name(name) if name and "/" not in name else folder
            if kept.is_dir() and not kept.is_symlink() and not os.path.lexists(target):
                kept.rename(target)
            shutil.rmtree(folder)
        path.unlink()
    finally:
        os.close(descriptor)


def _remove(*owners: Path) -> None:
    """Remove owner files, but not one whose folder could not be removed: the next sweep needs it, or does it then."""
    for path in owners:
        with suppress(OSError):
            if not _folder_of(path).exists():
                path.unlink(missing_ok=True)


def _folder_of(owner: Path) -> Path:
    return owner.with_name(owner.name + _FOLDER)
