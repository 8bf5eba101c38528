"""``washboard part``: read parts and look at their faces."""

from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from commandline.arguments import Picture, input_argument, input_option, output_option
from commandline.nouns.tri_output import check_tri_name, tri_content
from specs.output_file import OutputFile

app = typer.Typer(help="Read a part, look at its faces and what can be seen of them.", no_args_is_help=True)


@app.command("show")
def show(
    part: Annotated[
        str,
        input_argument(
            "PART", "Part file (YAML), .tri with role=part, STEP, GLB, STL, OBJ, PLY, or the name of a library part."
        ),
    ],
    recipe: Annotated[
        str, input_option("--recipe", "RECIPE", "Recipe whose nozzle, standoff and tilt decide what can be seen.")
    ] = "part-degrease",
    picture: Picture = None,
) -> None:
    """Print the part's card: faces, areas, the share that any free pose of the nozzle sees, what hides the rest.

    [dim]washboard part show f-bracket --picture f-bracket.png[/dim]
    """
    from boards.workpiece import load_workpiece
    from commandline.loading import finish, progress_bar
    from recipes.load import load_recipe
    from reports.cards.workpiece import part_card
    from reports.pictures.part_picture import draw_part
    from rulesengine.surface.part_job import survey_part
    from specs.progress import subprogress

    loaded_recipe = load_recipe(recipe)
    with progress_bar() as progress:
        loaded = load_workpiece(part, None, subprogress(progress, 0.0, 0.2), over_faces=True).require_part("part show")
        survey = survey_part(loaded_recipe, loaded, subprogress(progress, 0.2, 1.0))
    card = part_card(loaded, survey, loaded_recipe.recipe)
    finish(card, picture=(picture, partial(draw_part, loaded, survey)))


@app.command("import")
def import_(
    part: Annotated[str, input_argument("PART", "Part file or mesh.")],
    output: Annotated[
        OutputFile, output_option("--output -o", "Y.tri", "Canonical text to write; .tri.gz compresses it.")
    ],
) -> None:
    """Write a part with its fixtures and faces as one .tri file, which every command reads in place of its sources.

    [dim]washboard part import bracket.yaml -o bracket.tri[/dim]
    """
    from boards.workpiece import load_workpiece
    from commandline.loading import finish, progress_bar
    from reports.tables.table import Card, FindingList

    check_tri_name(output, "part texts")
    with progress_bar() as progress:
        loaded = load_workpiece(part, None, progress, over_faces=True).require_part("part import")
    finish(Card("", (FindingList(loaded.findings),)), part=(output, tri_content(output, loaded.bodies)))


@app.command("scan")
def scan(
    front: Annotated[Path, input_argument("FRONT.png", "Silhouette from the front, PNG or PGM.")],
    side: Annotated[Path, input_argument("SIDE.png", "Silhouette from the right, PNG or PGM.")],
    mm_per_pixel: Annotated[
        float, typer.Option("--mm-per-pixel", help="Scale of the pictures at the part.", metavar="MM")
    ],
    output: Annotated[OutputFile, output_option("--output -o", "Y.tri", "Part text to write; .tri.gz compresses it.")],
    side_mm_per_pixel: Annotated[
        float | None,
        typer.Option("--side-mm-per-pixel", help="Scale of the side view, if it is another.", metavar="MM"),
    ] = None,
    symmetry: Annotated[
        Literal["revolution", "extrusion", "mirror"] | None,
        typer.Option(
            "--symmetry",
            help="What the part is: a body of revolution about the upright axis; an extrusion along a view; "
            "its own mirror image in both middle planes, with rectangular sections. Without it the hull of both views.",
        ),
    ] = None,
    threshold: Annotated[
        float | None,
        typer.Option(
            "--threshold",
            help="Grey at the outline, from the darker of part and ground (0) to the brighter (1); left out, half way, "
            "or below a shadow.",
            metavar="T",
        ),
    ] = None,
    picture: Picture = None,
) -> None:
    """Make a part of two silhouettes at right angles, where no CAD is at hand. Other commands take it as any part.

    [dim]washboard part scan front.png side.png --mm-per-pixel 0.25 --symmetry revolution -o dome.tri[/dim]
    """
    from boards.load import name_of
    from boards.part.scan import scan_part
    from boards.part.silhouette import read_silhouette
    from commandline.loading import finish
    from reports.cards.workpiece import scan_card
    from reports.pictures.part_picture import draw_scan

    check_tri_name(output, "part texts")
    views = (
        read_silhouette(front, mm_per_pixel, threshold),
        read_silhouette(side, mm_per_pixel if side_mm_per_pixel is None else side_mm_per_pixel, threshold),
    )
    found = scan_part(name_of(output.path), *views, symmetry)
    finish(
        scan_card(found),
        part=(output, tri_content(output, found.part.bodies)),
        picture=(picture, partial(draw_scan, found, views)),
    )


@app.command("list")
def list_parts() -> None:
    """List the parts of the library."""
    from boards.part.sources import part_library

    for name in part_library():
        typer.echo(name)
