"""``washboard compare``: two recipes on the same board."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rulesengine.commands.analyse import Effort, EffortOption, ParametersOption
from rulesengine.commands.arguments import BoardSource, Parts, RecipeSource
from rulesengine.errors import job_errors

if TYPE_CHECKING:
    from cleaning.results import CleaningReport
    from rulesengine.comparison import Row
    from rulesengine.pipeline import Run


def compare(
    board: BoardSource,
    recipe: RecipeSource,
    other: RecipeSource,
    parameters: ParametersOption = "default",
    parts: Parts = None,
    html: Annotated[Path | None, typer.Option("--html", help="Both side by side, to print.", metavar="HTML")] = None,
    data: Annotated[Path | None, typer.Option("--json", help="The same as data.", metavar="JSON")] = None,
    effort: EffortOption = "fast",
) -> None:
    """Plan a board with two recipes and predict what each cleans: time, litres, strokes, and verdicts that differ.

    [dim]washboard compare smt-demo smt-aqueous low-standoff
    washboard compare board.step mine.yaml thine.yaml --html both.html[/dim]
    """
    with job_errors():
        from rulesengine.commands.cleaning_card import print_comparison
        from rulesengine.commands.terminal import open_console, print_files
        from rulesengine.commands.writing import check_apart
        from rulesengine.comparison import compare as rows_of
        from rulesengine.comparison import compare_cleaning

        written = [path for path in (html, data) if path is not None]
        check_apart((board, recipe, other, parameters, parts), written)
        _refuse_programs(recipe, other)
        (one, here), (two, there) = _carry_out((board, parts), (recipe, other), parameters, effort)
        rows = [*compare_cleaning(here, there), *rows_of(one, two)]
        _write(rows, (here, there), html, data)
        console = open_console()
        print_comparison(console, rows, here.origin.recipe, there.origin.recipe)
        print_files(console, html=html, data=data)


def _refuse_programs(*recipes: str) -> None:
    """Say of a program in a recipe's place what to do instead.

    Raises:
        RecipeError: one of them is the file of a program.
    """
    from recipes.errors import RecipeError

    for each in recipes:
        if Path(each).suffix.lower() == ".wash":
            raise RecipeError(
                "this is a program; two recipes are compared, which are planned on the board. Name the recipe that it "
                f"was made with, or look at each program by itself: washboard analyse {each}.",
                file=each,
            )


def _carry_out(
    source: tuple[str, Path | None], recipes: tuple[str, str], parameters: str, effort: Effort
) -> "tuple[tuple[Run, CleaningReport], tuple[Run, CleaningReport]]":
    """Plan and analyse both, on a board that is made ready once.

    Raises:
        JobError: something cannot be used.
    """
    from boards.load import load_board
    from cleaning.analyse import analyse_on
    from cleaning.load import load_parameters
    from cleaning.subject import prepare
    from geometry.progress import part_of
    from recipes.load import load_recipe
    from rulesengine.commands.loading import progress_bar
    from rulesengine.pipeline import run

    first, second = (load_recipe(each) for each in recipes)
    known = load_parameters(parameters)
    with progress_bar() as tell:
        board = load_board(Path(source[0]), source[1], part_of(tell, 0.0, 0.1))
        planned = (run(first, board, part_of(tell, 0.1, 0.2)), run(second, board, part_of(tell, 0.2, 0.3)))
        subject = prepare(board, known, part_of(tell, 0.3, 0.4))

        def done(each: "Run", begin: float) -> "tuple[Run, CleaningReport]":
            told = part_of(tell, begin, begin + 0.3)
            return each, analyse_on(subject, each.program, each.recipe, effort, told)

        return done(planned[0], 0.4), done(planned[1], 0.7)


def _write(
    rows: "list[Row]", reports: "tuple[CleaningReport, CleaningReport]", html: Path | None, data: Path | None
) -> None:
    """Render everything, then write it."""
    from rulesengine.output import write_text_atomically

    here, there = reports
    contents: list[tuple[Path, str]] = []
    if html is not None:
        from rulesengine.comparison_page import comparison_page

        contents.append((html, comparison_page(rows, here, there)))
    if data is not None:
        from rulesengine.comparison import comparison_data

        text = json.dumps(comparison_data(rows, here, there), indent=2, ensure_ascii=False, allow_nan=False)
        contents.append((data, text + "\n"))
    for path, text in contents:
        write_text_atomically(path, text)
