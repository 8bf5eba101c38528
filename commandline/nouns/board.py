"""``washboard board``: read boards from CAD and look at them."""

from functools import partial
from typing import Annotated

import typer

from commandline.arguments import BoardSource, Parts, Picture, output_option
from commandline.nouns.tri_output import check_tri_name, tri_content
from specs.output_file import OutputFile

app = typer.Typer(help="Read a board from CAD, look at what was understood.", no_args_is_help=True)
_ROWS = 40


@app.command("import")
def import_(
    source: BoardSource,
    output: Annotated[OutputFile, output_option("--output -o", "Y.tri", "Board file to write; .tri.gz compresses it.")],
    parts: Parts = None,
) -> None:
    """Turn CAD into a board file: STEP, GLB, glTF, STL, OBJ, PLY, IDF, KiCad, Eagle, IPC-2581, ODB++, Gerber or .tri.

    [dim]washboard board import board.step -o board.tri --parts placement.csv[/dim]
    """
    from boards.workpiece import load_workpiece
    from commandline.loading import finish, progress_bar
    from reports.cards.workpiece import board_card

    check_tri_name(output, "board files")
    with progress_bar() as progress:
        board = load_workpiece(source, parts, progress).require_board("board import")
    finish(board_card(board, rows=0), board=(output, tri_content(output, board.bodies)))


@app.command()
def show(
    source: BoardSource,
    parts: Parts = None,
    picture: Picture = None,
    all_: Annotated[bool, typer.Option("--all", help="List every component.")] = False,
) -> None:
    """Print the board's card: surfaces, outline, components, standoffs, findings.

    [dim]washboard board show smt-demo --picture smt-demo.png[/dim]
    """
    from boards.workpiece import load_workpiece
    from commandline.loading import finish, progress_bar
    from reports.cards.workpiece import board_card
    from reports.pictures.board_picture import draw_board

    with progress_bar() as progress:
        board = load_workpiece(source, parts, progress).require_board("board show")
    finish(board_card(board, rows=None if all_ else _ROWS), picture=(picture, partial(draw_board, board)))


@app.command("list")
def list_() -> None:
    """List the sample boards."""
    from boards.load import board_library

    for name in board_library():
        typer.echo(name)
