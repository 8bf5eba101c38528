"""A study on the processes of a local cluster against the same jobs in one process, one after the other.

Run: ``OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/study.py [--workers 2] [--boards tiny ...]``

Four boards by five recipes by three accelerations. Prints the ratio of the times, that of the workers with their start;
what the workers spend between jobs while both have any (overhead); and whether both ways kept the same bytes. Other
work on the machine falsifies all of it: the load is printed beside.
"""

import argparse
import os
import tempfile
import time
from collections import defaultdict
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


def main() -> int:
    """Measure; 0 if both bounds are kept."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--boards", nargs="+", default=BOARDS)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        planned = study(folder, given.boards)
        jobs = list(planned.jobs())
        warm(jobs)
        print(f"{len(jobs)} jobs, load {os.getloadavg()[0]:.1f}", flush=True)
        begun, cpu = time.perf_counter(), time.process_time()
        with open_store(folder / "one") as store:
            for job in jobs:
                store.keep(run_job(job))
        one_s, one_cpu_s = time.perf_counter() - begun, time.process_time() - cpu
        print(f"one process: {one_s:.1f} s, {one_cpu_s / one_s:.2f} cores, load {os.getloadavg()[0]:.1f}", flush=True)
        begun = time.perf_counter()
        with open_store(folder / "many") as store:
            work = partial(timed, folder / "times.txt")
            run_jobs(planned.jobs, store, local_cluster(given.workers), no_progress, work)
        many_s = time.perf_counter() - begun
        print(f"{given.workers} workers: {many_s:.1f} s, load {os.getloadavg()[0]:.1f}")
        busy_s = sum(spent for each in spans(folder / "times.txt").values() for _, _, spent in each)
        print(
            f"they had {busy_s / many_s:.2f} cores; jobs took {busy_s / one_cpu_s:.2f} of one process's processor time"
        )
        same = contents(folder / "one") == contents(folder / "many")
        ratio, overhead = one_s / many_s, overhead_of(folder / "times.txt")
        print(f"ratio {ratio:.2f} (at least {LEAST_RATIO}); overhead {overhead:.1%} (at most {MOST_OVERHEAD:.0%})")
        print(f"the same bytes: {'yes' if same else 'NO'}")
        return 0 if same and ratio >= LEAST_RATIO and overhead <= MOST_OVERHEAD else 1


def study(folder: Path, boards: list[str]) -> PlannedStudy:
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


def warm(jobs: list[Job]) -> None:
    """Compile what is compiled at its first use, and read the first board."""
    run_job(jobs[0])


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
