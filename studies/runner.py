"""Runs jobs in the processes of a Dask cluster, keeps each result as it comes, and computes none twice.

Jobs are submitted a few at a time: however many there are, few are in memory. Those of one board go to one worker as
long as the others have boards of their own. A task's key is the hash of its job. A worker that ends takes its tasks
along, and the scheduler hands them to another one.
"""

import logging
import os
import time
import warnings
from collections import Counter
from collections.abc import Callable, Container, Generator, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, TypeAlias, cast

from specs import ending
from specs.progress import Progress
from specs.temporary import temporary_folder
from studies.errors import StudyError
from studies.fingerprint import program_version
from studies.job import Job, JobResult
from studies.store import ResultStore

if TYPE_CHECKING:
    from distributed import Client

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


Work: TypeAlias = Callable[[Job], JobResult]

_AHEAD = 2
"""Jobs for each thread of the cluster that are submitted: one is computed, and the next one waits where it is."""
_GONE = "the scheduler is gone. What is done is kept: start the study again when there is one."
_ANYONE = ""
"""In place of a worker while there is none: one may be about to start."""
NEEDED = "studies need `pip install washboard[study]`."
_CONNECT_S = 20.0
_KIND = "job"
"""What the keys of all tasks begin with: the scheduler keeps a record of each kind of task for ever."""
_LOGGED = 100
_SCRATCH = "temporary-directory"
_LOOPBACK = "127.0.0.1"
_GB = 1e9


@dataclass(slots=True)
class _Count:
    """How far a study has come."""

    total: int
    """Distinct jobs."""
    done: int
    """Of them; those that were kept before included."""
    shows_dashboard: bool = False
    dashboard: str = ""
    """Its address."""
    began: float = 0.0
    computed: int = 0

    def describe(self) -> str:
        """How far it is, and how long it will take."""
        text = f"{self.done:,} of {self.total:,} jobs" + (f", dashboard {self.dashboard}" if self.dashboard else "")
        if not self.computed:
            return text
        left_s = (time.monotonic() - self.began) / self.computed * (self.total - self.done)
        left = f"{left_s / 60:.0f} min" if left_s < 5400 else f"{left_s / 3600:.1f} h"
        return f"{text}, {f'{left_s:.0f} s' if left_s < 90 else left} left"


def run_jobs(
    queues: Iterable[Queue],
    store: ResultStore,
    cluster: "AbstractContextManager[Client]",
    progress: Progress,
    work: Work,
    *,
    dashboard: bool = False,
) -> int:
    """Compute all jobs whose results are not kept yet; returns how many that were.

    Args:
        queues: Jobs that share what a worker prepares, such as a board; equal ones may occur.
        store: Where results are kept.
        cluster: Entered where any job is left to compute.
        progress: Receives how far the study is.
        work: Computes one job, in a worker.
        dashboard: Whether the address of the cluster's dashboard goes with the progress.

    Raises:
        StudyError: a worker cannot do it, or jobs ended their workers again and again.
        OutputError: a result cannot be kept.
    """
    assignment = assign(queues, lambda job: store.find(job.key) is not None)
    count = _Count(assignment.total, assignment.total - assignment.left, dashboard)
    ending.note_reached(lambda: f"{count.done:,} of {count.total:,} jobs are kept, and the same command goes on")
    progress(count.describe(), count.done / max(count.total, 1))
    if assignment.left:
        with cluster as client:
            _compute(client, assignment, store, (count, progress), work)
    return count.computed


def _compute(
    client: "Client", assignment: Assignment, store: ResultStore, counted: tuple[_Count, Progress], work: Work
) -> None:
    """Compute jobs and keep their results.

    Raises:
        StudyError: a worker cannot do it, or jobs ended their workers again and again.
        OutputError: a result cannot be kept.
    """
    from distributed import KilledWorker

    count, progress = counted
    count.began = time.monotonic()
    lost: list[str] = []
    defects: list[Exception] = []
    with suppress(OSError):  # one that is gone is reported where jobs are given to it
        count.dashboard = client.dashboard_link or "" if count.shows_dashboard else ""
        waiting = "" if client.nthreads() else ", waiting for a worker: the scheduler has none yet"
        progress(count.describe() + waiting, count.done / count.total)
    for future in _completed(client, assignment, work):
        try:
            result = future.result()
        except KilledWorker:
            lost.append(future.key.removeprefix(f"{_KIND}-"))
            continue
        except CancelledError:
            raise StudyError(_GONE) from None
        except StudyError:
            raise
        except ModuleNotFoundError as error:  # a worker that began after the others were looked at
            raise StudyError(f"a worker does not have Washboard ({error}). Install it in its environment.") from None
        except Exception as error:  # a defect of ours: what does not meet it is computed all the same
            defects.append(error)
            continue
        finally:
            future.release()
        store.keep(result)
        count.done, count.computed = count.done + 1, count.computed + 1
        progress(count.describe(), count.done / count.total)
    if defects:
        raise defects[0]
    if lost:
        raise StudyError(
            f"{len(lost)} of {count.total} jobs ended their workers again and again, first {lost[0][:12]}: perhaps "
            "there is too little memory. All others are kept. Start the study again, with fewer workers."
        )


def _completed(client: "Client", assignment: Assignment, work: Work) -> Iterator[Any]:
    """Submit jobs a few at a time, and give their futures as they are done.

    Raises:
        StudyError: the scheduler is gone.
    """
    from distributed import as_completed

    done = as_completed(loop=client.loop)
    meant_for: dict[str, str] = {}

    def submit() -> None:
        try:
            threads = cast("dict[str, int]", client.nthreads()) or {_ANYONE: 1}
        except OSError:
            raise StudyError(_GONE) from None
        assignment.forget(threads)
        waiting = Counter(meant_for.values())
        # At the end none waits: the scheduler moves single jobs late or never to a worker that has nothing left.
        ahead = _AHEAD if assignment.left > _AHEAD * sum(threads.values()) else 1
        rooms = {worker: ahead * count - waiting[worker] for worker, count in threads.items()}
        for turn in range(max(rooms.values())):
            for worker in (worker for worker, room in rooms.items() if turn < room):
                job = assignment.next_job(worker)
                if job is None:
                    return
                key = f"{_KIND}-{job.key}"
                meant_for[key] = worker
                # Others may take it over: the scheduler moves jobs to workers that have none, and away from lost ones.
                at = None if worker == _ANYONE else [worker]
                done.add(client.submit(work, job, key=key, workers=at, allow_other_workers=at is not None))

    submit()
    for future in done:
        del meant_for[future.key]
        yield future
        submit()


@contextmanager
def local_cluster(workers: int, memory_gb: float = 0.0, *, dashboard: bool = False) -> "Generator[Client]":
    """Start processes on this machine, that listen on its loopback alone, and end them with the block.

    Args:
        workers: How many.
        memory_gb: Of each: near it a process waits, and beyond it is begun anew; 0 for no limit.
        dashboard: Whether the scheduler serves Dask's dashboard.

    Raises:
        StudyError: ``washboard[study]`` is missing, or for the dashboard bokeh; or the system lets no process begin.
    """
    distributed = _import()
    if dashboard and find_spec("bokeh") is None:
        raise StudyError("Dask's dashboard needs bokeh: `pip install bokeh`, or leave --dashboard out.")
    from dask import config

    served: dict[str, list[str]] = {"distributed.scheduler.http.routes": []}
    short = {
        **({} if dashboard else served),
        "distributed.worker.http.routes": [],
        "distributed.admin.log-length": _LOGGED,
        "distributed.admin.low-level-log-length": _LOGGED,
        # The scratch folder is this study's alone, and removed by it: its lock would wait for ever for a failing disk.
        "distributed.worker.use-file-locking": False,
    }  # nothing is served, and the history of tasks does not grow with them
    with temporary_folder() as scratch, _quiet(), _unwarned(), config.set(short | {_SCRATCH: str(scratch)}):
        try:
            cluster = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                host=_LOOPBACK,
                dashboard_address=f"{_LOOPBACK}:0" if dashboard else None,
                worker_dashboard_address=None,
                local_directory=str(scratch),
                memory_limit=int(memory_gb * _GB),
                silence_logs=logging.CRITICAL,
            )
        except RuntimeError as reason:  # of what the system refuses: files, memory, processes
            why = str(reason).rstrip(".")
            message = f"its workers cannot be started: {why}. Raise the limits of this process, or use fewer."
            raise StudyError(message) from None
        with cluster, distributed.Client(cluster) as client:
            yield client


@contextmanager
def existing_cluster(address: str) -> "Generator[Client]":
    """Use a cluster that is there.

    It may have no worker yet: a cluster that adapts begins some when there are jobs.

    Args:
        address: Of its scheduler, such as ``tcp://127.0.0.1:8786``.

    Raises:
        StudyError: ``washboard[study]`` is missing, nothing answers there, or a worker has another Washboard.
    """
    distributed = _import()
    with _quiet():
        try:
            client = distributed.Client(address, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, ValueError, TimeoutError):
            message = f"no scheduler answers at {address}. Start one with `dask scheduler`, and name its address."
            raise StudyError(message) from None
        with client:
            require_version(client)
            yield client


@contextmanager
def own_client(client: "Client") -> "Generator[Client]":
    """Use a client that is handed in, and leave it open.

    Raises:
        StudyError: it is asynchronous, or closed, or a worker has another Washboard.
    """
    if client.asynchronous or client.status != "running":
        state = "asynchronous" if client.asynchronous else client.status
        raise StudyError(f"the Dask client is {state}: hand in one that is open, made without `asynchronous=True`.")
    require_version(client)
    yield client


def require_version(client: "Client") -> None:
    """Refuse workers without this Washboard, its code and numerical libraries; those that come later refuse the jobs.

    Raises:
        StudyError: one is missing, or is another version.
    """
    mine = program_version()
    found = cast("dict[str, object]", client.run(program_version, on_error="return"))
    for worker, theirs in found.items():
        if theirs != mine:
            there = f"has Washboard {theirs}" if isinstance(theirs, str) else "does not have Washboard"
            raise StudyError(f"the worker {worker} {there}, and this is {mine}. Install that in its environment.")


def _import() -> Any:
    try:
        import distributed
    except ImportError:
        raise StudyError(NEEDED) from None
    if find_spec("pyarrow") is None:  # the table is written at the end: what is missing is reported at the beginning
        raise StudyError(NEEDED)
    return distributed


@contextmanager
def _quiet() -> Generator[None]:
    """Print nothing of what the libraries log and warn of: what matters is raised, or counted."""
    logging.disable(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(logging.NOTSET)


@contextmanager
def _unwarned() -> Generator[None]:
    """Keep the process that cleans up after this one from warning of what it cleans up, when a signal ends this one."""
    before = os.environ.get("PYTHONWARNINGS")
    os.environ["PYTHONWARNINGS"] = "ignore:resource_tracker"
    try:
        yield
    finally:
        del os.environ["PYTHONWARNINGS"]
        if before is not None:
            os.environ["PYTHONWARNINGS"] = before
