"""``washboard compare``: two recipes, or programs, on the same board."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import BoardSource, Effort, EffortOption, ParametersOption, Parts, complete_recipe

if TYPE_CHECKING:
    from boards.board import Board
    from cleaning.verdicts.results import CleaningReport
    from programs.program import TimedProgram
    from recipes.recipe import Recipe
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
    from reports.cards.cleaning import comparison_card
    from reports.files.atomic_write import write_outputs
    from reports.files.write_run import check_places, json_bytes
    from reports.html.cleaning_page import comparison_page
    from reports.tables import comparison
    from reports.terminal.console import open_console, print_card, print_files

    check_places((board, one, other, parameters, parts), {"a page": html, "a report": data})
    subjects = (_read(one), _read(other))
    (here, cleaned), (there, cleaned_there) = _analyse_both(
        (board, parts), subjects, parameters, effort, sensitivity=data is not None
    )
    rows = comparison.compare_cleaning(cleaned, cleaned_there)
    if here.run is None or there.run is None:
        rows += comparison.compare_programs(here.program, there.program)
    else:
        rows += comparison.compare(here.run, there.run)
    names = subjects[0].name, subjects[1].name
    if names[0] == names[1]:
        names = one, other
    reports = cleaned, cleaned_there
    write_outputs({
        html: None if html is None else comparison_page(rows, reports, names),
        data: None if data is None else json_bytes(comparison.comparison_data(rows, *reports)),
    })  # fmt: skip
    console = open_console()
    print_card(console, comparison_card(rows, cleaned, names))
    print_files(console, html=html, data=data)


@dataclass(frozen=True, slots=True, eq=False)
class _Subject:
    """What is compared, as it was read."""

    source: str
    recipe: "Recipe"
    program: "TimedProgram | None"
    """``None`` where the recipe is to be planned."""

    @property
    def name(self) -> str:
        """Of a recipe its own, of a program that of its file."""
        return self.recipe.recipe if self.program is None else Path(self.source).name


@dataclass(frozen=True, slots=True, eq=False)
class _Planned:
    """A program on the board."""

    recipe: "Recipe"
    program: "TimedProgram"
    run: "Run | None"
    """``None`` where it was not planned here."""


def _read(source: str) -> _Subject:
    """Read a recipe, or a program with its recipe.

    Raises:
        JobError: it cannot be used.
    """
    from programs.load import load_program
    from recipes.load import load_recipe
    from washboard.inputs import find_recipe

    file = Path(source)
    if file.suffix.lower() != _PROGRAM:
        return _Subject(source, load_recipe(source), None)
    program = load_program(file)
    return _Subject(source, find_recipe(program, file, "Put it beside the program, or plan the board again."), program)


def _analyse_both(
    source: tuple[str, Path | None],
    subjects: tuple[_Subject, _Subject],
    parameters: str,
    effort: Effort,
    *,
    sensitivity: bool,
) -> "list[tuple[_Planned, CleaningReport]]":
    """Plan recipes and analyse both subjects, on a board that is prepared once.

    Only the report states what limits each part, by ``sensitivity``.

    Raises:
        JobError: something cannot be used.
    """
    from boards.workpiece import load_workpiece
    from cleaning.analyse import analyse_on
    from cleaning.parameters.load import load_parameters
    from cleaning.prepared_board import prepare
    from commandline.loading import progress_bar
    from specs.progress import subprogress

    known = load_parameters(parameters)
    with progress_bar() as progress:
        opened = load_workpiece(source[0], source[1], subprogress(progress, 0.0, 0.1))
        board = opened.require_board("compare")
        planned = [
            _plan(each, board, subprogress(progress, 0.1 * index, 0.1 * index + 0.1))
            for index, each in enumerate(subjects, start=1)
        ]
        prepared = prepare(board, known, subprogress(progress, 0.3, 0.4))
        spans = (subprogress(progress, 0.4, 0.7), subprogress(progress, 0.7, 1.0))
        return [
            (each, analyse_on(prepared, each.program, each.recipe, effort, span, sensitivity=sensitivity))
            for each, span in zip(planned, spans, strict=True)
        ]


def _plan(subject: _Subject, board: "Board", progress: "Progress") -> _Planned:
    """Plan a recipe; a program is there already.

    Raises:
        JobError: the recipe cannot be planned, or the program was made for another board.
    """
    from rulesengine.planning.pipeline import run
    from washboard.inputs import require_workpiece

    if subject.program is not None:
        require_workpiece(subject.program, Path(subject.source), board, exactly=True)
        return _Planned(subject.recipe, subject.program, None)
    planned = run(subject.recipe, board, progress)
    return _Planned(planned.recipe, planned.program, planned)
