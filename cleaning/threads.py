"""Threads of an analysis: how many it may take, and work that is divided among them."""

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from itertools import islice
from typing import TypeVar

_T = TypeVar("_T")
_R = TypeVar("_R")

_count: ContextVar[int] = ContextVar("threads of an analysis", default=2)
"""More find little to do: what is between the divided work is done by the caller alone."""


def thread_count() -> int:
    """How many threads an analysis in this context takes."""
    return _count.get()


@contextmanager
def limit_threads(most: int) -> Generator[None]:
    """Let analyses in this context take at most so many threads, as where other processes have the other cores."""
    before = _count.set(min(most, _count.get()))
    try:
        yield
    finally:
        _count.reset(before)


def map_in_threads(work: Callable[[_T], _R], items: Iterable[_T]) -> Iterator[_R]:
    """Give the results of independent work in the order of the items, whatever the number of threads.

    No item is begun before the result that lies ``thread_count`` items ahead of it was taken. With one thread the
    caller does the work.
    """
    count, waiting = thread_count(), iter(items)
    if count == 1:
        yield from map(work, waiting)
        return
    with ThreadPoolExecutor(count) as threads:
        begun = deque(threads.submit(work, item) for item in islice(waiting, count))
        while begun:
            result = begun.popleft().result()
            begun.extend(threads.submit(work, item) for item in islice(waiting, 1))
            yield result
