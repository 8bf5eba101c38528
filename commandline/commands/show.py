"""``washboard show``: a program read back."""

from typing import Annotated

import typer

from commandline.arguments import Parts, Picture, ProgramSource, complete_board
from commandline.errors import job_errors


def show(
    program: ProgramSource,
    picture: Picture = None,
    board: Annotated[
        str | None,
        typer.Option(
            "--board",
            help="Board of the program: file, or name of a sample. Needed for a picture, unless it is a "
            "sample; without a picture it is only compared.",
            metavar="BOARD",
            autocompletion=complete_board,
        ),
    ] = None,
    parts: Parts = None,
) -> None:
    """Read a program back and print its functions, totals, extent and commands to the cell.

    [dim]washboard show demo.wash
    washboard show demo.wash --board smt-demo --picture demo.png[/dim]
    """
    with job_errors():
        from boards.load import board_library
        from commandline.loading import read_program_board
        from programs.errors import ProgramError
        from programs.load import load_program
        from reports.files.atomic_write import write_bytes_atomically
        from reports.files.write_run import check_places
        from reports.pictures.plan_picture import draw_plan
        from reports.terminal.console import open_console, print_files
        from reports.terminal.program_card import print_commands, print_extent, print_program

        check_places((program, board, parts), {"a picture": picture})
        loaded = load_program(program)
        drawn_on = None
        if picture is not None or board is not None:
            named = board or loaded.origin.board
            if board is None and named not in board_library():
                raise ProgramError(f"made for {named}, which is no sample; name its board with --board.", file=program)
            drawn_on = read_program_board(loaded, program, named, parts)
        if picture is not None and drawn_on is not None:
            write_bytes_atomically(picture, draw_plan(drawn_on, loaded, picture.suffix))
        console = open_console()
        print_program(console, loaded)
        print_extent(console, loaded)
        print_commands(console, loaded)
        print_files(console, picture=picture)
