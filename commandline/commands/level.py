"""``washboard level``: speeds along passes that lay a film in the least time, or evenly."""

from typing import Annotated, Literal, TypeAlias

import typer

from commandline.arguments import BoardSource, Parts, ProgramOutput, RecipeSource

FilmGoal: TypeAlias = Literal["least-time", "even-film"]


def level(
    board: BoardSource,
    recipe: RecipeSource = "smt-aqueous",
    goal: Annotated[
        FilmGoal,
        typer.Option(
            "--for",
            help="least-time: the film is kept wherever it is now; even-film: least deviation from the film.",
        ),
    ] = "least-time",
    film_um: Annotated[
        float | None,
        typer.Option(
            "--film-um",
            help="Film, µm of liquid; left out, what each surface has now, or for even-film the mean.",
            min=0.001,
            max=1e6,
            metavar="UM",
        ),
    ] = None,
    output: ProgramOutput = None,
    parts: Parts = None,
) -> None:
    """Level the speeds along rasters and flushes: the same film in the least time, or an even film.

    [dim]washboard level smt-demo smt-aqueous -o levelled.wash
    washboard level my-board.tri coat.yaml --for even-film --film-um 40 -o coat.wash[/dim]
    """
    from dataclasses import replace

    from commandline.loading import finish, progress_bar
    from reports.cards.recipe_search import levelled_card
    from reports.files.write_run import write_run
    from reports.tables.table import Card, Text
    from rulesengine.levelling.level_plan import level_plan
    from rulesengine.timing.time_plan import time_plan
    from specs.progress import subprogress
    from washboard.inputs import open_recipe, open_workpiece
    from washboard.planned import plan

    with progress_bar() as progress:
        opened = open_recipe(recipe)
        surface = open_workpiece(board, opened, parts, subprogress(progress, 0.0, 0.1)).require_board("level")
        done = plan(surface, opened, None, subprogress(progress, 0.1, 0.2)).run
        levelled_plan, report = level_plan(
            done.plan, surface, done.fitted, goal, film_um, subprogress(progress, 0.2, 1.0)
        )
    program = time_plan(levelled_plan, done.fitted.limits)
    levelled = replace(done, plan=levelled_plan, program=program)
    write_run(levelled, output=output, picture=None, report_file=None, allowed=())
    unwritten = [] if output else [Card("", (Text("No program was written; -o OUT.wash writes it.", "quiet"),))]
    finish(levelled_card(report), *unwritten, program=output)
