"""Jobs that take no time, for the runner of studies: importable by its workers, and their number is on record."""

import os
import time
from collections.abc import Iterator
from pathlib import Path

from studies.job import Input, Job, JobResult


def cheap_jobs(folder: Path, count: int) -> Iterator[Job]:
    """Jobs that differ in a value; their board's file names a folder for the record of what was computed."""
    board, other = Input("b", str(folder / "b.tri"), "b" * 64), Input("r", "/r.yaml", "r" * 64)
    for value in range(count):
        yield Job(board, other, other, None, ((("limits", "blend_mm"), value),), "fast")


def value_of(job: Job) -> float:
    ((_, value),) = job.edits
    return float(value)


def work(job: Job) -> JobResult:
    """Note the process and the job, and give a result that depends on the job alone."""
    record = Path(job.board.file).parent / "computed.txt"
    with record.open("a") as file:
        file.write(f"{os.getpid()} {job.key}\n")
    value = value_of(job)
    return JobResult(job.key, seconds=10.0 + value, litres=0.5, verdict="clean", components={"U1": "clean"})


def broken_work(job: Job) -> JobResult:
    """Fail by a defect for every third job."""
    if value_of(job) % 3 == 1:
        raise KeyError("board")
    return work(job)


def slow_work(job: Job) -> JobResult:
    """The same a little later: there is time to end the process in which it is done."""
    time.sleep(0.05)
    return work(job)


def computed(folder: Path) -> list[tuple[int, str]]:
    """What was computed: process and key."""
    lines = (folder / "computed.txt").read_text().splitlines()
    return [(int(words[0]), words[1]) for words in map(str.split, lines)]
