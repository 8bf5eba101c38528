"""``washboard study``: boards by recipes by parameter sets by values, computed in many processes."""

import os
from pathlib import Path
from typing import Annotated

import typer

from commandline.arguments import input_argument, output_folder
from specs.output_file import OutputFolder

_MOST_WORKERS = 1000
_INCOMPLETE = 1
"""Exit code where runs ended in an error."""


def study(
    study_file: Annotated[Path, input_argument("STUDY.yaml", "What is studied.")],
    output: Annotated[
        OutputFolder,
        typer.Option(
            "--output",
            "-o",
            help="Folder for finished results and tables; made if needed.",
            metavar="FOLDER",
            parser=output_folder(),
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
    memory: Annotated[
        float | None,
        typer.Option("--memory", help="Limit of each process; left out, none.", min=0.5, max=10000, metavar="GB"),
    ] = None,
    dashboard: Annotated[
        bool,
        typer.Option("--dashboard", help="Serve Dask's dashboard; its address, or the scheduler's, is printed."),
    ] = False,
) -> None:
    """Plan and analyse boards with recipes at many values and under tolerances: tables, Pareto fronts, main effects.

    Results are kept as they come: after an interrupt, or with a longer study, the same command computes the others.

    Exit code 0: all runs are in the table. 1: some ended in an error, stated there. 2: the job could not be done.

    [dim]washboard study speeds.yaml -o speeds
    washboard study speeds.yaml -o speeds --scheduler tcp://127.0.0.1:8786[/dim]
    """
    from commandline.loading import finish, progress_bar
    from specs.errors import JobError
    from studies.results.card import study_card
    from washboard.studied import study as compute

    if scheduler is not None and workers is not None:
        raise JobError("--workers is for processes on this machine; a cluster of --scheduler has its own.")
    if scheduler is not None and memory is not None:
        raise JobError("--memory is for processes on this machine; a cluster of --scheduler has its own limits.")
    count = None if scheduler is not None else workers or len(os.sched_getaffinity(0))
    with progress_bar() as progress:
        done = compute(
            study_file, output.path, scheduler, progress, workers=count, memory_gb=memory or 0.0, dashboard=dashboard
        )
    finish(study_card(done.planned, done.summary, done.computed), *done.files)
    if done.summary.failed:
        raise typer.Exit(_INCOMPLETE)
