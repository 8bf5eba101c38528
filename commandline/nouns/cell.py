"""``washboard cell``: look at the robot cells, place a board in one, get the schema."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from commandline.arguments import CellSource, Parts, ProgramBoard, ProgramSource, complete_board
from commandline.errors import job_errors

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell
    from robotcell.placement.reachability import Metric

app = typer.Typer(help="Look at robot cells, place a board in one, get the schema.", no_args_is_help=True)
_REFUSED = 1
"""Exit code where no place was found at which the robot can do the program."""
_METRICS: "dict[str, Metric]" = {
    "w": "manipulability",
    "condition": "condition",
    "limits": "limits",
    "clearance": "clearance",
}


@app.command("list")
def list_cells() -> None:
    """List the cells and the robots that come with Washboard."""
    with job_errors():
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
    with job_errors():
        from commandline.loading import read_board
        from reports.terminal.cell_card import print_cell
        from reports.terminal.console import open_console, print_findings
        from robotcell.cell.hold import hold_board
        from robotcell.cell.load import read_cell
        from robotcell.diagnosis.frame_table import frame_card
        from robotcell.diagnosis.plausibility import check_cell

        placed = None if board is None else read_board(board, None)
        loaded = hold_board(read_cell(source), placed)
        console = open_console()
        print_cell(console, loaded, frame_card(loaded.cell, placed))
        print_findings(console, check_cell(loaded.cell, placed, loaded.spec.io))


@app.command()
def place(
    program: ProgramSource,
    cell: CellSource,
    board: ProgramBoard = None,
    parts: Parts = None,
    metric: Annotated[
        Literal["w", "condition", "limits", "clearance"],
        typer.Option(
            "--metric",
            help="Measure to maximise: manipulability, inverse condition, distance from the joints' limits, or from "
            "board and fixtures.",
        ),
    ] = "w",
    of: Annotated[
        Literal["least", "mean"], typer.Option("--of", help="Its value at the worst point, or the mean of all points.")
    ] = "least",
    lift: Annotated[
        float,
        typer.Option("--lift", help="How far the board may be moved up or down.", min=0, max=1000, metavar="MM"),
    ] = 0.0,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Cell with the board there; all else as it was.", metavar="OUT.yaml"),
    ] = None,
) -> None:
    """Search where the board is held best: how far from the robot, how turned, how high. The best is then checked.

    Exit code 0: the robot can do the program there. 1: at no place that was checked. 2: the job could not be done.

    [dim]washboard cell place demo.wash ur5e-bench
    washboard cell place demo.wash cell.yaml --metric condition --lift 100 -o moved.yaml[/dim]
    """
    with job_errors():
        from commandline.loading import progress_bar, read_program_board
        from programs.load import load_program
        from reports.files.atomic_write import write_text_atomically
        from reports.files.write_run import check_apart
        from reports.terminal.cell_report import print_relocation
        from reports.terminal.console import open_console, print_files
        from robotcell.cell.cell_edits import with_place
        from robotcell.cell.load import CELL, read_cell_text
        from robotcell.placement.criteria import PlacementGoal
        from robotcell.search_placement import find_place
        from specs.yaml.load import find_file, read_text

        check_apart((program, board, parts), [output])
        file = find_file(cell, CELL)
        text = read_text(file, CELL)
        loaded, planned = read_cell_text(text, file=file), load_program(program)
        if output is not None:
            _check_movable(text, loaded, output)
        placed = read_program_board(planned, program, board, parts)
        goal = PlacementGoal(_METRICS[metric], of, height=(-1e-3 * lift, 1e-3 * lift))
        with progress_bar() as progress:
            found = find_place(planned, loaded, placed, goal, progress)
        best, refused = found.best, found.best is None and bool(found.present.stopped_by)
        if output is not None and not refused:
            moved = text if best is None else with_place(text, best.held_at, file, best.report.cell.held_by)
            write_text_atomically(output, moved)
        console = open_console()
        print_relocation(console, found, goal)
        if refused:
            raise typer.Exit(_REFUSED)
        print_files(console, written=output)


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
    with job_errors():
        from reports.files.atomic_write import write_text_atomically
        from reports.files.write_run import check_apart
        from reports.terminal.console import open_console, print_files
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
        _require_readable(edited, file, output)
        write_text_atomically(output, edited)
        console = open_console()
        for line in describe_edits(root, parsed):
            console.print(printable(line), markup=False, soft_wrap=True)
        print_files(console, written=output)


@app.command()
def schema() -> None:
    """Print the JSON schema; an editor that knows it completes keys and marks mistakes.

    [dim]washboard cell schema > cell.schema.json[/dim]
    """
    with job_errors():
        from robotcell.cell.load import cell_schema

        typer.echo(cell_schema().encode(), nl=False)  # UTF-8 whatever encoding the terminal has


@app.command()
def keys() -> None:
    """Print every key of a cell with its default and meaning, as Markdown."""
    with job_errors():
        from robotcell.cell.load import cell_keys

        typer.echo(cell_keys().encode(), nl=False)


def _check_movable(text: str, loaded: "LoadedCell", output: Path) -> None:
    """Refuse what could not be read at another place, before the long work begins.

    Raises:
        CellError: the cell names files that are not there beside the output, or ``board`` cannot be changed.
    """
    from robotcell.cell.cell_edits import place_of, with_place

    file = Path(loaded.root.mark.file)
    _require_readable(with_place(text, place_of(loaded.cell.held_pose), file, loaded.cell.held_by), file, output)


def _require_readable(text: str, file: Path, output: Path) -> None:
    """Refuse the text of a cell that could not be read where it is to be written.

    Raises:
        CellError: it is wrong, or it names files that are beside ``file`` and not beside the output.
    """
    from robotcell.cell.load import read_cell_text
    from robotcell.errors import CellError

    try:
        read_cell_text(text, file=output)
    except CellError as error:
        if output.absolute().parent == file.absolute().parent:
            raise
        read_cell_text(text, file=file)
        raise CellError(f"{error}. The cell names files beside its own: write the new one into {file.parent}") from None
