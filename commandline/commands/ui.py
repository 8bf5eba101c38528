"""``washboard ui``."""

import signal
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from commandline.arguments import NoToken, RecipeSource, input_argument, input_option


def ui(
    board: Annotated[
        str,
        input_argument(
            "BOARD",
            "Board or part: a file, or the name of a sample; left out, the only one of the project folder, else "
            "smt-demo.",
        ),
    ] = "",
    recipe: RecipeSource = "smt-aqueous",
    cell: Annotated[
        str, input_option("--cell", "CELL", "Robot cell at the start: a file, or a name of the library.")
    ] = "",
    folder: Annotated[
        Path, input_option("--folder", "DIR", "Project folder: the page reads and writes nothing outside.")
    ] = Path(),
    host: Annotated[
        str, typer.Option("--host", help="Address to listen on, such as 0.0.0.0 for other machines to reach it.")
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option("--port", help="Port to listen on; the next free one is taken.", min=1, max=65535)
    ] = 8080,
    no_token: NoToken = False,
) -> None:
    """Open the page in which recipes are edited and paths are shown, over a board or a part.

    [dim]washboard ui
    washboard ui board.step my-recipe.yaml --cell ur5e-bench --port 9000
    washboard ui f-bracket part-degrease[/dim]
    """
    from reports.terminal.console import open_console
    from specs.ending import stopped_by_signal
    from webui.access.access import is_loopback
    from webui.page.project import open_project
    from webui.server.server import open_session, serve

    project = open_project(folder)
    console = open_console()
    if not board:
        own = project.own_workpieces()
        board = str(folder / own[0]) if len(own) == 1 else "smt-demo"
        if len(own) > 1:
            console.print(f"{len(own)} boards and parts are in the folder: choose one in the tab Board.")
    session = open_session(board, recipe, cell)
    server = serve(session, project, host, port, needs_token=not no_token)
    with stopped_by_signal() as stop:
        if server.port != port:
            console.print(f"Port {port} is in use.")
        warning = ""
        if not is_loopback(host):
            warning = "The connection is not encrypted, and whoever has this address with its token"
        elif no_token:
            warning = "Every user of this machine"
        if warning:
            warning = f"{warning} can read and write {escape(str(project.folder))}."
            console.print(f"[bold red]{warning}[/bold red]", soft_wrap=True)
        console.print(f"Washboard is at {escape(server.address)} (Ctrl-C ends it)", soft_wrap=True)
        number = stop.wait()
        server.stop()
        console.print("Stopped.")
    if number not in (None, signal.SIGINT):
        raise typer.Exit(128 + number)
