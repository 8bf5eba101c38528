"""``washboard level`` and ``spacing``: speeds along passes and spacings of them that lay a film."""

from functools import partial
from typing import Annotated, Literal, TypeAlias

import typer

from commandline.arguments import BoardSource, Parts, Picture, ProgramOutput, RecipeSource

FilmGoal: TypeAlias = Literal["least-time", "even-film"]


def level(
    board: BoardSource,
    recipe: RecipeSource = "smt-aqueous",
    goal: Annotated[
        FilmGoal | None,
        typer.Option(
            "--for",
            help="least-time: the film is kept wherever it is now, as by default on boards; even-film: least deviation "
            "from the film, as on parts.",
        ),
    ] = None,
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

    Of a part: how even the films of its recipe become, and the program that lays them.

    [dim]washboard level smt-demo smt-aqueous -o levelled.wash
    washboard level my-board.tri coat.yaml --for even-film --film-um 40 -o coat.wash
    washboard level hood.stl coat.yaml -o hood.wash[/dim]
    """
    from commandline.loading import finish, progress_bar
    from reports.cards.recipe_search import levelled_card
    from reports.files.write_run import write_run
    from reports.tables.table import Card, Text
    from washboard.planned import level as level_films

    with progress_bar() as progress:
        levelled, report = level_films(board, recipe, goal, film_um, progress, parts=parts)
    write_run(levelled.run, output=output, picture=None, report_file=None, allowed=())
    unwritten = [] if output else [Card("", (Text("No program was written; -o OUT.wash writes it.", "quiet"),))]
    finish(levelled_card(report), *unwritten, program=output)


def spacing(
    recipe: RecipeSource,
    nozzle: Annotated[str, typer.Argument(help="Nozzle of the recipe.", metavar="NOZZLE")],
    film_um: Annotated[
        float, typer.Option("--film-um", help="Film to lay, µm of liquid.", min=0.001, max=1e6, metavar="UM")
    ],
    height_mm: Annotated[
        float | None,
        typer.Option(
            "--height-mm",
            help="Orifice above the surface; left out, that of the measured pattern of a radial nozzle.",
            min=0.1,
            max=1000.0,
            metavar="MM",
        ),
    ] = None,
    max_speed_mm_s: Annotated[
        float | None,
        typer.Option(
            "--max-speed-mm-s",
            help="Left out, the maximum of the functions that spray with the nozzle.",
            min=0.01,
            max=10_000.0,
            metavar="MM_S",
        ),
    ] = None,
    picture: Picture = None,
) -> None:
    """Find every spacing of parallel passes at which their film is even, and the speed that lays it.

    [dim]washboard spacing coat.yaml gun --film-um 40 --picture spacing.png
    washboard spacing smt-aqueous ring60 --film-um 500 --height-mm 50[/dim]
    """
    from commandline.loading import finish
    from recipes.load import load_recipe
    from reports.cards.recipe_search import spacings_card
    from reports.pictures.charts import draw_spacings
    from rulesengine.levelling.pass_spacing import find_pass_spacings

    table = find_pass_spacings(load_recipe(recipe), nozzle, film_um, height_mm, max_speed_mm_s)
    finish(spacings_card(table), picture=(picture, partial(draw_spacings, table)))
