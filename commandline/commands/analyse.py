"""``washboard analyse``: what a program cleans on its board."""

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import (
    Effort,
    EffortOption,
    ParametersOption,
    Parts,
    ProgramSource,
    complete_board,
    complete_recipe,
)
from commandline.errors import job_errors

if TYPE_CHECKING:
    from boards.board import Board
    from cleaning.verdicts.results import CleaningReport
    from cleaning.verify import Verified
    from programs.program import TimedProgram
    from recipes.recipe import Recipe

_NOT_CLEAN = 1
"""Exit code where anything is not predicted clean."""


def analyse(
    program: ProgramSource,
    board: Annotated[
        str | None,
        typer.Argument(
            help="Board of the program; left out, it is looked for among the samples and beside the program.",
            metavar="[BOARD]",
            autocompletion=complete_board,
        ),
    ] = None,
    recipe: Annotated[
        str | None,
        typer.Option(
            "--recipe",
            help="Recipe of the program; left out, it is looked for in the library and beside the program.",
            metavar="RECIPE",
            autocompletion=complete_recipe,
        ),
    ] = None,
    parameters: ParametersOption = "default",
    parts: Parts = None,
    html: Annotated[Path | None, typer.Option("--html", help="Report to read and print.", metavar="HTML")] = None,
    data: Annotated[Path | None, typer.Option("--json", help="All results, as data.", metavar="JSON")] = None,
    verify: Annotated[
        str,
        typer.Option("--verify", help="Components to compute exactly too, separated by commas.", metavar="U1,U2"),
    ] = "",
    effort: EffortOption = "fast",
    serial: Annotated[str, typer.Option("--serial", help="For the report: serial number of the board.")] = "",
    detergent: Annotated[str, typer.Option("--detergent", help="For the report: detergent and lot.")] = "",
    bath_c: Annotated[str, typer.Option("--bath-c", help="For the report: measured bath temperature, °C.")] = "",
    conductivity: Annotated[
        str, typer.Option("--conductivity", help="For the report: measured conductivity of the rinse water, µS/cm.")
    ] = "",
    date: Annotated[str, typer.Option("--date", help="For the report: date, as you write it.")] = "",
) -> None:
    """Predict what a program cleans: what the jet reaches, what flows under parts, what stays there.

    It is a prediction for ranking and for finding what limits a process, and no proof of cleanliness.

    Exit code 0: every component, the bare board and the process are predicted clean. 1: something is dirty, marginal or
    without a verdict. 2: the job could not be done.

    [dim]washboard analyse demo.wash
    washboard analyse board.wash board.step --recipe mine.yaml --html board.html --json board.json
    washboard analyse demo.wash --effort full --verify U1,U7[/dim]
    """
    with job_errors():
        from cleaning.report import Traceability
        from reports.files.atomic_write import write_outputs
        from reports.files.write_run import check_places, cleaning_bytes
        from reports.html.cleaning_page import cleaning_page
        from reports.tables.cleaning_tables import this_producer
        from reports.terminal.cleaning_card import print_cleaning, print_verified
        from reports.terminal.console import open_console, print_files
        from rulesengine.tuning.suggest import advise

        check_places((program, board, recipe, parameters, parts), {"a page": html, "a report": data})
        inputs = _read(program, board, recipe, parts)
        names = [name.strip() for name in verify.split(",") if name.strip()]
        report, verified = _analyse(inputs, parameters, effort, names)
        report = advise(report, inputs[0], inputs[2])
        sha256 = hashlib.sha256(program.read_bytes()).hexdigest()
        trace = Traceability(serial, detergent, bath_c, conductivity, date, sha256)
        producer = this_producer(effort)
        write_outputs({
            html: None if html is None else cleaning_page(report, trace, verified, producer),
            data: None if data is None else cleaning_bytes(report, producer, trace, verified),
        })  # fmt: skip
        console = open_console()
        print_cleaning(console, report, producer)
        print_verified(console, verified)
        print_files(console, html=html, data=data)
        if report.verdict != "clean":
            raise typer.Exit(_NOT_CLEAN)


def _read(
    file: Path, board: str | None, recipe: str | None, parts: Path | None
) -> "tuple[TimedProgram, Board, Recipe]":
    """Read a program with its board and its recipe.

    Raises:
        JobError: one of them cannot be used or was not found.
    """
    from boards.errors import BoardError
    from commandline.loading import read_program_board
    from programs.load import load_program
    from recipes.load import load_recipe
    from reports.files.inputs import find_recipe, require_board
    from specs.errors import printable

    program = load_program(file)
    loaded_recipe = find_recipe(program, file) if recipe is None else load_recipe(recipe)
    loaded = read_program_board(program, file, board, parts, warn=False)
    if loaded is None:
        raise BoardError(
            f"the board {program.origin.board!r} of this program was not found. "
            f"Name it: washboard analyse {printable(str(file))} BOARD.",
            file=file,
        )
    require_board(program, file, loaded)
    return program, loaded, loaded_recipe


def _analyse(
    inputs: "tuple[TimedProgram, Board, Recipe]", parameters: str, effort: Effort, names: list[str]
) -> "tuple[CleaningReport, tuple[Verified, ...]]":
    """Analyse, and compute some components exactly.

    Raises:
        JobError: it cannot be done.
    """
    from cleaning.analyse import analyse_on
    from cleaning.parameters.load import load_parameters
    from cleaning.prepared_board import prepare
    from cleaning.verify import check_names, verify
    from commandline.loading import progress_bar
    from reports.files.inputs import find_differences, with_differences
    from specs.progress import subprogress

    program, board, recipe = inputs
    check_names(board, names)
    differences = find_differences(program, board, recipe)
    for each in differences:
        typer.echo(f"warning: {each.message}", err=True)
    loaded = load_parameters(parameters)
    with progress_bar() as progress:
        prepared = prepare(board, loaded, subprogress(progress, 0.0, 0.2))
        report = analyse_on(prepared, program, recipe, effort, subprogress(progress, 0.2, 1.0))
        if names:
            progress("verifying", 1.0)
        verified = verify(report, prepared, names)
    return with_differences(report, differences), verified
