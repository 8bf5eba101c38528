"""``washboard cell place``: where in a cell the board is held best for a program."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from commandline.arguments import CellSource, MadeFor, Parts
from commandline.errors import job_errors

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell
    from robotcell.placement.reachability import Metric

_REFUSED = 1
"""Exit code where no place was found at which the robot can do the program."""
_METRICS: "dict[str, Metric]" = {
    "w": "manipulability",
    "condition": "condition",
    "limits": "limits",
    "clearance": "clearance",
}


def place(
    program: Annotated[Path, typer.Argument(help="Native program.", metavar="PROGRAM.wash")],
    cell: CellSource,
    board: MadeFor = None,
    parts: Parts = None,
    metric: Annotated[
        Literal["w", "condition", "limits", "clearance"],
        typer.Option(
            "--metric",
            help="What is to be great: manipulability, inverse condition, distance from the joints' limits, or from "
            "board and fixtures.",
        ),
    ] = "w",
    of: Annotated[
        Literal["least", "mean"], typer.Option("--of", help="Of the worst point, or of all on average.")
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
        from commandline.loading import progress_bar, read_board_of
        from programs.load import load_program
        from reports.files.atomic_write import write_text_atomically
        from reports.files.write_run import check_apart
        from reports.terminal.console import open_console
        from reports.terminal.place_report import print_relocation
        from robotcell.cell.load import CELL, read_cell_text
        from robotcell.placement.optimise import PlacementGoal
        from robotcell.search_placement import find_place, place_of, with_place
        from specs.yaml.load import find_file, read_text

        check_apart((program, board, parts), [] if output is None else [output])
        file = find_file(cell, CELL)
        text = read_text(file, CELL)
        loaded, asked = read_cell_text(text, file=file), load_program(program)
        if output is not None:
            _check_there(text, loaded, output)
        made_for = read_board_of(asked, program, board, parts)
        goal = PlacementGoal(_METRICS[metric], of, height=(-1e-3 * lift, 1e-3 * lift))
        with progress_bar() as progress:
            found = find_place(asked, loaded, made_for, goal, progress)
        best = found.best
        if output is not None and (best is not None or not found.present.stopped_by):
            moved = text if best is None else with_place(text, place_of(best.placement.T_cell_board), file)
            write_text_atomically(output, moved)
        console = open_console()
        print_relocation(console, found, goal)
        if best is None and found.present.stopped_by:
            raise typer.Exit(_REFUSED)
        if output is not None:
            console.print(f"Written  {output}", markup=False, soft_wrap=True)


def _check_there(text: str, loaded: "LoadedCell", output: Path) -> None:
    """Refuse what could not be read at another place, before the long work begins.

    Raises:
        CellError: the cell names files that are not there beside the output, or ``board`` cannot be changed.
    """
    from robotcell.cell.load import read_cell_text
    from robotcell.errors import CellError
    from robotcell.search_placement import place_of, with_place

    file = Path(loaded.root.mark.file)
    moved = with_place(text, place_of(loaded.cell.T_cell_board), file)
    try:
        read_cell_text(moved, file=output)
    except CellError as error:
        raise CellError(f"{error}. The cell names files beside its own: write the new one into {file.parent}") from None
