"""The newest of many requests, a few times a second."""

import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Paced(Generic[T]):
    """Hands on what is asked for, but not more often than so; of requests in a row the last one is never lost."""

    def __init__(self, do: Callable[[T], None], every_s: float) -> None:
        """Remember what to do.

        Args:
            do: Is called in a thread of its own, one call at a time.
            every_s: Time from the end of one call to the begin of the next, s.
        """
        self._do, self._every_s = do, every_s
        self._lock = threading.Lock()
        self._timer: threading.Timer | None = None
        self._waiting: list[T] = []
        self._free_s = 0.0
        self._closed = False

    def ask(self, what: T) -> None:
        """Have it done soon, in place of what still waits."""
        with self._lock:
            if self._closed:
                return
            self._waiting = [what]
            if self._timer is None:
                self._set_out()

    def forget(self) -> None:
        """Do nothing of what still waits."""
        with self._lock:
            self._waiting = []

    def close(self) -> None:
        """Do nothing more."""
        with self._lock:
            self._closed, self._waiting = True, []
            if self._timer is not None:
                self._timer.cancel()

    def _set_out(self) -> None:
        self._timer = threading.Timer(max(self._free_s - time.monotonic(), 0.0), self._go)
        self._timer.daemon = True
        self._timer.start()

    def _go(self) -> None:
        with self._lock:
            waiting, self._waiting = self._waiting, []
        try:
            for what in waiting:
                self._do(what)
        finally:
            with self._lock:
                self._timer, self._free_s = None, time.monotonic() + self._every_s
                if self._waiting:
                    self._set_out()
