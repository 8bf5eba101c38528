"""A study on two workers against the same study on one, and against one process with all its threads.

Run: ``OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/study.py [--workers 2] [--boards tiny ...]``

Four boards by five recipes by three accelerations, three times: in one process, job after job, with all the threads
that an analysis takes when it is alone; by one worker with one thread; by several with one thread each. Workers count
with their start: it is what ``washboard study`` takes. Prints how much sooner several workers are done than one
worker, which is what more cores can give, and than the one process, which uses more than one core by itself; what the
workers spend between jobs while all have any (overhead); the processor time of the jobs side by side against that of
the same jobs one at a time, which is 1 if caches and memory serve several as well as one; and whether all kept the
same bytes. Other work on the machine falsifies all but the last: the load is printed beside.
"""

import argparse
import os
import tempfile
import time
from collections import defaultdict
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

from specs.progress import no_progress
from studies.job import Job, JobResult
from studies.planned_study import PlannedStudy, plan_study
from studies.run_job import run_job
from studies.runner import local_cluster, run_jobs
from studies.store import open_store

BOARDS = ("tiny", "two-sided", "sensor-hub", "radio-stick")
RECIPES = ("smt-aqueous", "low-standoff", "rinse-only", "dry-only", "quick.yaml")
QUICK = "recipe: quick\nextends: smt-aqueous\nfunctions: {clean: {max_speed_mm_s: 150}}\n"
VALUES = {"path": "limits.acceleration_mm_s2", "values": [500, 1000, 2000]}
LEAST_RATIO, MOST_OVERHEAD = 1.7, 0.05
THREADS = 2
"""Of an analysis that is alone."""


def main() -> int:
    """Measure; 0 if both bounds are kept."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--boards", nargs="+", default=BOARDS)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        planned = study(folder, given.boards)
        run_job(next(planned.jobs()))  # compiles what is compiled at its first use
        print(f"{len(list(planned.jobs()))} jobs, load {os.getloadavg()[0]:.1f}", flush=True)
        process_s = in_this_process(planned, folder / "process")
        one_s, one_cpu_s = by_workers(planned, folder / "one", 1)
        many_s, many_cpu_s = by_workers(planned, folder / "many", given.workers)
        overhead = overhead_of(folder / "many.txt")
        same = contents(folder / "process") == contents(folder / "one") == contents(folder / "many")
        ratio = one_s / many_s
        print(f"{ratio:.2f} times as fast as one worker (at least {LEAST_RATIO})")
        print(f"{process_s / many_s:.2f} times as fast as one process with {THREADS} threads")
        print(f"overhead {overhead:.1%} (at most {MOST_OVERHEAD:.0%})")
        print(f"jobs side by side took {many_cpu_s / one_cpu_s:.2f} times the processor time of one at a time")
        print(f"the same bytes: {'yes' if same else 'NO'}")
        return 0 if same and ratio >= LEAST_RATIO and overhead <= MOST_OVERHEAD else 1


def study(folder: Path, boards: Sequence[str]) -> PlannedStudy:
    """Plan the study of this benchmark."""
    (folder / "quick.yaml").write_text(QUICK)
    lines = [
        "study: benchmark",
        f"boards: [{', '.join(boards)}]",
        f"recipes: [{', '.join(RECIPES)}]",
        f"variables: [{{path: {VALUES['path']}, values: {VALUES['values']}}}]",
    ]
    (folder / "study.yaml").write_text("\n".join(lines))
    return plan_study(folder / "study.yaml", no_progress)


def in_this_process(planned: PlannedStudy, folder: Path) -> float:
    """Run all jobs here, one after the other; returns seconds."""
    begun, cpu = time.perf_counter(), time.process_time()
    with open_store(folder) as store:
        for job in planned.jobs():
            store.keep(run_job(job, THREADS))
    seconds = time.perf_counter() - begun
    cores = (time.process_time() - cpu) / seconds
    print(f"one process: {seconds:.1f} s, {cores:.2f} cores, load {os.getloadavg()[0]:.1f}", flush=True)
    return seconds


def by_workers(planned: PlannedStudy, folder: Path, workers: int) -> tuple[float, float]:
    """Run all jobs by workers with one thread each; returns seconds, and processor seconds in jobs."""
    record = folder.with_suffix(".txt")
    begun = time.perf_counter()
    with open_store(folder) as store:
        run_jobs(planned.queues(), store, local_cluster(workers), no_progress, partial(timed, record))
    seconds = time.perf_counter() - begun
    busy_s = sum(spent for each in spans(record).values() for _, _, spent in each)
    print(
        f"workers {workers}: {seconds:.1f} s, {busy_s:.1f} s of processor time in jobs, load {os.getloadavg()[0]:.1f}",
        flush=True,
    )
    return seconds, busy_s


def timed(record: Path, job: Job) -> JobResult:
    """Note when a job began and ended in which process, and its processor time."""
    begun, cpu = time.time(), time.process_time()
    result = run_job(job)
    with record.open("a") as file:
        file.write(f"{os.getpid()} {begun} {time.time()} {time.process_time() - cpu}\n")
    return result


def spans(record: Path) -> dict[str, list[tuple[float, float, float]]]:
    """Beginning, end and processor time of the jobs of each process."""
    found: dict[str, list[tuple[float, float, float]]] = defaultdict(list)
    for line in record.read_text().splitlines():
        process, *times = line.split()
        begun, ended, spent = map(float, times)
        found[process].append((begun, ended, spent))
    return found


def overhead_of(record: Path) -> float:
    """Share of the workers' time outside of jobs, from when all have begun until the first has none left."""
    found = spans(record)
    begin = max(min(each)[0] for each in found.values())
    end = min(max(ended for _, ended, _ in each) for each in found.values())
    busy = sum(max(0.0, min(b, end) - max(a, begin)) for each in found.values() for a, b, _ in each)
    return 1.0 - busy / (len(found) * (end - begin))


def contents(folder: Path) -> dict[str, bytes]:
    """All results by name."""
    return {path.name: path.read_bytes() for path in folder.rglob("*.json")}


if __name__ == "__main__":
    with suppress(KeyboardInterrupt):
        raise SystemExit(main())
