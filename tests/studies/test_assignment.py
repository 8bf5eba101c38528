"""Jobs of a board stay with one worker while all have boards of their own, and are shared when there are fewer."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from study_work import cheap_jobs

from studies.job import Input, Job
from studies.runner import Assignment, Queue, assign


def queue(board: str, count: int) -> Queue:
    def jobs() -> Iterator[Job]:
        for job in cheap_jobs(Path("/"), count):
            yield replace(job, board=Input(board, f"/{board}.tri", board))

    return jobs


def nothing(_job: Job) -> bool:
    return False


def by_turns(assignment: Assignment, workers: str) -> dict[str, list[str]]:
    """Boards that each worker was given, in order, when all take as long for a job."""
    given: dict[str, list[str]] = {worker: [] for worker in workers}
    while assignment.left:
        for worker in workers:
            job = assignment.next_job(worker)
            if job is not None:
                given[worker].append(job.board.name)
    return given


def assigned(counts: dict[str, int], done: Callable[[Job], bool] = nothing) -> Assignment:
    return assign([queue(board, count) for board, count in counts.items()], done)


def test_each_board_is_prepared_by_one_worker() -> None:
    given = by_turns(assigned({"a": 6, "b": 6, "c": 6, "d": 6}), "12")
    assert given == {"1": ["a"] * 6 + ["c"] * 6, "2": ["b"] * 6 + ["d"] * 6}


def test_a_board_with_many_jobs_is_shared_in_time() -> None:
    given = by_turns(assigned({"small": 2, "large": 30}), "12")
    assert given == {"1": ["large"] * 16, "2": ["small"] * 2 + ["large"] * 14}


def test_one_board_keeps_all_workers_busy() -> None:
    given = by_turns(assigned({"a": 9}), "123")
    assert given == {worker: ["a"] * 3 for worker in "123"}


def test_what_is_done_and_what_is_equal_is_not_given() -> None:
    first = next(queue("a", 1)())
    assignment = assign([queue("a", 3), queue("a", 5), queue("b", 1)], lambda job: job == first)
    assert (assignment.total, assignment.left) == (6, 5)
    jobs = [job for job in iter(lambda: assignment.next_job("1"), None) if job is not None]
    assert len({job.key for job in jobs}) == len(jobs) == 5
    assert first not in jobs


def test_boards_of_lost_workers_are_left_to_others() -> None:
    assignment = assigned({"a": 4, "b": 4})
    assert [assignment.next_job(worker).board.name for worker in "12"] == ["a", "b"]  # type: ignore[union-attr]
    assignment.forget({"2"})
    given = by_turns(assignment, "23")
    assert given == {"2": ["b"] * 3, "3": ["a"] * 3}


def test_no_job_is_made_before_it_is_given() -> None:
    made = 0

    def jobs() -> Iterator[Job]:
        nonlocal made
        made = 0
        for job in cheap_jobs(Path("/"), 100):
            made += 1
            yield job

    assignment = assign([jobs], nothing)
    for count in range(1, 10):
        assignment.next_job("1")
        assert made == count
