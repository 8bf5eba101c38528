"""``washboard analyse``, ``results`` and ``bath``: what a program cleans, beside measurements, and in a bath."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from commandline.arguments import (
    CellName,
    DataOutput,
    DialectOption,
    EffortOption,
    ParametersOption,
    Parts,
    ProgramRecipe,
    ProgramSource,
    board_numbers,
    flux_in_mg,
    input_argument,
    input_option,
    output_option,
)
from specs.output_file import OutputFile

if TYPE_CHECKING:
    from boards.board import Workpiece
    from cleaning.uncertainty.bath import Bath, BoardInBath
    from cleaning.uncertainty.comparison import Comparison
    from cleaning.uncertainty.measured_table import MeasuredTable
    from reports.tables.table import Card
    from specs.json import Json
    from washboard.cleaned import Cleaned

_ItsBoard: TypeAlias = Annotated[
    str | None,
    input_argument(
        "[BOARD]", "Board of the program; left out, it is looked for among the samples and beside the program."
    ),
]
_AllData: TypeAlias = Annotated[OutputFile | None, output_option("--json", "JSON", "All results, as data.")]
_NOT_CLEAN = 1
"""Exit code where anything is not predicted clean."""
_SPENT = 1
"""Exit code where the bath is spent before the last board that was named."""
_ESCAPES = 1
"""Exit code where something that was predicted clean was measured not clean."""


def analyse(
    program: ProgramSource,
    board: _ItsBoard = None,
    recipe: ProgramRecipe = None,
    parameters: ParametersOption = "default",
    parts: Parts = None,
    html: Annotated[OutputFile | None, output_option("--html", "HTML", "Report to read and print.")] = None,
    data: _AllData = None,
    verify: Annotated[
        str,
        typer.Option("--verify", help="Components to compute exactly too, separated by commas.", metavar="U1,U2"),
    ] = "",
    effort: EffortOption = "fast",
    capability: Annotated[
        bool,
        typer.Option(
            "--capability",
            help="How often each part comes out clean within the ranges of the parameter set's values too.",
        ),
    ] = False,
    measured: Annotated[
        Path | None, input_option("--results", "DATA.csv", "Table of measured cleanliness, compared in page and data.")
    ] = None,
    cell: CellName = None,
    dialect: DialectOption = None,
    log: Annotated[
        Path | None,
        input_option(
            "--log", "LOG.csv", "Table of time, place or joints, and jet: judge what ran in place of the plan."
        ),
    ] = None,
    serial: Annotated[str, typer.Option("--serial", help="For the report: serial number of the board.")] = "",
    detergent: Annotated[str, typer.Option("--detergent", help="For the report: detergent and lot.")] = "",
    bath_c: Annotated[str, typer.Option("--bath-c", help="For the report: measured bath temperature, °C.")] = "",
    conductivity: Annotated[
        str, typer.Option("--conductivity", help="For the report: measured conductivity of the rinse water, µS/cm.")
    ] = "",
    date: Annotated[str, typer.Option("--date", help="For the report: date, as you write it.")] = "",
) -> None:
    """Predict what a program cleans: what the jet reaches, what flows under parts, what stays there.

    With --cell the program is judged as the controller of its robot drives it, by the model of that.

    Of a part: for each face the time in the cone, what no free pose sees, and what hides it.

    It is a prediction for ranking and for finding what limits a process, and no proof of cleanliness.

    Exit code 0: every component, the bare board and the process are predicted clean. 1: something is dirty, marginal or
    without a verdict. 2: the job could not be done.

    [dim]washboard analyse demo.wash
    washboard analyse board.wash board.step --recipe mine.yaml --html board.html --json board.json
    washboard analyse demo.wash --effort full --verify U1,U7
    washboard analyse demo.wash --capability
    washboard analyse demo.wash --cell ur5e-bench
    washboard analyse demo.wash --log run.csv
    washboard analyse demo.wash --results measured.csv --html evidence.html[/dim]
    """
    from commandline.loading import finish, open_subject, progress_bar
    from washboard.cleaned import Traceability
    from washboard.cleaned import analyse as predict

    names = [name.strip() for name in verify.split(",") if name.strip()]
    subject = open_subject(program, board, recipe, parts, "analyse {file} BOARD")
    table = None if measured is None else _read_measured(measured, subject.workpiece)
    with progress_bar() as progress:
        done = predict(
            subject,
            parameters,
            effort,
            progress,
            capability=capability,
            verified=names,
            cell=cell,
            dialect=dialect,
            log=log,
        )
    trace = Traceability(serial, detergent, bath_c, conductivity, date)
    compared = None if table is None else _compare(done, table, recipe, parameters)
    finish(
        *_cards(done, compared),
        html=(html, lambda _: done.html(trace=trace, measured=compared)),
        data=(data, lambda _: done.data(trace, compared)),
    )
    if done.verdict != "clean":
        raise typer.Exit(_NOT_CLEAN)


def _cards(done: "Cleaned", compared: "tuple[Comparison, list[str]] | None") -> "Iterator[Card]":
    """Show the verdicts on components, or on faces."""
    from cleaning.verdicts.results import CleaningReport
    from reports.cards.cleaning import cleaning_card, face_tables, faces_card
    from reports.cards.measured import measured_card
    from reports.tables.cleaning_tables import this_producer, verified_table
    from reports.tables.table import Card

    if not isinstance(done.report, CleaningReport):
        yield faces_card(done.report.part.name, done.report.verdicts)
        yield Card("", face_tables(done.report.verdicts))
        return
    yield cleaning_card(done.report, f"by {this_producer(done.effort)}")
    yield Card("", (verified_table(done.verified),))
    if compared is not None:
        yield measured_card(done.report, *compared)


def _read_measured(path: Path, workpiece: "Workpiece") -> "MeasuredTable":
    """Read measured cleanliness of a board's components.

    Raises:
        JobError: it cannot be read or used.
    """
    from cleaning.uncertainty.measured_table import read_measured

    board = workpiece.require_board("a table of measured cleanliness")
    return read_measured(path, [*(each.name for each in board.components), "board"])


def _compare(
    done: "Cleaned", table: "MeasuredTable", recipe: str | None, parameters: str
) -> "tuple[Comparison, list[str]]":
    """Compare measurements with a prediction; with the command for each recalibration."""
    from cleaning.uncertainty.comparison import calibrate_command, compare_measured

    report = done.board_report
    found, used = compare_measured(report, table), recipe or report.origin.recipe
    return found, [calibrate_command(each, report, used, parameters) for each in found.recalibrations]


def results(
    program: ProgramSource,
    measured: Annotated[
        Path, input_argument("DATA.csv", "Table of measured cleanliness, a row for each component and method.")
    ],
    board: _ItsBoard = None,
    recipe: ProgramRecipe = None,
    parameters: ParametersOption = "default",
    parts: Parts = None,
    html: Annotated[
        OutputFile | None, output_option("--html", "HTML", "Report of the analysis with what was measured.")
    ] = None,
    data: DataOutput = None,
    effort: EffortOption = "fast",
) -> None:
    """Compare measured cleanliness with the prediction: hit rate, rank correlation, which rules were wrong.

    Columns: component, method (sir, ic, rose, tear-off), value, unit, limit; "board" is the bare board.

    Exit code 0: all that is predicted clean was measured clean. 1: something was not. 2: the job could not be done.

    [dim]washboard results demo.wash measured.csv
    washboard results board.wash sir.csv board.step --html evidence.html --json evidence.json[/dim]
    """
    from cleaning.report import summarise_report
    from cleaning.uncertainty.comparison import comparison_data
    from commandline.loading import finish, open_subject, progress_bar
    from reports.cards.measured import measured_card
    from reports.files.write_run import json_bytes
    from reports.tables.cleaning_tables import this_producer
    from washboard.cleaned import analyse as predict

    subject = open_subject(program, board, recipe, parts, "results {file} BOARD")
    table = _read_measured(measured, subject.workpiece)
    with progress_bar() as progress:
        done = predict(subject, parameters, effort, progress)
    found, commands = _compare(done, table, recipe, parameters)
    facts: dict[str, Json] = {"washboard_results": 1, **summarise_report(done.board_report)}
    facts["measured"] = comparison_data(found, commands)
    finish(
        measured_card(done.board_report, found, commands),
        html=(html, lambda _: done.html(measured=(found, commands))),
        data=(data, lambda _: json_bytes(this_producer(effort).add_to(facts))),
    )
    if found.confusion.clean_beyond:
        raise typer.Exit(_ESCAPES)


def bath(
    program: ProgramSource,
    board: _ItsBoard = None,
    litres: Annotated[float, typer.Option("--litres", help="Solution in the bath.", min=0.1, max=100_000)] = 40.0,
    boards: Annotated[
        str, typer.Option("--boards", help="Boards that are analysed, separated by commas.", metavar="1,100,400")
    ] = "1,100,400",
    flux_mg: Annotated[
        float | None,
        typer.Option("--flux-mg", help="Flux that a board brings; left out, what is in its gaps.", min=0, max=1e6),
    ] = None,
    flux: Annotated[
        str,
        typer.Option(
            "--flux",
            help="Liquid flux that a board got, by name, with millilitres: its solids, in place of --flux-mg.",
            metavar="NAME:ML",
        ),
    ] = "",
    drag_out_ml: Annotated[
        float | None,
        typer.Option(
            "--drag-out-ml",
            help="Solution that a board takes along; left out, a film on all its surfaces.",
            min=0,
            max=1e6,
        ),
    ] = None,
    begin_pct: Annotated[
        float | None,
        typer.Option(
            "--begin-pct",
            help="Non-volatile residue of the bath before the first board, %; left out, that of fresh solution.",
            min=0,
            max=100,
        ),
    ] = None,
    recipe: ProgramRecipe = None,
    parameters: ParametersOption = "default",
    parts: Parts = None,
    data: _AllData = None,
) -> None:
    """Follow a washing bath over many boards: what each brings and takes along, and when the bath is spent.

    Exit code 0: the bath serves all the boards that are named. 1: it is spent before the last of them. 2: the job could
    not be done.

    [dim]washboard bath demo.wash
    washboard bath demo.wash --litres 60 --boards 1,100,1000 --flux-mg 250 --begin-pct 1.8[/dim]
    """
    from cleaning.uncertainty.bath import bath_report
    from commandline.loading import finish
    from reports.cards.measured import bath_card
    from reports.files.write_run import json_bytes

    numbers = board_numbers(boards)
    given = (litres, flux_in_mg(flux, flux_mg), drag_out_ml, begin_pct)
    found, liquid, limit, washed = _follow((program, board, recipe, parts), parameters, given, numbers)
    shown = found, liquid, limit, washed
    finish(bath_card(*shown), json=(data, lambda _: json_bytes(bath_report(*shown))))
    spent = found.boards_until(limit)
    if spent is not None and spent < numbers[-1]:
        raise typer.Exit(_SPENT)


def _follow(
    source: tuple[Path, str | None, str | None, Parts],
    parameters: str,
    given: tuple[float, float | None, float | None, float | None],
    numbers: list[int],
) -> "tuple[Bath, str, float, list[BoardInBath]]":
    """Find what a board does to the bath, and analyse those that were named, each in the bath of its moment.

    Args:
        source: Program, board, recipe and parts table.
        parameters: The parameter set.
        given: Litres of the bath; flux in mg, drag-out in ml and residue at the beginning in %, ``None`` where it is
            to be found.
        numbers: Of the boards.

    Raises:
        JobError: it cannot be done.
    """
    from cleaning.analyse import analyse_on
    from cleaning.parameters.load import load_parameters
    from cleaning.parameters.provenance import with_values
    from cleaning.prepared_board import prepare
    from cleaning.uncertainty.bath import Bath, BoardInBath, drag_out_ml, flux_g, washing_liquid
    from commandline.loading import open_subject, progress_bar
    from specs.progress import subprogress

    subject = open_subject(*source, "bath {file} BOARD")
    board, program, recipe = subject.workpiece.require_board("a washing bath"), subject.program, subject.recipe
    known = load_parameters(parameters)
    litres, flux_mg, dragged_ml, begin_pct = given
    with progress_bar() as progress:
        prepared = prepare(board, known, subprogress(progress, 0.0, 0.1))
        share = 0.9 / (len(numbers) + 1)
        first = analyse_on(
            prepared, program, recipe, progress=subprogress(progress, 0.1, 0.1 + share), sensitivity=False
        )
        liquid = washing_liquid(first)
        known, solution = first.parameters, first.parameters.liquids[liquid]
        bath = Bath(
            volume_l=litres,
            density_kg_m3=solution.density_kg_m3,
            fresh_pct=solution.bath_nvr_pct,
            flux_g=flux_g(first) if flux_mg is None else 1e-3 * flux_mg,
            drag_out_ml=drag_out_ml(first) if dragged_ml is None else dragged_ml,
            begin_pct=begin_pct,
        )
        washed: list[BoardInBath] = []
        for at, number in enumerate(numbers, start=1):
            residue = bath.residue_pct(number - 1)
            spent = {f"liquids.{liquid}.bath_nvr_pct": residue}
            tanks = (
                ()
                if first.rinse_water is None
                else first.rinse_water.cascade.after_g_m3(number - 1, *bath.carried_g_m3)
            )
            later = replace(prepared, parameters=with_values(known, spent), tanks_g_m3=tanks)
            part = subprogress(progress, 0.1 + at * share, 0.1 + (at + 1) * share)
            report = analyse_on(later, program, recipe, progress=part, sensitivity=False)
            washed.append(BoardInBath(number, residue, report))
    return bath, liquid, known.limits.bath_nvr_pct, washed
