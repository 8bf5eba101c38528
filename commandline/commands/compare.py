"""``washboard compare``: two recipes, or programs, on the same board."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import BoardSource, Parts, complete_recipe
from commandline.commands.analyse import Effort, EffortOption, ParametersOption, check_files
from commandline.errors import job_errors

if TYPE_CHECKING:
    from boards.board import Board
    from cleaning.verdicts.results import CleaningReport
    from programs.program import TimedProgram
    from recipes.recipe import Recipe
    from reports.tables.comparison import Row
    from rulesengine.planning.pipeline import Run
    from specs.progress import Progress

_PROGRAM = ".wash"

Compared = Annotated[
    str,
    typer.Argument(
        help="Recipe, a file or a name of the library, that is planned on the board; or a program made for it.",
        metavar="RECIPE|PROGRAM.wash",
        autocompletion=complete_recipe,
    ),
]


def compare(
    board: BoardSource,
    one: Compared,
    other: Compared,
    parameters: ParametersOption = "default",
    parts: Parts = None,
    html: Annotated[Path | None, typer.Option("--html", help="Both side by side, to print.", metavar="HTML")] = None,
    data: Annotated[Path | None, typer.Option("--json", help="The same as data.", metavar="JSON")] = None,
    effort: EffortOption = "fast",
) -> None:
    """Predict what two recipes, or programs, clean on a board: time, litres, strokes, and verdicts that differ.

    Strokes and findings are those of planning: they are compared where both are recipes.

    [dim]washboard compare smt-demo smt-aqueous low-standoff
    washboard compare board.step mine.yaml thine.yaml --html both.html
    washboard compare smt-demo old.wash new.wash[/dim]
    """
    with job_errors():
        from reports.tables.comparison import compare_cleaning
        from reports.terminal.cleaning_card import print_comparison
        from reports.terminal.console import open_console, print_files

        check_files((board, one, other, parameters, parts), {"a page": html, "a report": data})
        asked = (_read(one), _read(other))
        (here, cleaned), (there, cleaned_there) = _carry_out((board, parts), asked, parameters, effort)
        rows = [*compare_cleaning(cleaned, cleaned_there), *_compare(here, there)]
        names = _names(*asked)
        _write(rows, (cleaned, cleaned_there), names, html, data)
        console = open_console()
        print_comparison(console, rows, cleaned, names)
        print_files(console, html=html, data=data)


@dataclass(frozen=True, slots=True, eq=False)
class _Asked:
    """What is to be compared, as it was read."""

    source: str
    recipe: "Recipe"
    program: "TimedProgram | None"
    """``None`` where the recipe is to be planned."""


@dataclass(frozen=True, slots=True, eq=False)
class _Carried:
    """A program on the board."""

    recipe: "Recipe"
    program: "TimedProgram"
    run: "Run | None"
    """``None`` where it was not planned here."""


def _read(source: str) -> _Asked:
    """Read a recipe, or a program with the recipe that it was made with.

    Raises:
        JobError: it cannot be used.
    """
    from programs.load import load_program
    from recipes.load import load_recipe
    from reports.files.find_recipe import find_recipe_of

    file = Path(source)
    if file.suffix.lower() != _PROGRAM:
        return _Asked(source, load_recipe(source), None)
    program = load_program(file)
    return _Asked(source, find_recipe_of(program, file, "Put it beside the program, or plan the board again."), program)


def _carry_out(
    source: tuple[str, Path | None], asked: tuple[_Asked, _Asked], parameters: str, effort: Effort
) -> "list[tuple[_Carried, CleaningReport]]":
    """Plan what is to be planned and analyse both, on a board that is made ready once.

    Raises:
        JobError: something cannot be used.
    """
    from boards.load import load_board
    from cleaning.analyse import analyse_on
    from cleaning.parameters.load import load_parameters
    from cleaning.prepared_board import prepare
    from commandline.loading import progress_bar
    from specs.progress import subprogress

    known = load_parameters(parameters)
    with progress_bar() as progress:
        board = load_board(Path(source[0]), source[1], subprogress(progress, 0.0, 0.1))
        one, other = asked
        carried = (
            _carry(one, board, subprogress(progress, 0.1, 0.2)),
            _carry(other, board, subprogress(progress, 0.2, 0.3)),
        )
        prepared = prepare(board, known, subprogress(progress, 0.3, 0.4))
        spans = (subprogress(progress, 0.4, 0.7), subprogress(progress, 0.7, 1.0))
        return [
            (each, analyse_on(prepared, each.program, each.recipe, effort, span))
            for each, span in zip(carried, spans, strict=True)
        ]


def _carry(asked: _Asked, board: "Board", progress: "Progress") -> _Carried:
    """Plan a recipe; a program is there already.

    Raises:
        JobError: the recipe cannot be planned, or the program was made for another board.
    """
    from reports.files.fingerprints import refuse_other_version
    from rulesengine.planning.pipeline import run

    if asked.program is not None:
        refuse_other_version(asked.program, Path(asked.source), board)
        return _Carried(asked.recipe, asked.program, None)
    planned = run(asked.recipe, board, progress)
    return _Carried(planned.recipe, planned.program, planned)


def _compare(here: _Carried, there: _Carried) -> "list[Row]":
    from reports.tables.comparison import compare, compare_programs

    if here.run is None or there.run is None:
        return compare_programs(here.program, there.program)
    return compare(here.run, there.run)


def _names(here: _Asked, there: _Asked) -> tuple[str, str]:
    """Call recipes by their names and programs by their files; what would be called the same, as it was asked for."""
    one, other = (each.recipe.recipe if each.program is None else Path(each.source).name for each in (here, there))
    return (one, other) if one != other else (here.source, there.source)


def _write(
    rows: "list[Row]",
    reports: "tuple[CleaningReport, CleaningReport]",
    names: tuple[str, str],
    html: Path | None,
    data: Path | None,
) -> None:
    """Render everything, then write it."""
    from reports.files.atomic_write import write_bytes_atomically
    from reports.files.write_run import json_bytes

    contents: list[tuple[Path, bytes]] = []
    if html is not None:
        from reports.html.comparison_page import comparison_page

        contents.append((html, comparison_page(rows, reports, names).encode("utf-8", errors="replace")))
    if data is not None:
        from reports.tables.comparison import comparison_data

        contents.append((data, json_bytes(comparison_data(rows, *reports))))
    for path, content in contents:
        write_bytes_atomically(path, content)
