"""``washboard spacing``: spacings of parallel passes that lay an even film."""

from functools import partial
from typing import Annotated

import typer

from commandline.arguments import Picture, RecipeSource


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
