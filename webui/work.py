"""Planning beside the page: the newest request wins, and long work says how far it is."""

import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic, TypeVar

from geometry.progress import Progress

T = TypeVar("T")


class CancelledError(Exception):
    """The work is no longer wanted."""


class Worker(Generic[T]):
    """Does one piece of work at a time, in a thread of its own.

    A new piece replaces the one under way: that is told to stop the next time it says how far it is.
    """

    def __init__(self, tell: Progress) -> None:
        """Remember whom to tell how far the work is."""
        self._tell = tell
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="washboard")
        self._lock = threading.Lock()
        self._wanted = 0

    def start(
        self, work: Callable[[Progress], T], done: Callable[[T], None], failed: Callable[[Exception], None]
    ) -> "Future[None]":
        """Begin a piece of work once the last one has stopped; its end is told unless another one came."""
        with self._lock:
            self._wanted += 1
            ticket = self._wanted
        return self._pool.submit(self._do, ticket, work, done, failed)

    def cancel(self) -> None:
        """Give up what is under way."""
        with self._lock:
            self._wanted += 1

    def close(self) -> None:
        """Give up what is under way and end the thread."""
        self.cancel()
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _do(
        self,
        ticket: int,
        work: Callable[[Progress], T],
        done: Callable[[T], None],
        failed: Callable[[Exception], None],
    ) -> None:
        def tell(what: str, share: float) -> None:
            if ticket != self._wanted:
                raise CancelledError
            self._tell(what, share)

        try:
            tell("waiting", 0.0)
            result = work(tell)
            tell("done", 1.0)
            done(result)
        except CancelledError:
            return
        except Exception as error:
            failed(error)
