"""``washboard board``: read boards from CAD and look at them."""

from pathlib import Path
from typing import Annotated

import typer

from rulesengine.errors import job_errors

app = typer.Typer(help="Read a board from CAD, look at what was understood.", no_args_is_help=True)
Source = Annotated[str, typer.Argument(help="Board file, or the name of a sample.")]
Parts = Annotated[
    Path | None, typer.Option("--parts", help="Placement or BOM table (CSV) to join to the board.", metavar="CSV")
]
Picture = Annotated[Path | None, typer.Option("--picture", help="Picture to write.", metavar="PNG|SVG")]


@app.command("import")
def import_(
    source: Source,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Board file to write; .tri.gz compresses it.", metavar="Y.tri")
    ],
    parts: Parts = None,
) -> None:
    """Turn CAD into a board file: STEP, GLB, glTF, STL, OBJ, PLY, IDF, KiCad or .tri.

    [dim]washboard board import board.step -o board.tri --parts placement.csv[/dim]
    """
    with job_errors():
        import gzip

        from rich.console import Console

        from boards.errors import BoardError
        from boards.formats.tri import write_tri
        from rulesengine.commands.loading import read_board
        from rulesengine.output import write_bytes_atomically, write_text_atomically
        from rulesengine.summary import print_board

        if not output.name.endswith((".tri", ".tri.gz")):
            raise BoardError("board files end in .tri or .tri.gz; name the output so.", file=output)
        board = read_board(source, parts)
        text = write_tri(board.bodies)
        if output.suffix == ".gz":
            write_bytes_atomically(output, gzip.compress(text.encode(), mtime=0))
        else:
            write_text_atomically(output, text)
        console = Console()
        print_board(console, board, rows=0)
        console.print(f"Board file: {output}", highlight=False, soft_wrap=True)


@app.command()
def show(
    source: Source,
    parts: Parts = None,
    picture: Picture = None,
    all_: Annotated[bool, typer.Option("--all", help="List every component.")] = False,
) -> None:
    """Print the board's card: surfaces, outline, components, standoffs, findings.

    [dim]washboard board show smt-demo --picture smt-demo.png[/dim]
    """
    with job_errors():
        from rich.console import Console

        from rulesengine.commands.loading import read_board
        from rulesengine.summary import print_board

        board = read_board(source, parts)
        console = Console()
        print_board(console, board, rows=len(board.components) if all_ else 40)
        if picture is not None:
            from rulesengine.output import write_bytes_atomically
            from rulesengine.picture import draw_board

            write_bytes_atomically(picture, draw_board(board, picture.suffix))
            console.print(f"Picture: {picture}", highlight=False, soft_wrap=True)


@app.command("list")
def list_() -> None:
    """List the sample boards."""
    with job_errors():
        from boards.load import board_library

        for name in board_library():
            typer.echo(name)
