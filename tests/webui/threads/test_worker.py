import threading
from concurrent.futures import Future

from waiting import WAIT_S

from specs.progress import Progress
from webui.threads.threads import Worker


def fail(error: Exception) -> None:
    raise AssertionError from error


def test_work_is_done_and_told() -> None:
    told: list[tuple[str, float]] = []
    results: list[int] = []
    worker: Worker[int] = Worker(lambda what, done: told.append((what, done)))

    def work(progress: Progress) -> int:
        progress("half", 0.5)
        return 7

    worker.start(work, results.append, fail).result(WAIT_S)
    assert results == [7]
    assert ("half", 0.5) in told


def test_the_newest_work_replaces_what_is_under_way() -> None:
    begun, go = threading.Event(), threading.Event()
    results: list[str] = []
    worker: Worker[str] = Worker(lambda _what, _done: None)

    def slow(progress: Progress) -> str:
        begun.set()
        go.wait(WAIT_S)
        progress("still here", 0.5)
        return "old"

    first = worker.start(slow, results.append, fail)
    assert begun.wait(WAIT_S)
    middle = worker.start(lambda _progress: "middle", results.append, fail)
    last = worker.start(lambda _progress: "new", results.append, fail)
    go.set()
    for future in (first, middle, last):
        future.result(WAIT_S)
    assert results == ["new"]


def test_cancelled_work_tells_nothing_even_if_it_fails() -> None:
    begun, go = threading.Event(), threading.Event()
    ends: list[object] = []
    worker: Worker[str] = Worker(lambda _what, _done: None)

    def slow(_progress: Progress) -> str:
        begun.set()
        go.wait(WAIT_S)
        raise ValueError

    future = worker.start(slow, ends.append, ends.append)
    assert begun.wait(WAIT_S)
    worker.cancel()
    go.set()
    future.result(WAIT_S)
    assert ends == []


def test_a_failure_is_told_and_the_next_work_is_done() -> None:
    failures: list[Exception] = []
    results: list[float] = []
    worker: Worker[float] = Worker(lambda _what, _done: None)
    worker.start(lambda _progress: 1 / 0, results.append, failures.append).result(WAIT_S)
    worker.start(lambda _progress: 2.0, results.append, failures.append).result(WAIT_S)
    assert [type(error) for error in failures] == [ZeroDivisionError]
    assert results == [2.0]


def test_a_closed_worker_begins_nothing() -> None:
    results: list[int] = []
    worker: Worker[int] = Worker(lambda _what, _done: None)
    worker.close()
    future: Future[None] = worker.start(lambda _progress: 1, results.append, fail)
    assert future.cancelled()
    assert results == []


def test_a_plan_does_not_keep_the_process_alive() -> None:
    release = threading.Event()
    worker: Worker[bool] = Worker(lambda _what, _done: None)
    future = worker.start(lambda _progress: release.wait(WAIT_S), lambda _done: None, fail)
    living = [thread for thread in threading.enumerate() if thread.name == "washboard"]
    assert living
    assert all(thread.daemon for thread in living)
    release.set()
    future.result(WAIT_S)
