"""Which worker computes which jobs: those that share a board stay together as long as all workers have some."""

from collections import Counter
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from studies.job import Job

Queue: TypeAlias = Callable[[], Iterator[Job]]
"""Gives jobs that share what a worker prepares, in order, as often as it is called."""


@dataclass(frozen=True, slots=True)
class _OpenQueue:
    """A queue from which jobs are taken."""

    jobs: Iterator[Job]
    keys: set[str]
    """Of the jobs that are left in it."""


class Assignment:
    """The queue of each worker: what its jobs share is prepared by as few workers as keep all of them busy."""

    def __init__(self, total: int, queues: Sequence[_OpenQueue]) -> None:
        """Begin with queues that no worker has; ``assign`` makes them."""
        self.total = total
        """Distinct jobs, those that were done before included."""
        self._queues = queues
        self._of: dict[str, _OpenQueue] = {}

    @property
    def left(self) -> int:
        """Jobs that no worker was given yet."""
        return sum(len(each.keys) for each in self._queues)

    def next_job(self, worker: str) -> Job | None:
        """Give the next job of a worker's queue; after that, of the longest one that no worker has.

        Where each has some, it is the one with the most jobs left for each of its workers.
        """
        queue = self._of.pop(worker, None)
        if queue is None or not queue.keys:
            shared = Counter(id(each) for each in self._of.values())

            def need(each: _OpenQueue) -> tuple[bool, float]:
                return bool(each.keys) and not shared[id(each)], len(each.keys) / (1 + shared[id(each)])

            queue = max(self._queues, key=need)
        if not queue.keys:
            return None
        self._of[worker] = queue
        return next(queue.jobs)

    def forget(self, present: Container[str]) -> None:
        """Leave the queues of workers that are gone to others."""
        self._of = {worker: queue for worker, queue in self._of.items() if worker in present}


def assign(queues: Iterable[Queue], done: Callable[[Job], bool]) -> Assignment:
    """Begin with the jobs that are not done, equal ones once."""
    known: set[str] = set()
    opened: list[_OpenQueue] = []
    for jobs in queues:
        keys: set[str] = set()
        for job in jobs():
            key = job.key
            if key not in known:
                known.add(key)
                if not done(job):
                    keys.add(key)
        opened.append(_OpenQueue(_take(jobs(), keys), keys))
    return Assignment(len(known), opened)


def _take(jobs: Iterator[Job], keys: set[str]) -> Iterator[Job]:
    """Give the jobs with some keys, each once."""
    for job in jobs:
        key = job.key
        if key in keys:
            keys.remove(key)
            yield job
