"""``washboard cell``: look at the robot cells, place a board in one, get the schema."""

from pathlib import Path
from typing import Annotated

import typer

from commandline.arguments import CellSource, complete_board
from commandline.nouns.place import place, require_readable

app = typer.Typer(help="Look at robot cells, place a board in one, get the schema.", no_args_is_help=True)
app.command()(place)


@app.command("list")
def list_cells() -> None:
    """List the cells and the robots that come with Washboard."""
    from commandline.loading import print_library
    from robotcell.cell.load import cell_library, describe_cell
    from robotcell.cell.robot_library import read_robot_file, robot_library

    cells = {name: describe_cell(name) for name in cell_library()}
    robots = {name: read_robot_file(name)[1].description for name in robot_library()}
    width = max(map(len, (*cells, *robots)), default=0)
    for title, entries in (("cells", cells), ("robots", robots)):
        typer.echo(title)
        print_library(entries, "  ", width)


@app.command()
def show(
    source: CellSource,
    board: Annotated[
        str | None,
        typer.Option(
            "--board",
            help="Board to place in the cell; its corners are shown.",
            metavar="BOARD",
            autocompletion=complete_board,
        ),
    ] = None,
) -> None:
    """Show a cell: joints and limits, where its frames lie, tools, fixtures, channels; then what is probably a mistake.

    [dim]washboard cell show ur5e-bench --board smt-demo[/dim]
    """
    from boards.workpiece import load_workpiece
    from commandline.loading import progress_bar
    from reports.cards.robot import cell_card
    from reports.terminal.console import open_console, print_card, print_findings
    from robotcell.cell.load import hold_board, read_cell
    from robotcell.diagnosis.plausibility import check_cell, frame_card

    with progress_bar() as progress:
        placed = None if board is None else load_workpiece(board, None, progress)
    loaded = hold_board(read_cell(source), placed)
    console = open_console()
    print_card(console, cell_card(loaded, frame_card(loaded.cell, placed)))
    print_findings(console, check_cell(loaded.cell, placed, loaded.spec.io))


@app.command()
def edit(
    cell: CellSource,
    edits: Annotated[
        list[str],
        typer.Argument(
            help="A key with its new value, as a check gives its remedy: 'tools.1.tcp.xyz_mm: [0, 0, 300]'.",
            metavar="'KEY: VALUE'...",
        ),
    ],
    output: Annotated[
        Path,
        typer.Option("--output", "-o", help="Cell with these values; all else as it was.", metavar="OUT.yaml"),
    ],
) -> None:
    """Write values into a cell, such as the remedy of a check; comments stay, and the result is read before.

    [dim]washboard cell edit ur5e-bench 'board.pose: {xyz_mm: [420, -50, 150]}' -o my-cell.yaml[/dim]
    """
    from commandline.loading import finish
    from reports.files.write_run import check_apart
    from robotcell.cell.cell_edits import apply_edits, describe_edits, parse_edit
    from robotcell.cell.load import CELL
    from specs.errors import printable
    from specs.yaml.load import find_file, read_text
    from specs.yaml.located import read_yaml

    check_apart((), [output])
    file = find_file(cell, CELL)
    text = read_text(file, CELL)
    root = read_yaml(text, file, CELL)
    parsed = [parse_edit(each, root) for each in edits]
    edited = apply_edits(text, parsed, file)
    require_readable(edited, file, output)
    lines = (f"{printable(line)}\n" for line in describe_edits(root, parsed))
    finish(*lines, written=(output, edited))


@app.command()
def schema() -> None:
    """Print the JSON schema; an editor that knows it completes keys and marks mistakes.

    [dim]washboard cell schema > cell.schema.json[/dim]
    """
    from robotcell.cell.load import cell_schema

    typer.echo(cell_schema().encode(), nl=False)  # UTF-8 whatever encoding the terminal has


@app.command()
def keys() -> None:
    """Print every key of a cell with its default and meaning, as Markdown."""
    from robotcell.cell.load import cell_keys

    typer.echo(cell_keys().encode(), nl=False)
