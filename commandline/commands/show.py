"""``washboard show``: a program read back."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import Parts, Picture, complete_board
from commandline.errors import job_errors

if TYPE_CHECKING:
    from boards.board import Board
    from programs.program import TimedProgram


def show(
    program: Annotated[Path, typer.Argument(help="Native program.", metavar="OUT.wash")],
    picture: Picture = None,
    board: Annotated[
        str | None,
        typer.Option(
            "--board",
            help="Board the program was made for: file, or name of a sample. Needed for a picture, unless it is a "
            "sample; without a picture it is only compared.",
            metavar="BOARD",
            autocompletion=complete_board,
        ),
    ] = None,
    parts: Parts = None,
) -> None:
    """Read a program back and say what it does: functions, totals, room it needs, commands to the cell.

    [dim]washboard show demo.wash
    washboard show demo.wash --board smt-demo --picture demo.png[/dim]
    """
    with job_errors():
        from programs.load import load_program
        from reports.files.write_run import check_places
        from reports.tables.summary import print_commands, print_program, print_room
        from reports.terminal.console import open_console, print_files

        check_places(read=(program, board, parts), picture=picture)
        loaded = load_program(program)
        drawn_on = None if picture is None and board is None else _board_of(loaded, program, board, parts)
        if picture is not None and drawn_on is not None:
            from reports.files.atomic_write import write_bytes_atomically
            from reports.pictures.plan_picture import draw_plan

            write_bytes_atomically(picture, draw_plan(drawn_on, loaded, picture.suffix))
        console = open_console()
        print_program(console, loaded)
        print_room(console, loaded)
        print_commands(console, loaded)
        print_files(console, picture=picture)


def _board_of(loaded: "TimedProgram", program: Path, board: str | None, parts: Path | None) -> "Board":
    """Read the board that was named, or the sample that the program names; say so if it is another board.

    Raises:
        ProgramError: no board was named, and the program was not made for a sample.
        BoardError: the board cannot be used.
    """
    from boards.load import board_library
    from commandline.loading import read_board
    from programs.errors import ProgramError

    named = loaded.origin.board
    if board is None and named not in board_library():
        raise ProgramError(f"made for {named}, which is no sample; say with --board where that board is.", file=program)
    found = read_board(board or named, parts)
    if found.sha256 != loaded.origin.board_sha256:
        made_for = f"{named}, sha256 {loaded.origin.board_sha256[:16]}"
        text = (
            f"{found.name}, sha256 {found.sha256[:16]}, is not quite the board this program was made for ({made_for})"
        )
        typer.echo(f"warning: {text}. Plan again if it has changed.", err=True)
    return found
