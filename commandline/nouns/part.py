"""``washboard part``: read parts and look at their faces."""

from pathlib import Path
from typing import Annotated

import typer

from commandline.arguments import Picture, complete_part, complete_recipe
from commandline.errors import job_errors

app = typer.Typer(help="Read a part, look at its faces and what can be seen of them.", no_args_is_help=True)


@app.command("show")
def show(
    part: Annotated[
        str,
        typer.Argument(
            help="Part file (YAML), .tri with role=part, STEP, GLB, STL, OBJ, PLY, or the name of a library part.",
            metavar="PART",
            autocompletion=complete_part,
        ),
    ],
    recipe: Annotated[
        str,
        typer.Option(
            "--recipe",
            help="Recipe whose nozzle, standoff and tilt decide what can be seen.",
            metavar="RECIPE",
            autocompletion=complete_recipe,
        ),
    ] = "part-degrease",
    picture: Picture = None,
) -> None:
    """Print the part's card: faces, areas, the share that any free pose of the nozzle sees, what hides the rest.

    [dim]washboard part show f-bracket --picture f-bracket.png[/dim]
    """
    with job_errors():
        from boards.part.load import load_part
        from commandline.loading import progress_bar
        from recipes.load import load_recipe
        from reports.files.atomic_write import write_bytes_atomically
        from reports.files.write_run import check_places
        from reports.pictures.part_picture import draw_part
        from reports.terminal.console import open_console, print_files
        from reports.terminal.part_card import print_part
        from rulesengine.surface.plan_part import survey_part
        from specs.progress import subprogress

        check_places((part, recipe), {"a picture": picture})
        loaded_recipe = load_recipe(recipe)
        with progress_bar() as progress:
            loaded = load_part(part, subprogress(progress, 0.0, 0.2))
            survey = survey_part(loaded_recipe, loaded, subprogress(progress, 0.2, 1.0))
        if picture is not None:
            write_bytes_atomically(picture, draw_part(loaded, survey, picture.suffix))
        console = open_console()
        print_part(console, loaded, survey)
        print_files(console, picture=picture)


@app.command("import")
def import_(
    part: Annotated[
        str,
        typer.Argument(help="Part file or mesh.", metavar="PART", autocompletion=complete_part),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Canonical text to write; .tri.gz compresses it.", metavar="Y.tri")
    ],
) -> None:
    """Write a part with its fixtures and faces as one .tri file, which every command reads in place of its sources.

    [dim]washboard part import bracket.yaml -o bracket.tri[/dim]
    """
    with job_errors():
        import gzip

        from boards.errors import BoardError
        from boards.formats.tri.tri import write_tri
        from boards.part.load import load_part
        from commandline.loading import progress_bar
        from reports.files.atomic_write import write_bytes_atomically
        from reports.files.write_run import check_apart
        from reports.terminal.console import open_console, print_files, print_findings

        if not output.name.endswith((".tri", ".tri.gz")):
            raise BoardError("part texts end in .tri or .tri.gz; name the output so.", file=output)
        check_apart((part,), [output])
        with progress_bar() as progress:
            loaded = load_part(part, progress)
        content = write_tri(loaded.bodies).encode("utf-8", errors="replace")
        write_bytes_atomically(output, gzip.compress(content, mtime=0) if output.suffix == ".gz" else content)
        console = open_console()
        print_findings(console, loaded.findings)
        print_files(console, part=output)


@app.command("list")
def list_parts() -> None:
    """List the parts of the library."""
    with job_errors():
        from boards.part.load import part_library

        for name in part_library():
            typer.echo(name)
