"""Calls limited to a few a second, always with the newest argument."""

import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Throttle(Generic[T]):
    """Calls a function at a limited rate; of requests in a row the last one is never lost."""

    def __init__(self, do: Callable[[T], None], every_s: float) -> None:
        """Set the function and the rate.

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

    def request(self, argument: T) -> None:
        """Call the function soon, in place of a pending call."""
        with self._lock:
            if self._closed:
                return
            self._waiting = [argument]
            if self._timer is None:
                self._start_timer()

    def clear(self) -> None:
        """Drop a pending call."""
        with self._lock:
            self._waiting = []

    def close(self) -> None:
        """Drop a pending call and all later ones."""
        with self._lock:
            self._closed, self._waiting = True, []
            if self._timer is not None:
                self._timer.cancel()

    def _start_timer(self) -> None:
        self._timer = threading.Timer(max(self._free_s - time.monotonic(), 0.0), self._go)
        self._timer.daemon = True
        self._timer.start()

    def _go(self) -> None:
        with self._lock:
            waiting, self._waiting = self._waiting, []
        try:
            for argument in waiting:
                self._do(argument)
        finally:
            with self._lock:
                self._timer, self._free_s = None, time.monotonic() + self._every_s
                if self._waiting:
                    self._start_timer()
