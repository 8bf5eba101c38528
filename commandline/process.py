"""Signals that end the process, whose the packages are, and memory: settled before anything else is imported.

Python raises ``KeyboardInterrupt`` between two instructions of the main thread: in an import, in a callback that
swallows or wraps it, and not at all while that thread is in native code. So a signal is heard by a thread that does
nothing else, and the process ends there and then; files are safe because each appears by one renaming. Other
distributions, and folders, may bear the names of our packages: they are looked for before one is imported.
"""

import os
import select
import signal
import sys
from _thread import start_new_thread
from contextlib import suppress
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import FrameType

_LINES = {
    signal.SIGINT: "interrupted",
    signal.SIGTERM: "ended by SIGTERM",
    signal.SIGHUP: "ended by SIGHUP, as the terminal was closed",
}
_PATIENCE_S = 1.0

PACKAGES = (
    "specs", "geometry", "boards", "programs", "recipes", "cleaning", "robotcell", "rulesengine", "reports", "studies",
    "washboard", "webui", "commandline",
)  # fmt: skip
MARKER = b'DISTRIBUTION = "washboard"'
"""A line in the ``__init__`` of each of them."""
_ADVICE = "Install washboard in an environment of its own, with `pipx install` or `uv tool install`."

_MMAP_THRESHOLD = -3
"""Name of a setting of the memory, in malloc.h."""
_LARGE = 2 << 20
"""Bytes from which on memory that is freed goes back to the system at once."""
_LEAST_MEMORY = 1_000_000_000
"""Bytes of addresses with which a command has room for the libraries and a board."""


def return_memory() -> None:
    """Give large arrays back when they are freed: glibc learns to keep those of up to 32 MB, and the holes among them.

    Other C libraries have no such setting, and stay as they are.
    """
    import ctypes

    with suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).mallopt(_MMAP_THRESHOLD, _LARGE)


def watch() -> None:
    """Listen for the signals that are not ignored; called once, in the main thread."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    heard = [number for number in _LINES if signal.getsignal(number) is not signal.SIG_IGN]  # nohup, or a job of sh
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    start_new_thread(_wait, (reader,))
    for number in heard:
        signal.signal(number, _do_nothing)


def _do_nothing(_number: int, _frame: FrameType | None) -> None:
    """What the main thread does about a signal: the watching thread has it from the wake-up file."""


def _wait(reader: int) -> None:
    while True:
        for number in os.read(reader, 64):
            if number in _LINES:
                _end_by(number)


def _end_by(number: int) -> None:
    """End the process, unless the command stops by itself at this signal."""
    ending = sys.modules.get("specs.ending")
    stop, abandon = (getattr(ending, name, None) for name in ("stops_itself", "abandon"))
    if stop is not None and stop(number):
        return
    try:
        result = "nothing was written" if abandon is None else abandon()
        if result:
            _write_line(f"error: {_LINES[signal.Signals(number)]}; {result}\n")
    finally:
        os._exit(128 + number)


def _write_line(line: str) -> None:
    """Write a line to the error stream, if that takes it."""
    try:
        if select.select([], [2], [], _PATIENCE_S)[1]:
            os.write(2, line.encode("ascii", "backslashreplace"))
    except OSError:  # it is closed
        pass


def find_shortage() -> str | None:
    """Look for a limit on memory below what the libraries load with: some of them end there, or never do.

    Returns:
        One sentence: the limit, and what to do; ``None`` where there is room.
    """
    import resource

    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY or limit >= _LEAST_MEMORY:
        return None
    needed = f"washboard needs {_LEAST_MEMORY / 1e6:,.0f} MB at least"
    cure = f"raise the limit (`ulimit -v {_LEAST_MEMORY // 1000}` or more)"
    return f"the memory of this process is limited to {limit / 1e6:,.0f} MB, and {needed}: {cure}."


def find_foreign() -> str | None:
    """Look for a package of ours that is somebody else's, without importing any.

    Returns:
        One sentence: which, where, and what to do; ``None`` where all are ours.
    """
    home = Path(__file__).parents[1]
    for name in PACKAGES:
        spec = PathFinder.find_spec(name)
        origin = None if spec is None else spec.origin
        if spec is None or origin is None:
            there = "is missing" if spec is None else "has no __init__.py"
            return f"the package {name!r} of washboard {there} in {home}: something else has removed it. {_ADVICE}"
        folder = Path(origin).parent
        if folder.parent.resolve() != home.resolve():
            return (
                f"the package {name!r} in {folder} is not washboard's and would be read in place of that in {home}. "
                f"Start washboard in another folder and without PYTHONPATH. {_ADVICE}"
            )
        if not _is_ours(spec, origin):
            from importlib.metadata import packages_distributions

            others = sorted(set(packages_distributions().get(name, ())) - {"washboard"})
            owner = f"the distribution {', '.join(others)}" if others else "something else"
            there = f"the package {name!r} in {folder} is not washboard's"
            return f"{there}: {owner} has put its own in that place. {_ADVICE}"
    return None


def _is_ours(spec: ModuleSpec, origin: str) -> bool:
    read = getattr(spec.loader, "get_data", None)  # a folder's loader has it, and that of an archive
    try:
        return read is not None and MARKER in read(origin)
    except OSError:
        return False
