"""The system calls that this process makes on files of a command, counted, with a fault at one of them.

Calls that take a path are heard by an audit hook, which no library can go around; what they raise there is raised by
the call. Writing, reading and flushing are no events of the interpreter: streams of files under watch are made of
``WatchedFile``. A file that is renamed with bytes in it that were not seen so, or were not flushed, is reported.
"""

import builtins
import errno
import io
import json
import os
import re
import signal
import stat
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import astuple, dataclass
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any

from commandline.process import PACKAGES

_EVENTS = {
    "os.rename": "rename", "os.remove": "remove", "os.mkdir": "mkdir", "os.rmdir": "rmdir", "os.listdir": "list",
    "os.scandir": "list", "os.truncate": "truncate", "os.chmod": "chmod", "fcntl.flock": "lock",
}  # fmt: skip
_ALLOCATES = {"create", "write", "mkdir"}
_SERIAL = re.compile(r"\.washboard-\d+-[0-9a-f]{16}")
_PRODUCT = tuple(f"{Path(__file__).parents[2] / each}/" for each in PACKAGES)
_HEARD_S = 0.05
"""After an interrupt: the thread that waits for it has ended the process, or waits for the lock of a renaming."""


def _site(frame: FrameType | None) -> str:
    """The innermost line of the product."""
    while frame is not None and not frame.f_code.co_filename.startswith(_PRODUCT):
        frame = frame.f_back
    return "" if frame is None else f"{frame.f_code.co_filename}:{frame.f_lineno}"


@dataclass(frozen=True)
class Call:
    """One call."""

    event: str
    name: str
    """Of the file in its folder; the serial numbers of temporary files are left out."""
    place: str
    """``"input"``, ``"output"``, or ``"temporary"`` in the system's folder for those."""
    site: str
    """The innermost line of the product."""

    @property
    def kind(self) -> tuple[str, ...]:
        """What the calls at one site on files of one role share: of a folder of programs, or a front of recipes."""
        return self.event, self.site, self.place, Path(self.name).suffix


@dataclass(frozen=True)
class Fault:
    """What may go wrong at a call."""

    number: int
    """Of the error or of the signal; 0 where half is written, and nothing is wrong with that."""
    events: frozenset[str]
    """Where it occurs; at any call without."""
    is_signal: bool = False

    def occurs(self, call: Call) -> bool:
        """Whether it may occur at a call."""
        return not self.events or call.event in self.events


FAULTS = {
    "ENOSPC": Fault(errno.ENOSPC, frozenset({*_ALLOCATES, "rename", "truncate", "flush"})),
    "EIO": Fault(errno.EIO, frozenset()),
    # Python itself repeats opening, locking and flushing (PEP 475).
    "EINTR": Fault(errno.EINTR, frozenset({"write", "read", "rename", "remove", "mkdir", "rmdir", "list", "chmod"})),
    "EMFILE": Fault(errno.EMFILE, frozenset({"open", "create", "list"})),
    "short": Fault(0, frozenset({"write"})),
    "kill": Fault(signal.SIGKILL, frozenset(), is_signal=True),
    "interrupt": Fault(signal.SIGINT, frozenset(), is_signal=True),
}


class FaultyCalls:
    """Watches the calls on files below two folders. What it hears goes to a pipe, a line of JSON each."""

    def __init__(
        self, folders: tuple[Path, Path], inputs: frozenset[str], pipe: int, fault: tuple[Fault, int] | None
    ) -> None:
        """Watch the folder of the work and that of temporary files, with a fault at the call of a number."""
        self._work, self._temporary = (str(folder.resolve()) for folder in folders)
        self._inputs, self._pipe, self._fault = inputs, pipe, fault
        self._count = 0
        self._written, self._flushed = Counter[int](), set[int]()
        self._write, self._sync, self._open = os.write, os.fsync, io.open

    def install(self) -> None:
        """Begin to watch; there is no end."""
        import specs.output_file

        calls, exchange = self, specs.output_file._exchange

        class Watched(WatchedFile):
            watch = calls

        def write(descriptor: int, data: bytes) -> int:
            begin = partial(calls._write, descriptor, data[: len(data) // 2])
            written = calls.meet("write", descriptor, begin) or calls._write(descriptor, data)
            calls.wrote(descriptor, written)
            return written

        def sync(descriptor: int) -> None:
            calls.meet("flush", descriptor)
            calls._sync(descriptor)
            calls._flushed.add(os.fstat(descriptor).st_ino)

        def exchanged(one: Path, other: Path) -> bool:
            calls.check_flushed(one)
            calls.meet("exchange", other)
            return exchange(one, other)

        def opened(file: Any, mode: str = "r", buffering: int = -1, *more: Any, **named: Any) -> Any:
            if "b" not in mode or calls.place_of(file) is None:
                return calls._open(file, mode, buffering, *more, **named)
            more_of_it = {key: named[key] for key in ("closefd", "opener") if key in named}
            raw = Watched(file, mode.replace("b", ""), **more_of_it)
            kind = io.BufferedRandom if "+" in mode else io.BufferedReader if "r" in mode else io.BufferedWriter
            return raw if buffering == 0 else kind(raw)  # type: ignore[arg-type]

        os.write, os.fsync, io.FileIO, io.open, builtins.open = write, sync, Watched, opened, opened  # type: ignore
        specs.output_file._exchange = exchanged
        sys.addaudithook(self.hear)

    def hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Take an event of the interpreter."""
        if event == "open":
            is_new = bool(arguments[2] & os.O_CREAT) or any(letter in (arguments[1] or "") for letter in "wax")
            self.meet("create" if is_new else "open", arguments[0])
        elif event in _EVENTS:
            if event == "os.rename":
                self.check_flushed(Path(os.fsdecode(arguments[0])))
            self.meet(_EVENTS[event], arguments[0])

    def meet(self, event: str, file: Any, begin: Callable[[], int | None] = lambda: None) -> int | None:
        """Count a call, and have the fault occur if it is the one; half of the data is written then.

        Returns:
            How much was written, where the call is done with that.

        Raises:
            OSError: the fault.
        """
        place = self.place_of(file)
        if place is None:
            return None
        number, self._count = self._count, self._count + 1
        fault, at = self._fault or (None, number)
        if number <= at:
            self.note([*astuple(Call(event, *place, _site(sys._getframe(1))))])
        if fault is None or number < at:
            return None
        is_full = fault.number == errno.ENOSPC and event in _ALLOCATES  # and stays so
        if number > at and not is_full:
            return None
        half = None if fault.number in (errno.EINTR, signal.SIGINT) else begin()
        if fault.number == 0:
            return half
        if not fault.is_signal:
            raise OSError(
                fault.number, os.strerror(fault.number), *([] if isinstance(file, int) else [os.fspath(file)])
            )
        os.kill(os.getpid(), fault.number)
        time.sleep(_HEARD_S)
        return None

    def place_of(self, file: Any) -> tuple[str, str] | None:
        """Name and place of a file by its path or descriptor; ``None`` where it is not watched."""
        if isinstance(file, int):
            try:
                file = str(Path(f"/proc/self/fd/{file}").readlink()).removesuffix(" (deleted)")
            except OSError:
                return None
            file = file if file.startswith("/") else None  # a pipe, or a file in memory
        if not isinstance(file, str | bytes | os.PathLike):
            return None
        path = os.path.normpath(Path(os.fsdecode(file)).absolute())
        for folder in (self._temporary, self._work):
            if path == folder or path.startswith(f"{folder}/"):
                name = path[len(folder) + 1 :] or "."
                is_input = folder == self._work and name in self._inputs
                place = "input" if is_input else "output" if folder == self._work else "temporary"
                return _SERIAL.sub(".washboard-#", name), place
        return None

    def wrote(self, descriptor: int, size: int) -> None:
        """Note how much was written to a file."""
        number = os.fstat(descriptor).st_ino
        self._written[number] += size
        self._flushed.discard(number)

    def check_flushed(self, path: Path) -> None:
        """Note files below a path that have bytes which were not seen, or not flushed."""
        if self.place_of(path) is None or not path.exists():
            return
        for each in [path, *path.rglob("*")]:
            status = each.stat()
            if stat.S_ISREG(status.st_mode) and status.st_size:
                if self._written[status.st_ino] < status.st_size:
                    self.note({"wrong": f"{each.name}: bytes were written past the watch"})
                if status.st_ino not in self._flushed:
                    self.note({"wrong": f"{each.name}: is renamed before it is flushed"})

    def note(self, line: object) -> None:
        """Write a line."""
        self._write(self._pipe, f"{json.dumps(line)}\n".encode())


class WatchedFile(io.FileIO):
    """A file whose reading and writing is watched."""

    watch: FaultyCalls

    def write(self, data: Any, /) -> int:
        """Write, or fail halfway."""
        view = memoryview(data).cast("B")
        begin = partial(super().write, view[: len(view) // 2])
        written = self.watch.meet("write", self.fileno(), begin) or super().write(data)
        self.watch.wrote(self.fileno(), written)
        return written

    def read(self, size: int | None = -1, /) -> bytes:
        """Read, or fail."""
        self.watch.meet("read", self.fileno())
        return super().read(-1 if size is None else size) or b""

    def readinto(self, buffer: Any, /) -> int:
        """Read, or fail."""
        self.watch.meet("read", self.fileno())
        return super().readinto(buffer) or 0

    def readall(self) -> bytes:
        """Read, or fail."""
        self.watch.meet("read", self.fileno())
        return super().readall()
