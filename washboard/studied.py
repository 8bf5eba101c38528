"""Studies: boards by recipes by values, in this process, in several, or on a cluster."""

import os
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from specs import ending
from specs.output_file import OutputFile, write_outputs
from specs.progress import Progress, no_progress, subprogress
from studies.planned_study import PlannedStudy, plan_study
from studies.results import tables
from studies.results.page import draw_study, study_page
from studies.results.summary import CaseSummary, Summary, runs_of, summarise
from studies.run_job import run_job
from studies.runner import existing_cluster, local_cluster, own_client, run_jobs
from studies.store import ResultStore, open_store

if TYPE_CHECKING:
    from distributed import Client


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Studied:
    """A study whose results are in its folder, with tables and a page."""

    planned: PlannedStudy
    summary: Summary
    computed: int
    """Jobs that were computed now."""
    files: tuple[Path, ...]

    @property
    def cases(self) -> tuple[CaseSummary, ...]:
        """What each combination comes to."""
        return self.summary.cases

    @property
    def page(self) -> Path:
        """The page with all results."""
        return next(each for each in self.files if each.suffix == ".html")

    def __repr__(self) -> str:
        return f"<study of {len(self.cases)} combinations>"

    def _repr_html_(self) -> str:
        return study_page(self.planned, self.summary)


def study(
    file: str | Path,
    output: str | Path,
    client: "Client | str | None" = None,
    progress: Progress = no_progress,
    *,
    workers: int | None = None,
    memory_gb: float = 0.0,
    dashboard: bool = False,
) -> Studied:
    """Plan and analyse boards with recipes at many values and under tolerances.

    Results are kept as they come: a study that is begun again computes what is left.

    Args:
        file: The study.
        output: Folder of its results.
        client: Dask client, or the address of a scheduler, whose workers compute.
        progress: Receives the stage and the share done.
        workers: Processes on this machine; without these and without a client, this process computes.
        memory_gb: Of each of these processes; 0 for no limit.
        dashboard: Whether Dask's dashboard is served, and its address goes with the progress.

    Raises:
        JobError: something cannot be used or written.
    """
    planned = plan_study(Path(file), subprogress(progress, 0.0, 0.01))
    cores = len(os.sched_getaffinity(0))
    # A cluster that is there has as many workers as it has cores, and other work besides.
    work = partial(run_job, threads=max(1, cores // workers) if workers else 1 if client else cores)
    with open_store(Path(output)) as store:
        if client is None and workers is None:
            computed = _compute_here(planned, store, progress, work)
        else:
            cluster = _cluster(client, workers or 1, memory_gb, dashboard=dashboard)
            computed = run_jobs(planned.queues(), store, cluster, progress, work, dashboard=dashboard)
        return _summarised(planned, store, Path(output), computed)


def _cluster(
    client: "Client | str | None", workers: int, memory_gb: float, *, dashboard: bool
) -> "AbstractContextManager[Client]":
    if isinstance(client, str):
        return existing_cluster(client)
    return local_cluster(workers, memory_gb, dashboard=dashboard) if client is None else own_client(client)


def _compute_here(planned: PlannedStudy, store: ResultStore, progress: Progress, work: Any) -> int:
    """Compute the jobs that are not kept yet, one after the other."""
    jobs = {job.key: job for job in planned.jobs()}
    left = [job for job in jobs.values() if store.find(job.key) is None]
    for done, job in enumerate(left):
        progress(f"{len(jobs) - len(left) + done} of {len(jobs)} jobs", done / len(left))
        store.keep(work(job))
    return len(left)


def _summarised(planned: PlannedStudy, store: ResultStore, folder: Path, computed: int) -> Studied:
    """Write the tables, the picture and the page."""
    summary = summarise(planned, runs_of(planned, store))
    found = {
        tables.RUNS: tables.runs_table(planned, summary, runs_of(planned, store)),
        tables.COMPONENTS: tables.components_table(planned, summary),
        tables.EFFECTS: tables.effects_table(summary),
    }
    contents: dict[OutputFile | None, str | bytes | None] = {}
    for name, table in found.items():
        if table:
            contents[OutputFile(folder / f"{name}.csv")] = tables.csv_bytes(table)
            contents[OutputFile(folder / f"{name}.parquet")] = tables.parquet_bytes(table)
    contents[OutputFile(folder / "pareto.svg")] = draw_study(planned.study.study, summary, ".svg")
    contents[OutputFile(folder / "study.html")] = study_page(planned, summary)
    write_outputs(contents)
    ending.note_reached(None)
    return Studied(planned, summary, computed, tuple(file.path for file in contents if file))
