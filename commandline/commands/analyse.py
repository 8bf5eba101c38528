"""``washboard analyse``: what a program cleans on its board."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from commandline.arguments import Parts, complete_board, complete_parameters, complete_recipe
from commandline.errors import job_errors

if TYPE_CHECKING:
    from boards.board import Board
    from cleaning.report import Traceability
    from cleaning.verdicts.results import CleaningReport
    from cleaning.verify import Verified
    from programs.program import TimedProgram
    from recipes.recipe import Recipe
    from reports.tables.report_header import Made

Effort: TypeAlias = Literal["fast", "full"]
_NOT_CLEAN = 1
"""Exit code where anything is not predicted clean."""

EffortOption = Annotated[
    Effort, typer.Option("--effort", help="fast: 64 rays a sample; full: 256 rays, and samples twice as dense.")
]
ParametersOption = Annotated[
    str,
    typer.Option(
        "--parameters",
        help="Parameter set of the cleaning model: a name or a file.",
        metavar="PARAMETERS",
        autocompletion=complete_parameters,
    ),
]


def analyse(
    program: Annotated[Path, typer.Argument(help="Native program.", metavar="PROGRAM.wash")],
    board: Annotated[
        str | None,
        typer.Argument(
            help="Board it was made for; found by itself among the samples and beside the program.",
            metavar="[BOARD]",
            autocompletion=complete_board,
        ),
    ] = None,
    recipe: Annotated[
        str | None,
        typer.Option(
            "--recipe",
            help="Recipe it was made with; found by itself in the library and beside the program.",
            metavar="RECIPE",
            autocompletion=complete_recipe,
        ),
    ] = None,
    parameters: ParametersOption = "default",
    parts: Parts = None,
    html: Annotated[Path | None, typer.Option("--html", help="Report to look at and print.", metavar="HTML")] = None,
    data: Annotated[Path | None, typer.Option("--json", help="Everything it found, as data.", metavar="JSON")] = None,
    verify: Annotated[
        str, typer.Option("--verify", help="Components to work out exactly besides, by commas.", metavar="U1,U2")
    ] = "",
    effort: EffortOption = "fast",
    serial: Annotated[str, typer.Option("--serial", help="For the report: serial number of the board.")] = "",
    detergent: Annotated[str, typer.Option("--detergent", help="For the report: detergent and lot.")] = "",
    bath_c: Annotated[str, typer.Option("--bath-c", help="For the report: measured bath temperature, °C.")] = "",
    conductivity: Annotated[
        str, typer.Option("--conductivity", help="For the report: measured conductivity of the rinse water, µS/cm.")
    ] = "",
    date: Annotated[str, typer.Option("--date", help="For the report: the day, as you write it.")] = "",
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
        from reports.tables.report_header import made_here
        from reports.terminal.cleaning_card import print_cleaning, print_verified
        from reports.terminal.console import open_console, print_files

        check_files((program, board, recipe, parameters, parts), {"a page": html, "a report": data})
        asked, made_for, made_with = _read(program, board, recipe, parts)
        names = [name.strip() for name in verify.split(",") if name.strip()]
        report, verified = _analyse(asked, made_for, made_with, parameters, effort, names)
        trace = Traceability(serial, detergent, bath_c, conductivity, date, _sha256(program))
        made = made_here(effort)
        _write(report, verified, trace, html, data, made)
        console = open_console()
        print_cleaning(console, report, made)
        if verified:
            print_verified(console, verified)
        print_files(console, html=html, data=data)
        if report.verdict != "clean":
            raise typer.Exit(_NOT_CLEAN)


def check_files(read: Sequence[str | Path | None], wanted: Mapping[str, Path | None]) -> None:
    """Refuse places that cannot be meant or written, before the long work begins.

    Args:
        read: What the command reads.
        wanted: Where each kind is to be written.

    Raises:
        OutputError: one of them cannot be meant or written.
    """
    from reports.files.write_run import check_apart, check_named

    check_apart(read, [path for path in wanted.values() if path is not None])
    check_named(wanted)


def _read(
    program: Path, board: str | None, recipe: str | None, parts: Path | None
) -> "tuple[TimedProgram, Board, Recipe]":
    """Read a program with what it was made from.

    Raises:
        JobError: one of them cannot be used or is not at hand.
    """
    from boards.errors import BoardError
    from commandline.loading import read_board, read_board_of
    from programs.load import load_program
    from recipes.load import load_recipe
    from reports.files.find_recipe import find_recipe_of
    from reports.files.fingerprints import refuse_other_board

    asked = load_program(program)
    made_with = find_recipe_of(asked, program) if recipe is None else load_recipe(recipe)
    made_for = read_board_of(asked, program, None, parts) if board is None else read_board(board, parts)
    if made_for is None:
        raise BoardError(
            f"{program}: the board {asked.origin.board!r} that this program was made for is not at hand. "
            f"Name it: washboard analyse {program} BOARD."
        )
    refuse_other_board(asked, program, made_for)
    return asked, made_for, made_with


def _analyse(
    program: "TimedProgram", board: "Board", recipe: "Recipe", parameters: str, effort: Effort, names: list[str]
) -> "tuple[CleaningReport, tuple[Verified, ...]]":
    """Analyse, and work out some components exactly.

    Raises:
        JobError: it cannot be done.
    """
    from cleaning.analyse import analyse_on
    from cleaning.parameters.load import load_parameters
    from cleaning.prepared_board import prepare
    from cleaning.verify import check_names, verify
    from commandline.loading import progress_bar
    from reports.files.fingerprints import find_differences, state_used
    from specs.progress import subprogress

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
    return state_used(report, differences), verified


def _sha256(program: Path) -> str:
    """Hash a program's file, to say of which it is told; empty if it is no file that can be read again."""
    import hashlib

    return hashlib.sha256(program.read_bytes()).hexdigest() if program.is_file() else ""


def _write(
    report: "CleaningReport",
    verified: "Sequence[Verified]",
    trace: "Traceability",
    html: Path | None,
    data: Path | None,
    made: "Made",
) -> None:
    """Render everything, then write it."""
    from reports.files.atomic_write import write_bytes_atomically
    from reports.files.write_run import cleaning_bytes

    contents: list[tuple[Path, bytes]] = []
    if html is not None:
        from reports.html.cleaning_page import cleaning_page

        contents.append((html, cleaning_page(report, trace, verified, made).encode("utf-8", errors="replace")))
    if data is not None:
        contents.append((data, cleaning_bytes(report, made, trace, verified)))
    for path, content in contents:
        write_bytes_atomically(path, content)
