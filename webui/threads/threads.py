"""Threads of the page: background work of which the newest request wins, limited calls, the clock of a playback."""

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Generic, TypeVar

from specs.progress import Progress

T = TypeVar("T")


class CancelledError(Exception):
    """The work was cancelled."""


class Worker(Generic[T]):
    """Runs one piece of work at a time, in a thread of its own.

    A new piece replaces the one under way, which is cancelled at its next progress report. The threads do not keep the
    process alive: a server that is stopped does not wait for a plan.
    """

    def __init__(self, progress: Progress) -> None:
        """Build a worker that reports to ``progress``."""
        self._progress = progress
        self._lock = threading.Lock()
        self._last: threading.Thread | None = None
        self._ticket = 0
        self._closed = False

    def start(
        self, work: Callable[[Progress], T], done: Callable[[T], None], failed: Callable[[Exception], None]
    ) -> "Future[None]":
        """Start a piece of work once the last one has stopped; its end is reported unless another one was started.

        Returns:
            Done after the last report of this piece; cancelled if the worker was closed before.
        """
        future: Future[None] = Future()
        with self._lock:
            if self._closed:
                future.cancel()
                return future
            self._ticket += 1
            ticket, before = self._ticket, self._last

            def live() -> None:
                if before is not None:
                    before.join()
                self._do(ticket, work, done, failed)
                future.set_result(None)

            self._last = threading.Thread(target=live, name="washboard", daemon=True)
            self._last.start()
        return future

    def cancel(self) -> None:
        """Cancel what is under way."""
        with self._lock:
            self._ticket += 1

    def close(self) -> None:
        """Cancel what is under way; nothing more is started."""
        with self._lock:
            self._ticket += 1
            self._closed = True

    def _do(
        self,
        ticket: int,
        work: Callable[[Progress], T],
        done: Callable[[T], None],
        failed: Callable[[Exception], None],
    ) -> None:
        def progress(what: str, share: float) -> None:
            if ticket != self._ticket:
                raise CancelledError
            self._progress(what, share)

        try:
            progress("waiting", 0.0)
            result = work(progress)
            progress("done", 1.0)
            done(result)
        except CancelledError:
            return
        except Exception as error:
            if ticket == self._ticket:
                failed(error)


def start_timer(after_s: float, do: Callable[..., object], *arguments: object) -> threading.Timer:
    """Call a function after a time, in a thread that does not keep the process alive."""
    timer = threading.Timer(after_s, do, arguments)
    timer.daemon = True
    timer.start()
    return timer


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
        self._timer = start_timer(max(self._free_s - time.monotonic(), 0.0), self._go)

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


_FRAME_S = 1 / 22


class Player:
    """Clock of a program; its thread exists only while it runs."""

    def __init__(self, draw: Callable[[float], None]) -> None:
        """Start at the beginning of an empty program.

        Args:
            draw: Is called with each time to show, s; one call at a time.
        """
        self._draw = draw
        self._lock = threading.RLock()
        self._drawing = threading.Lock()
        self._stop = threading.Event()
        self._end_s = 0.0
        self._now_s = 0.0
        self._playing = False
        self.rate = 1.0
        """Seconds of the program in a second."""

    @property
    def now_s(self) -> float:
        """The moment that is shown."""
        return self._now_s

    @property
    def playing(self) -> bool:
        """Whether the time runs."""
        return self._playing

    def load(self, end_s: float) -> None:
        """Stop, and take a program of another length; the time stays if it is still inside."""
        with self._lock:
            self.pause()
            self._end_s = end_s
            self._now_s = self._now_s if self._now_s <= end_s else 0.0
        self._show()

    def play(self) -> None:
        """Let the time run; from the beginning if it is at the end."""
        with self._lock:
            if self._playing or self._end_s <= 0:
                return
            if self._now_s >= self._end_s:
                self._now_s = 0.0
            self._playing = True
            self._stop = threading.Event()
            threading.Thread(target=self._run, args=(self._stop,), name="washboard-player", daemon=True).start()

    def pause(self) -> None:
        """Stop the time where it is; the thread ends."""
        with self._lock:
            self._playing = False
            self._stop.set()

    def seek(self, time_s: float) -> None:
        """Go to a moment, inside the program; whether the time runs stays as it is."""
        with self._lock:
            self._now_s = min(max(time_s, 0.0), self._end_s)
        self._show()

    def _run(self, stop: threading.Event) -> None:
        last = time.monotonic()
        while not stop.wait(_FRAME_S):
            now = time.monotonic()
            with self._lock:
                if stop.is_set():
                    return
                self._now_s = min(self._now_s + (now - last) * self.rate, self._end_s)
                if self._now_s >= self._end_s:
                    self.pause()
            last = now
            self._show()

    def _show(self) -> None:
        with self._drawing:
            self._draw(self._now_s)
