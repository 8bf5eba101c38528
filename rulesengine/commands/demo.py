"""``washboard demo``: the sample board and recipe through all of it."""

from pathlib import Path
from typing import Annotated

import typer

from rulesengine.commands.arguments import complete_board, complete_recipe
from rulesengine.errors import job_errors


def demo(
    folder: Annotated[Path, typer.Option("--into", help="Folder to write into.", metavar="DIR")] = Path(
        "washboard-demo"
    ),
    board: Annotated[
        str,
        typer.Option("--board", help="Another board than the sample.", metavar="BOARD", autocompletion=complete_board),
    ] = "smt-demo",
    recipe: Annotated[
        str,
        typer.Option(
            "--recipe", help="Another recipe than the default.", metavar="RECIPE", autocompletion=complete_recipe
        ),
    ] = "smt-aqueous",
) -> None:
    """Plan the sample board with the default recipe; write program, report and pictures.

    [dim]washboard demo
    washboard demo --into /tmp/demo --board tiny[/dim]
    """
    with job_errors():
        from rulesengine.commands.loading import read_and_run
        from rulesengine.commands.terminal import open_console, print_files
        from rulesengine.commands.writing import check_folder, write_run
        from rulesengine.output import OutputError, write_bytes_atomically
        from rulesengine.picture import draw_board
        from rulesengine.summary import print_run

        check_folder(folder)
        done = read_and_run(board, recipe, None)
        card = draw_board(done.board, ".png")
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(folder, error.strerror or str(error)) from None
        program, report, paths, picture = (
            folder / f"{done.board.name}{end}" for end in (".wash", ".json", "-paths.png", "-board.png")
        )
        write_run(done, output=program, picture=paths, report_file=report, allowed=[])
        write_bytes_atomically(picture, card)
        console = open_console()
        print_run(console, done)
        print_files(console, program=program, report=report, paths=paths, board=picture)
