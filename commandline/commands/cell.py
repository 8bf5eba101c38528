"""``washboard cell``: look at the robot cells, place a board in one, get the schema."""

from typing import Annotated

import typer

from commandline.arguments import CellSource, complete_board
from commandline.commands.cell_place import place
from commandline.errors import job_errors

app = typer.Typer(help="Look at robot cells, place a board in one, get the schema.", no_args_is_help=True)


@app.command("list")
def list_cells() -> None:
    """List the cells and the robots that come with Washboard."""
    with job_errors():
        from robotcell.cell.load import cell_library, describe_cell
        from robotcell.cell.robot_library import read_robot_file, robot_library

        cells = {name: describe_cell(name) for name in cell_library()}
        robots = {name: read_robot_file(name)[1].description for name in robot_library()}
        width = max(map(len, (*cells, *robots)), default=0)
        for title, entries in (("cells", cells), ("robots", robots)):
            typer.echo(title)
            for name, description in entries.items():
                typer.echo(f"  {name:<{width}}  {description}")


@app.command()
def show(
    source: CellSource,
    board: Annotated[
        str | None,
        typer.Option(
            "--board", help="Board to lay in; its corners are shown.", metavar="BOARD", autocompletion=complete_board
        ),
    ] = None,
) -> None:
    """Show a cell: joints and limits, where its frames lie, tools, fixtures, channels; then what is probably not meant.

    [dim]washboard cell show ur5e-bench --board smt-demo[/dim]
    """
    with job_errors():
        from commandline.loading import read_board
        from reports.tables.summary import print_findings
        from reports.terminal.cell_card import print_cell
        from reports.terminal.console import open_console
        from robotcell.cell.load import read_cell
        from robotcell.diagnosis.frame_table import frame_card
        from robotcell.diagnosis.plausibility import check_cell

        loaded = read_cell(source)
        laid_in = None if board is None else read_board(board, None)
        console = open_console()
        print_cell(console, loaded, frame_card(loaded.cell, laid_in))
        print_findings(console, check_cell(loaded.cell, laid_in, loaded.spec.io))


app.command()(place)


@app.command()
def schema() -> None:
    """Print the JSON schema; an editor that knows it completes keys and marks mistakes.

    [dim]washboard cell schema > cell.schema.json[/dim]
    """
    with job_errors():
        from robotcell.cell.schema import cell_schema

        typer.echo(cell_schema().encode(), nl=False)  # UTF-8 whatever the terminal speaks


@app.command()
def keys() -> None:
    """Print every key of a cell with its default and meaning, as Markdown."""
    with job_errors():
        from robotcell.cell.schema import cell_keys

        typer.echo(cell_keys().encode(), nl=False)
