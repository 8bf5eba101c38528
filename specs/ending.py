"""The end of the process at any moment: what is undone before it, and what was written until then.

A signal ends the process from a thread of its own (``commandline.process``) and not by an exception: whatever has to be
removed or restored in that case is registered here while it is there.
"""

import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TypeAlias

from specs.errors import printable

Action: TypeAlias = Callable[[], None]

lock = threading.RLock()
"""Held where a file appears, is renamed or is removed, and from ``abandon`` on for ever."""
_PATIENCE_S = 5.0
_STOPPING_S = 10.0
_MOST_NAMED = 3
_actions: dict[int, Action] = {}
_written: list[str] = []
_reports: list[str] = []
_reached: list[Callable[[], str]] = []


@contextmanager
def undone_at_end(action: Action) -> Generator[None]:
    """Run an action if the process ends before the block does; the block's own end does not run it."""
    with lock:
        key = max(_actions, default=0) + 1
        _actions[key] = action
    try:
        yield
    finally:
        with lock:
            del _actions[key]


def begin() -> None:
    """Forget what an earlier command in this process wrote and reported."""
    _written.clear()
    _reports.clear()
    _reached.clear()


def note_written(path: Path) -> None:
    """Note a file or folder that was written as a whole."""
    name = printable(str(path))
    if name not in _written:
        _written.append(name)


def note_reached(describe: Callable[[], str] | None) -> None:
    """Set what describes how far long work has come: an interrupt adds it to its line; ``None`` when that is done."""
    _reached[:] = [] if describe is None else [describe]


def note_reported(line: str) -> None:
    """Note that the reason for the end has been printed: an interrupt after it adds no line."""
    _reports.append(line)


def describe_written() -> str:
    """Name what was written and reached until now, as the end of a sentence."""
    reached = "".join(f"; {printable(describe())}" for describe in _reached)
    if not _written:
        return f"nothing was written{reached}"
    named, more = _written[:_MOST_NAMED], len(_written) - _MOST_NAMED
    rest = f" and {more} more" if more > 0 else ""
    return f"written before, and complete: {', '.join(named)}{rest}{reached}"


def abandon() -> str:
    """Undo what is unfinished, last first; from here on nothing is written, and threads that try to are kept waiting.

    Returns:
        What was written; empty if the reason for the end has been printed already.
    """
    lock.acquire(timeout=_PATIENCE_S)  # longer only in a file system that does not answer
    for action in reversed([*_actions.values()]):
        with suppress(Exception):
            action()
    return "" if _reports else describe_written()


class Stop:
    """A command that ends in order at a signal, such as a server."""

    def __init__(self) -> None:
        """Begin to wait."""
        self._event = threading.Event()
        self._since = 0.0
        self.signal: int | None = None

    def wait(self) -> int | None:
        """Wait for a signal, and give its number; ``None`` after a ``KeyboardInterrupt``."""
        with suppress(KeyboardInterrupt):
            self._event.wait()
        return self.signal

    def take(self, number: int) -> bool:
        """Take a signal; more of them are ignored for a while, as the command is stopping."""
        if self.signal is None:
            self.signal, self._since = number, time.monotonic()
            self._event.set()
        return time.monotonic() - self._since < _STOPPING_S


_stops: list[Stop] = []


@contextmanager
def stopped_by_signal() -> Generator[Stop]:
    """Have signals end a block in order rather than the process."""
    stop = Stop()
    _stops.append(stop)
    try:
        yield stop
    finally:
        _stops.remove(stop)


def stops_itself(number: int) -> bool:
    """Hand a signal to the command, if that ends in order by itself."""
    return any(stop.take(number) for stop in _stops)
