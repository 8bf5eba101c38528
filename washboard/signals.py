"""Ctrl-C, and the signals by which others end a process: one line, an exit code, nothing half done, at any moment.

Python raises ``KeyboardInterrupt`` between two instructions of the main thread: in an import, in a callback that
swallows or wraps it, and not at all while that thread is in native code. So the signal is heard by a thread that does
nothing else, and the process ends there and then; files are safe because each appears by one renaming.
"""

import os
import select
import signal
import sys
from _thread import start_new_thread
from types import FrameType

_LINES = {
    signal.SIGINT: "interrupted",
    signal.SIGTERM: "ended by SIGTERM",
    signal.SIGHUP: "ended by SIGHUP, as the terminal was closed",
}
_PATIENCE_S = 1.0


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
                _end(number)


def _end(number: int) -> None:
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
