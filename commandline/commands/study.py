"""``washboard study``: boards by recipes by parameter sets by values, computed in many processes."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.errors import job_errors

if TYPE_CHECKING:
    from studies.planned_study import PlannedStudy
    from studies.store import ResultStore

_MOST_WORKERS = 1000
_INCOMPLETE = 1
"""Exit code where runs ended in an error."""


def study(
    study_file: Annotated[Path, typer.Argument(help="What is studied.", metavar="STUDY.yaml")],
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", help="Folder for finished results and tables; made if needed.", metavar="FOLDER"
        ),
    ],
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler",
            help="Address of a Dask scheduler whose workers compute; left out, processes on this machine do.",
            metavar="tcp://HOST:PORT",
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option("--workers", help="Processes on this machine; left out, one a core.", min=1, max=_MOST_WORKERS),
    ] = None,
) -> None:
    """Plan and analyse boards with recipes at many values and under tolerances: tables, Pareto fronts, main effects.

    Results are kept as they come: after an interrupt, or with a longer study, the same command computes the others.

    Exit code 0: all runs are in the table. 1: some ended in an error, stated there. 2: the job could not be done.

    [dim]washboard study speeds.yaml -o speeds
    washboard study speeds.yaml -o speeds --scheduler tcp://127.0.0.1:8786[/dim]
    """
    with job_errors():
        from functools import partial

        from commandline.loading import progress_bar
        from specs.errors import JobError
        from specs.progress import subprogress
        from studies.planned_study import plan_study
        from studies.run_job import run_job
        from studies.runner import existing_cluster, local_cluster, run_jobs
        from studies.store import open_store

        if scheduler is not None and workers is not None:
            raise JobError("--workers is for processes on this machine; a cluster of --scheduler has its own.")
        with progress_bar() as progress:
            planned = plan_study(study_file, subprogress(progress, 0.0, 0.01))
        cores = len(os.sched_getaffinity(0))
        count = workers or cores
        cluster = local_cluster(count) if scheduler is None else existing_cluster(scheduler)
        # A cluster that is there has as many workers as it has cores, and other work besides.
        work = partial(run_job, threads=max(1, cores // count) if scheduler is None else 1)
        with open_store(output) as store:
            with progress_bar() as progress:
                computed = run_jobs(planned.queues(), store, cluster, progress, work)
            failed = _write(planned, store, output, computed)
        if failed:
            raise typer.Exit(_INCOMPLETE)


def _write(planned: "PlannedStudy", store: "ResultStore", folder: Path, computed: int) -> int:
    """Write the tables and the picture, print the result; returns how many runs ended in an error."""
    from reports.files.atomic_write import write_outputs
    from reports.terminal.console import open_console, print_card, print_files
    from specs import ending
    from studies.results import tables
    from studies.results.card import study_card
    from studies.results.page import study_page
    from studies.results.picture import draw_study
    from studies.results.summary import runs_of, summarise

    summary = summarise(planned, runs_of(planned, store))
    found = {
        tables.RUNS: tables.runs_table(planned, summary, runs_of(planned, store)),
        tables.COMPONENTS: tables.components_table(planned, summary),
        tables.EFFECTS: tables.effects_table(summary),
    }
    contents: dict[Path | None, str | bytes | None] = {}
    for name, table in found.items():
        if table:
            contents[folder / f"{name}.csv"] = tables.csv_bytes(table)
            contents[folder / f"{name}.parquet"] = tables.parquet_bytes(table)
    contents[folder / "pareto.svg"] = draw_study(planned.study.study, summary, ".svg")
    contents[folder / "study.html"] = study_page(planned, summary)
    write_outputs(contents)
    ending.note_reached(None)
    console = open_console()
    print_card(console, study_card(planned, summary, computed))
    print_files(console, *(path for path in contents if path is not None))
    return summary.failed
