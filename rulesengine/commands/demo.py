"""``washboard demo``: the sample board and recipe through all of it."""

from pathlib import Path
from typing import Annotated

import typer

from rulesengine.errors import job_errors


def demo(
    folder: Annotated[Path, typer.Option("--into", help="Folder to write into.", metavar="DIR")] = Path(
        "washboard-demo"
    ),
    board: Annotated[str, typer.Option("--board", help="Another board than the sample.")] = "smt-demo",
    recipe: Annotated[str, typer.Option("--recipe", help="Another recipe than the default.")] = "smt-aqueous",
) -> None:
    """Plan the sample board with the default recipe; write program, report and pictures.

    [dim]washboard demo --into /tmp/demo[/dim]
    """
    with job_errors():
        from rich.console import Console

        from rulesengine.commands.loading import read_and_run
        from rulesengine.commands.writing import write_run
        from rulesengine.output import write_bytes_atomically
        from rulesengine.picture import draw_board
        from rulesengine.summary import print_run

        done = read_and_run(board, recipe, None)
        folder.mkdir(parents=True, exist_ok=True)
        stem = folder / done.board.name
        program, report, paths, card = (
            stem.with_name(stem.name + end) for end in (".wash", ".json", "-paths.png", "-board.png")
        )
        write_run(done, output=program, picture=paths, report_file=report, allowed=[])
        write_bytes_atomically(card, draw_board(done.board, ".png"))
        console = Console()
        print_run(console, done)
        files = {"Program": program, "Report": report, "Paths": paths, "Board": card}
        for name, path in files.items():
            console.print(f"{name}: {path}", highlight=False, soft_wrap=True)
