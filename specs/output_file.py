"""``OutputFile`` and ``OutputFolder``: the one way out. Whole or not at all, at places judged before the work."""

import errno
import fcntl
import io
import os
import re
import stat
import sys
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from specs import ending
from specs.confinement import note_own, was_read
from specs.errors import JobError, printable
from specs.temporary import REPLACED, sweep, temporary_file, temporary_folder

_HERE = -100
_EXCHANGE = 2
"""AT_FDCWD and RENAME_EXCHANGE of Linux's renameat2."""
_MOST_LINKS = 40
PART = ".part"
"""Ending of the file beside a log in which its lines grow."""
_OPENED = os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOFOLLOW


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


@dataclass(frozen=True, slots=True)
class OutputPlace:
    """A file or a folder to write."""

    path: Path

    def __fspath__(self) -> str:
        """Give the path."""
        return str(self.path)

    __str__ = __fspath__

    @property
    def real(self) -> Path:
        """Where it is with all links resolved."""
        return Path(os.path.realpath(self.path))

    def check(self) -> None:
        """Refuse a place where nothing can be written, before the work begins.

        Raises:
            OutputError: it is one.
        """
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class OutputFile(OutputPlace):
    """A file to write; what stood there stays until all of it is on the disk."""

    kind: str = ""
    """What it is, such as ``"a program"``; left out where its name may have any ending."""
    beside: tuple[str, ...] = ()
    """Endings of the files that grow beside it under its name, such as ``".part"``."""
    in_place: bool = False
    """Whether it may take the place of the file that is read and edited."""

    @property
    def all_written(self) -> "tuple[OutputFile, ...]":
        """This file and those beside it; a device or a pipe has none."""
        beside = () if self.takes_bytes or not self.path.name else self.beside
        return self, *(OutputFile(self._named(ending)) for ending in beside)

    @property
    def _place(self) -> Path:
        """The path as it was named, or what a link leads to."""
        return self.real if self.path.is_symlink() else self.path

    def _named(self, ending: str) -> Path:
        return self._place.with_name(f"{self._place.name}{ending}")

    def check(self) -> None:
        """Refuse a place where no file can be written, before the work begins.

        Raises:
            OutputError: it is a folder or in none, a block device or a socket, not writable, or stands for stdout.
        """
        if self.path == Path("-"):
            raise OutputError(self.path, "stdout has the summary", "Name a file.")
        with output_errors(self.path):
            real = self.real
            if real.is_dir():
                raise OutputError(self.path, "it is a folder", "Name a file in it.")
            if not real.parent.is_dir():
                raise OutputError(
                    self.path, f"there is no folder {self._place.parent}", "Make it, or name another place."
                )
            if real.is_block_device() or real.is_socket():
                raise OutputError(self.path, "it is a device or a socket", "Name a file.")
            if not os.access(self.path if self.takes_bytes else real.parent, os.W_OK):
                raise OutputError(self.path, "permission denied")

    @property
    def takes_bytes(self) -> bool:
        """Whether what is there takes bytes as they come: a character device, a pipe, or a file that is open here.

        Raises:
            OutputError: that cannot be found out, or this process has opened it for itself.
        """
        with output_errors(self.path):
            if (own := _own_descriptor(self.path)) is not None:
                if not os.get_inheritable(own):  # what this process has opened for itself
                    raise OutputError(self.path, "it is none that the command was started with")
                return True
            return self.path.is_char_device() or self.path.is_fifo()

    def holds(self, content: bytes) -> bool:
        """Whether the file is there with this content; a link to it is not it."""
        if self.path.is_symlink():
            return False
        try:
            with os.fdopen(os.open(self.path, os.O_RDONLY | _OPENED), "rb") as file:
                status = os.fstat(file.fileno())
                return stat.S_ISREG(status.st_mode) and status.st_size == len(content) and file.read() == content
        except (OSError, ValueError):
            return False

    def write(self, content: str | bytes, known_as: Path | None = None) -> None:
        """Write the file so that it is there as a whole or, after any failure, as it was before.

        The content goes to a temporary file in the same folder, is flushed to the disk and renamed. A link is followed;
        a character device, a pipe or ``/dev/stdout`` takes the bytes directly. What processes that were killed
        left in the folder is removed.

        Args:
            content: What it is to hold; text becomes UTF-8 with its line ends as they are.
            known_as: What an interrupt names as written in its place, such as the folder of many files.

        Raises:
            OutputError: the file cannot be written; what stood there before still does.
        """
        if self.takes_bytes:
            with output_errors(self.path), os.fdopen(_open_taker(self.path), "wb") as file:
                file.write(_utf8(content))
            return
        with self.staged(content) as temporary, ending.lock:
            temporary.replace(self.real)
            ending.note_written(known_as or self.path)

    def begins(self, words: bytes) -> bool:
        """Whether what stands there begins so."""
        with suppress(OSError, ValueError), io.FileIO(os.open(self.path, os.O_RDONLY | os.O_NONBLOCK)) as file:
            return file.read(len(words)) == words
        return False

    def check_unread(self) -> None:
        """Refuse a file that this command has read, as what an input names: a panel its board.

        Raises:
            OutputError: it is one.
        """
        if was_read(self.path):
            raise OutputError(self.path, "it is read by this command", "Name another file.")
        note_own(self.path)

    @contextmanager
    def staged(self, content: str | bytes) -> Generator[Path]:
        """Give a temporary file beside it that has the content, down to the disk; it is removed unless it is renamed.

        Raises:
            OutputError: it cannot be written, or what is in the place of the file is none.
        """
        self.check_unread()
        with output_errors(self.path):
            target = self.real
            if target.exists() and not target.is_file():
                raise OutputError(self.path, "it is no file")
            with temporary_file(target.parent) as (temporary, descriptor):
                _keep_mode(target, descriptor)
                _write_flushed(descriptor, _utf8(content))
                yield temporary

    def remove(self) -> None:
        """Remove the file, or a link in its place, if it is there.

        Raises:
            OutputError: it cannot be removed.
        """
        try:
            with ending.lock:
                self.path.unlink(missing_ok=True)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise OutputError(self.path, f"it is to be removed: {reason}", "Remove it by hand.") from None

    @contextmanager
    def lines(self) -> Generator[Callable[[str], object]]:
        """Give what takes lines as they are made: they go to FILE.part at once, which becomes the file at the end.

        Whatever ends the process leaves the lines until then, if there are any, in FILE.part. A device or a pipe takes
        them itself.

        Raises:
            OutputError: it cannot be written, or another process writes it.
        """
        if self.takes_bytes:
            with output_errors(self.path):
                file = io.FileIO(_open_taker(self.path), "wb")
            with file:
                yield partial(self._add, file)
            return
        self.check_unread()
        target, part = self.real, OutputFile(self._named(PART))
        with part.locked() as descriptor:
            with output_errors(self.path):
                file = io.FileIO(descriptor, "wb", closefd=False)
                os.ftruncate(descriptor, 0)
            try:
                with file:
                    yield partial(self._add, file)
            except BaseException:
                if not os.fstat(descriptor).st_size:
                    part.remove()
                raise
            with output_errors(self.path), ending.lock:
                os.fsync(descriptor)
                part.path.replace(target)
                ending.note_written(self.path)

    def _add(self, file: io.FileIO, line: str) -> None:
        """Write all of a line: the system may take a part of it, as where a disk is almost full."""
        left = memoryview(line.encode())
        with output_errors(self.path):
            while left:
                left = left[file.write(left) :]

    @contextmanager
    def locked(self) -> Generator[int]:
        """Open the file, made where there is none, to read and write it in place, and keep other processes out of it.

        Raises:
            OutputError: it cannot be opened, is no regular file, or another process has it.
        """
        with output_errors(self.path):
            descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT | _OPENED, 0o666)
        try:
            with output_errors(self.path):
                if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                    raise OutputError(self.path, "it is no file")
                try:
                    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    is_there = os.path.samestat(os.fstat(descriptor), os.lstat(self.path))
                except (BlockingIOError, FileNotFoundError):
                    is_there = False
            if not is_there:  # or it has just been given its own name by the process that wrote it
                raise OutputError(self.path, "another process writes it", "Wait for that, or name another file.")
            yield descriptor
        finally:
            os.close(descriptor)


@dataclass(frozen=True, slots=True)
class OutputFolder(OutputPlace):
    """A folder to write files into, made with those above it where there is none."""

    only: str = ""
    """Pattern of the names of all files of the set that it is for and replaces, as far as it is known beforehand."""

    def check(self) -> None:
        """Refuse a folder that is none and cannot be made, or is for other files, before the work begins.

        Raises:
            OutputError: it, or what it is to be made in, is no folder or not writable, or it holds something else.
        """
        with output_errors(self.path):
            there = next((each for each in (self.path, *self.path.parents) if os.path.lexists(each)), Path())
            if not there.is_dir():
                raise OutputError(self.path, f"{there} is not a folder")
            if not os.access(there, os.W_OK):
                raise OutputError(self.path, "permission denied")
            if self.only and self.path.is_dir():
                self._check_entries(lambda name: re.fullmatch(self.only, name, re.IGNORECASE) is not None)
                if self.path.is_mount() or not os.access(self.real.parent, os.W_OK):
                    reason = "it is replaced as a whole, and the folder that it is in takes no other"
                    raise OutputError(self.path, reason, "Name a folder in it.")

    def make(self, *, private: bool = False) -> None:
        """Make the folder where there is none, if so stated for its owner alone.

        Raises:
            OutputError: it cannot be made; or it is to be private, and another user owns it or what it is in.
        """
        for folder in reversed([self.path, *(each for each in self.path.parents if not each.exists())]):
            with output_errors(folder):
                folder.mkdir(0o700 if private and folder == self.path else 0o777, exist_ok=True)
        with output_errors(self.path):
            if private:
                for folder in (self.path.parent, self.path):
                    if folder.is_symlink() or folder.stat().st_uid != os.geteuid():
                        raise OutputError(self.path, f"another user owns {folder}", "Remove it, or have it removed.")
                self.path.chmod(0o700)

    def write(self, files: Mapping[str, str | bytes]) -> list[Path]:
        """Write a set of files so that after any failure what stood there before still does; give their paths.

        It replaces an earlier set of the same files as a whole.

        Raises:
            OutputError: they cannot be written there, or something else is there.
        """
        with output_errors(self.path):
            self._check_content(files)
            self.path.parent.mkdir(parents=True, exist_ok=True)
            _replace_folder(self.path, files)
        return [self.path / name for name in files]

    def add(self, files: Mapping[str, str | bytes]) -> list[Path]:
        """Write files, all of them or none, that join what is in the folder; give their paths.

        Raises:
            OutputError: they cannot be written there.
        """
        if self.path.exists() and not self.path.is_dir():
            raise OutputError(self.path, "a folder is to be written and this is a file", "Name a folder.")
        self.make()
        write_outputs({OutputFile(self.path / name): content for name, content in files.items()})
        return [self.path / name for name in files]

    def _check_content(self, files: Mapping[str, str | bytes]) -> None:
        """Refuse what is no folder, or one that holds anything but earlier versions of the files."""
        if not self.path.exists():
            return
        if not self.path.is_dir():
            raise OutputError(self.path, "a folder is to be written and this is a file", "Name a folder.")
        known = _names_of_set(files)
        own = re.compile(self.only or "(?!)", re.IGNORECASE)
        for entry in self._check_entries(lambda name: bool(known(name) or own.fullmatch(name))):
            OutputFile(entry).check_unread()

    def _check_entries(self, is_known: Callable[[str], bool]) -> list[Path]:
        """Give what the folder holds; refuse any but files of known names."""
        sweep(self.path)
        entries = sorted(self.path.iterdir())
        for entry in entries:
            if entry.is_symlink() or not entry.is_file() or not is_known(entry.name):
                raise OutputError(
                    self.path, f"the folder holds something else, {entry.name}", "Name a folder of its own."
                )
        return entries

    @contextmanager
    def locked(self) -> Generator[None]:
        """Keep other processes that do the same out of the folder.

        Raises:
            OutputError: it cannot be opened, or another process is in it.
        """
        with output_errors(self.path):
            descriptor = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            with output_errors(self.path):
                try:
                    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    raise OutputError(self.path, "another process uses it", "Wait for that, or name another.") from None
            yield
        finally:
            os.close(descriptor)


def output_place(path: str | Path) -> OutputPlace:
    """Read a place for one file or several: with a suffix, and no folder by now, it is a file, any other a folder."""
    place = Path(path)
    return OutputFile(place) if place.suffix and not place.is_dir() else OutputFolder(place)


def write_outputs(contents: Mapping[OutputFile | None, str | bytes | None]) -> None:
    """Write the results of a command, once all of them are rendered; those without place or content are left out.

    Devices and pipes take theirs once all files are on the disk under other names; then all files are there, or after
    any failure all are as they were before.

    Raises:
        OutputError: one of them cannot be written.
    """
    given = {file: content for file, content in contents.items() if file is not None and content is not None}
    for file in given:
        file.check_unread()
    takers = [file for file in given if file.takes_bytes]
    with ExitStack() as stack:
        staged = {stack.enter_context(file.staged(each)): file for file, each in given.items() if file not in takers}
        for file in takers:
            file.write(given[file])
        with ending.lock:
            _put_all(staged)


def _put_all(staged: Mapping[Path, OutputFile]) -> None:
    """Rename temporary files to files, and back where one of them cannot be and the system can exchange files."""
    put: list[tuple[Path, Path, bool]] = []
    try:
        for temporary, file in staged.items():
            with output_errors(file.path):
                was_there = file.real.exists()
                if not (was_there and _exchange(temporary, file.real)):
                    temporary.replace(file.real)
                put.append((temporary, file.real, was_there))
    except OutputError:
        for temporary, target, was_there in put:
            if not was_there:
                target.unlink()
            elif temporary.exists():
                temporary.replace(target)
        raise
    for file in staged.values():
        ending.note_written(file.path)


def _own_descriptor(place: Path) -> int | None:
    """Descriptor of this process that a path stands for, as ``/dev/stdout`` does; ``None`` of any other."""
    for _ in range(_MOST_LINKS):
        folder = os.path.realpath(place.parent)
        if folder == f"/proc/{os.getpid()}/fd" and place.name.isdecimal():
            return int(place.name) if place.is_symlink() else None
        if not place.is_symlink():
            return None
        place = Path(folder, place.readlink())
    return None


def _open_taker(place: Path) -> int:
    """Open a device or a pipe without waiting for who reads it, or what is open already; gives the descriptor.

    Raises:
        OSError: nobody does, or it is refused.
    """
    own = _own_descriptor(place)
    if own is not None and stat.S_ISREG(os.fstat(own).st_mode):  # its bytes go behind those that are there
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        return os.dup(own)
    try:
        descriptor = os.open(place, os.O_WRONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    except OSError as error:
        if error.errno == errno.ENXIO:
            raise OSError(errno.ENXIO, "nobody reads from this pipe") from None
        raise
    os.set_blocking(descriptor, True)
    return descriptor


def _utf8(content: str | bytes) -> bytes:
    return content.encode("utf-8", errors="replace") if isinstance(content, str) else content


def _names_of_set(files: Iterable[str]) -> Callable[[str], bool]:
    """Give whether a name is that of a file of an earlier version of a set: the same, or another number of a part.

    A number at the end of a name counts parts where several files differ in it, or it follows the name of one of them.
    """
    names = {name.lower() for name in files}
    stems = {name.partition(".")[0] for name in names}
    counted = Counter(_family(name) for name in names)
    parts = {
        family for family, count in counted.items()
        if "#" in family and (count > 1 or family.partition("#")[0].rstrip("_-") in stems)
    }  # fmt: skip
    return lambda name: name.lower() in names or _family(name.lower()) in parts


def _family(name: str) -> str:
    """A file's name without the number that its stem ends with."""
    return re.sub(r"^([^.]*?)\d+(?=\.|$)", r"\1#", name)


def _replace_folder(out: Path, files: Mapping[str, str | bytes]) -> None:
    target = Path(os.path.realpath(out))
    with temporary_folder(target.parent, replaces=target.name) as folder:
        fresh, kept = folder / "new", folder / REPLACED
        fresh.mkdir()
        for name, text in files.items():
            with (fresh / name).open("xb") as file:
                _write_flushed(file.fileno(), _utf8(text))
                _keep_mode(target / name, file.fileno())
        _keep_mode(target, fresh)
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


def _keep_mode(before: Path, now: int | Path) -> None:
    """Give a new file or folder the mode of the one whose place it takes, if there is one."""
    with suppress(FileNotFoundError):
        mode = before.stat().st_mode & 0o7777
        os.fchmod(now, mode) if isinstance(now, int) else now.chmod(mode)


def _exchange(one: Path, other: Path) -> bool:
    """Exchange two folders in one step; ``False`` where the file system or the C library cannot.

    Raises:
        OSError: it is refused.
    """
    import ctypes  # late: folders of several files are rare

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
