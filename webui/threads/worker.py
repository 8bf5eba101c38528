"""Work in the background with progress; the newest request wins."""

import threading
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
