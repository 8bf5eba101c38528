"""``washboard compare``: two recipes, or programs, on the same board."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from commandline.arguments import (
    BoardSource,
    DataOutput,
    EffortOption,
    ParametersOption,
    Parts,
    input_argument,
    output_option,
)
from specs.output_file import OutputFile

if TYPE_CHECKING:
    from boards.board import Board
    from specs.progress import Progress
    from washboard.inputs import OpenedProgram
    from washboard.planned import Planned

_PROGRAM = ".wash"

Compared = Annotated[
    str,
    input_argument(
        "RECIPE|PROGRAM.wash",
        "Recipe, a file or a name of the library, that is planned on the board; or a program made for it.",
    ),
]


def compare(
    board: BoardSource,
    one: Compared,
    other: Compared,
    parameters: ParametersOption = "default",
    parts: Parts = None,
    html: Annotated[OutputFile | None, output_option("--html", "HTML", "Both side by side, to print.")] = None,
    data: DataOutput = None,
    effort: EffortOption = "fast",
) -> None:
    """Predict what two recipes, or programs, clean on a board: time, litres, strokes, and verdicts that differ.

    Strokes and findings are those of planning: they are compared where both are recipes.

    [dim]washboard compare smt-demo smt-aqueous low-standoff
    washboard compare board.step mine.yaml thine.yaml --html both.html
    washboard compare smt-demo old.wash new.wash[/dim]
    """
    from boards.workpiece import load_workpiece
    from cleaning.analyse import analyse_on
    from cleaning.parameters.load import load_parameters
    from cleaning.prepared_board import prepare
    from commandline.loading import finish, progress_bar
    from reports.cards.cleaning import comparison_card
    from reports.files.write_run import json_bytes
    from reports.html.cleaning_page import comparison_page
    from reports.tables import comparison
    from specs.progress import subprogress
    from washboard.planned import Planned

    read, known = (_read(one), _read(other)), load_parameters(parameters)
    with progress_bar() as progress:
        opened = load_workpiece(board, parts, subprogress(progress, 0.0, 0.1)).require_board("compare")
        here, there = (
            subject_on(opened, subprogress(progress, 0.1 * index, 0.1 * index + 0.1))
            for index, subject_on in enumerate(read, start=1)
        )
        prepared = prepare(opened, known, subprogress(progress, 0.3, 0.4))
        cleaned, cleaned_there = (
            analyse_on(prepared, each.program, each.recipe, effort, span, sensitivity=data is not None)
            for each, span in (
                (here, subprogress(progress, 0.4, 0.7)),
                (there, subprogress(progress, 0.7, 1.0)),
            )
        )
    rows = comparison.compare_cleaning(cleaned, cleaned_there)
    if isinstance(here, Planned) and isinstance(there, Planned):
        rows += comparison.compare(here.run, there.run)
    else:
        rows += comparison.compare_programs(here.program, there.program)
    names = _name(here), _name(there)
    if names[0] == names[1]:
        names = one, other
    reports = cleaned, cleaned_there
    finish(
        comparison_card(rows, cleaned, names),
        html=(html, lambda _: comparison_page(rows, reports, names)),
        data=(data, lambda _: json_bytes(comparison.comparison_data(rows, *reports))),
    )


def _read(source: str) -> "Callable[[Board, Progress], Planned | OpenedProgram]":
    """Read a recipe, or a program with its recipe, and give what plans it on the board, or refuses another board.

    Raises:
        JobError: it cannot be used.
    """
    from programs.load import load_program
    from washboard.inputs import OpenedProgram, find_recipe, open_recipe, require_workpiece
    from washboard.planned import plan

    file = Path(source)
    if file.suffix.lower() != _PROGRAM:
        opened = open_recipe(source)
        return lambda board, progress: plan(board, opened, progress=progress)
    program = load_program(file)
    recipe = find_recipe(program, file, "Put it beside the program, or plan the board again.")

    def hold(board: "Board", _: "Progress") -> "OpenedProgram":
        require_workpiece(program, file, board, exactly=True)
        return OpenedProgram(program, file, board, recipe, ())

    return hold


def _name(subject: "Planned | OpenedProgram") -> str:
    """Of a recipe its own, of a program that of its file."""
    from washboard.inputs import OpenedProgram

    return subject.file.name if isinstance(subject, OpenedProgram) else subject.recipe.recipe
