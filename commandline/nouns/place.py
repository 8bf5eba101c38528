"""``washboard cell place``: where in a cell a board or part is held best."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from commandline.arguments import CellSource, Parts, ProgramBoard, input_argument, output_option
from specs.output_file import OutputFile

if TYPE_CHECKING:
    from robotcell.cell.cell import TableBounds
    from robotcell.cell.load import LoadedCell
    from robotcell.placement.evaluate import PlacementGoal
    from robotcell.placement.placement_map import MapGrid
    from robotcell.placement.reachability import Metric
    from robotcell.search_placement import Relocation

_REFUSED = 1
"""Exit code where no place was found at which the robot can do the work."""
_METRICS: "dict[str, Metric]" = {
    "w": "manipulability",
    "condition": "condition",
    "limits": "limits",
    "clearance": "clearance",
}
_STANDOFF_MM, _POINTS = 50.0, 200
Bounds = tuple[float, float, float, float]


def place(
    source: Annotated[
        str, input_argument("PROGRAM|PART", "Native program, or a part: a file or a name of the library.")
    ],
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
        Literal["least", "mean", "p5"],
        typer.Option("--of", help="Its value at the worst point, the mean of all points, or the 5th percentile."),
    ] = "least",
    floor: Annotated[
        float, typer.Option("--floor", help="Least value allowed at any point.", min=0, max=1000, metavar="VALUE")
    ] = 0.0,
    lift: Annotated[
        float,
        typer.Option("--lift", help="How far the board may be moved up or down.", min=0, max=1000, metavar="MM"),
    ] = 0.0,
    table: Annotated[
        Bounds | None,
        typer.Option(
            "--table",
            help="Where all of the board has to be, in the cell, mm; it may then be carried around the robot.",
            metavar="X0 X1 Y0 Y1",
        ),
    ] = None,
    configurations: Annotated[
        int, typer.Option("--configurations", help="2: two may share the strokes where one fails.", min=1, max=2)
    ] = 1,
    standoff: Annotated[
        float | None,
        typer.Option(
            "--standoff", help="Of a part: orifice to surface; 50 if left out.", min=0, max=1000, metavar="MM"
        ),
    ] = None,
    points: Annotated[
        int | None,
        typer.Option("--points", help="Of a part: how many points of its surface; 200 if left out.", min=4, max=2000),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", help="Of the search.", min=0, max=2**31 - 1)] = 0,
    mapped: Annotated[
        bool, typer.Option("--map", help="Make a map of 40 x 40 places by 12 turns over the table.")
    ] = False,
    report: Annotated[
        list[OutputFile] | None,
        output_option(
            "--report",
            "FILE",
            "All of it as data (JSON), a page (HTML), a sheet (PNG, SVG) or a scene (GLB, USDZ); may be repeated.",
        ),
    ] = None,
    output: Annotated[
        OutputFile | None,
        output_option("--output -o", "OUT.yaml", "Cell with the board there; all else as it was.", in_place=True),
    ] = None,
) -> None:
    """Search where a board or part is held best: how far from the robot, how turned, how high.

    Of a program the best place is then checked as a whole; of a part targets on its surface are looked at.

    Exit code 0: the robot can do it there. 1: at no place that was checked. 2: the job could not be done.

    [dim]washboard cell place demo.wash ur5e-bench
    washboard cell place demo.wash cell.yaml --metric condition --lift 100 -o moved.yaml
    washboard cell place f-bracket cell.yaml --of p5 --floor 0.02 --map --report place.html --report place.glb[/dim]
    """
    from robotcell.cell.load import CELL, read_cell_text
    from robotcell.placement.evaluate import PlacementGoal
    from robotcell.placement.placement_map import MapGrid, reach_bounds
    from specs.errors import JobError
    from specs.yaml.load import find_file, read_text

    reports = report or []
    for each in reports:
        _check_ending(each.path.suffix)
    file = find_file(cell, CELL)
    text = read_text(file, CELL)
    loaded = read_cell_text(text, file=file)
    if output is not None:
        _check_movable(text, loaded, output.path)
    bounds, both = _table(table), 2 if configurations == 2 else 1
    height = (-1e-3 * lift, 1e-3 * lift)
    goal = PlacementGoal(_METRICS[metric], of, floor, height=height, configurations=both, seed=seed, table=bounds)
    grid = MapGrid(goal.table or reach_bounds(loaded.cell)) if mapped else None
    of_part = _names_part(source)
    foreign = {"--board": board, "--parts": parts} if of_part else {"--standoff": standoff, "--points": points}
    for option, value in foreign.items():
        if value is not None:
            this, other = ("a part", "programs") if of_part else ("a program", "parts")
            raise JobError(f"{option} is for {other}, and {source} is {this}. Leave it out.")
    if of_part:
        surface = (_STANDOFF_MM if standoff is None else standoff, points or _POINTS)
        name, found = _place_part(source, loaded, goal, grid, surface)
    else:
        name, found = _place_program(Path(source), loaded, goal, grid, (board, parts))
    contents = {each: _render(each.path.suffix, name, found) for each in reports}
    _finish(found, (text, file), output, contents)


def _finish(
    found: "Relocation",
    cell: tuple[str, Path],
    output: OutputFile | None,
    contents: dict[OutputFile, str | bytes],
) -> None:
    """Write what was requested and print the files; the cell only where the work can be done."""
    from commandline.loading import finish
    from robotcell.cell.cell_edits import with_place
    from specs.output_file import write_outputs

    text, file = cell
    held = found.moved_to
    if output is not None and not found.refused:
        contents[output] = text if held is None else with_place(text, held, file, found.details.cell.held_by)
    write_outputs({**contents})
    finish(*(each.path for each in contents))
    if found.refused:
        raise typer.Exit(_REFUSED)


def _place_program(
    program: Path,
    loaded: "LoadedCell",
    goal: "PlacementGoal",
    grid: "MapGrid | None",
    named: tuple[str | None, Parts],
) -> "tuple[str, Relocation]":
    from commandline.loading import open_program_workpiece, progress_bar
    from programs.load import load_program
    from reports.cards.placement import relocation_card
    from reports.terminal.console import open_console, print_card
    from robotcell.search_placement import find_place

    planned = load_program(program)
    placed = open_program_workpiece(planned, program, *named)
    with progress_bar() as progress:
        found = find_place(planned, loaded, placed, goal, grid, progress)
    print_card(open_console(), relocation_card(found, goal))
    return planned.origin.board, found


def _place_part(
    source: str,
    loaded: "LoadedCell",
    goal: "PlacementGoal",
    grid: "MapGrid | None",
    surface: tuple[float, int],
) -> "tuple[str, Relocation]":
    from boards.part.load import load_part
    from commandline.loading import progress_bar
    from reports.cards.placement import part_relocation_card
    from reports.terminal.console import open_console, print_card
    from robotcell.placement.reachability import surface_targets
    from robotcell.search_placement import find_place
    from specs.progress import subprogress

    with progress_bar() as progress:
        part = load_part(source, subprogress(progress, 0.0, 0.1))
        targets = surface_targets(part, *surface)
        found = find_place(targets, loaded, part, goal, grid, subprogress(progress, 0.1, 1.0))
    print_card(open_console(), part_relocation_card(part.name, found, surface[0]))
    return part.name, found


def _names_part(source: str) -> bool:
    """Whether a source is a part: by its name in the library, or by the ending of its file."""
    from boards.part.sources import PART_SUFFIXES, is_part_source

    return is_part_source(source) or source.lower().endswith(PART_SUFFIXES)


def _check_ending(suffix: str) -> None:
    """Refuse what ``_render`` cannot write, before the long work begins.

    Raises:
        JobError: the suffix is none of a report, a picture or a scene.
    """
    from reports.pictures.placement_picture import require_usd
    from reports.pictures.sheet import check_suffix

    if suffix.lower() == ".usdz":
        require_usd()
    elif suffix.lower() not in (".json", ".html", ".glb"):
        check_suffix(suffix)


def _render(suffix: str, workpiece: str, found: "Relocation") -> str | bytes:
    """Give the content of a file of a placement; the same search gives the same bytes."""
    from reports.files.write_run import json_bytes
    from reports.html.placement_page import placement_page
    from reports.pictures.placement_picture import draw_placement, placement_glb, placement_usdz
    from robotcell.cell.cell_edits import format_place, place_of
    from robotcell.report import placement_report

    details, mapped = found.details, found.mapped
    match suffix.lower():
        case ".json":
            return json_bytes({"workpiece": workpiece, **placement_report(details, mapped, found.evaluated)})
        case ".html":
            cell = details.cell
            return placement_page(workpiece, details, mapped, format_place(place_of(cell.held_pose), cell.held_by))
        case ".glb":
            return placement_glb(details, found.workpiece, mapped)
        case ".usdz":
            return placement_usdz(details, found.workpiece, mapped)
        case _:
            return draw_placement(details, mapped, suffix)


def _table(bounds: Bounds | None) -> "TableBounds | None":
    """Read the bounds of a table, mm.

    Raises:
        JobError: they enclose nothing.
    """
    from robotcell.cell.cell import TableBounds
    from specs.errors import JobError

    if bounds is None:
        return None
    x0, x1, y0, y1 = (1e-3 * each for each in bounds)
    if not (-100.0 < x0 < x1 < 100.0 and -100.0 < y0 < y1 < 100.0):
        stated = " ".join(f"{each:g}" for each in bounds)
        raise JobError(f"--table {stated}: give the least and the greatest x, then y, in mm, as in -350 350 -850 0.")
    return TableBounds((x0, x1), (y0, y1))


def _check_movable(text: str, loaded: "LoadedCell", output: Path) -> None:
    """Refuse what could not be read at another place, before the long work begins.

    Raises:
        CellError: the cell names files that are not there beside the output, or ``board`` cannot be changed.
    """
    from robotcell.cell.cell_edits import place_of, with_place

    file = Path(loaded.root.mark.file)
    require_readable(with_place(text, place_of(loaded.cell.held_pose), file, loaded.cell.held_by), file, output)


def require_readable(text: str, file: Path, output: Path) -> None:
    """Refuse the text of a cell that could not be read where it is to be written.

    Raises:
        CellError: it is wrong, by the name of the file that is there; or it names files that are beside that and not
            beside the output.
    """
    from robotcell.cell.load import read_cell_text
    from robotcell.errors import CellError
    from specs.yaml.edit import edited_text

    with edited_text(file):
        read_cell_text(text, file=file)
    if output.absolute().parent == file.absolute().parent:
        return
    try:
        with edited_text(output):
            read_cell_text(text, file=output)
    except CellError as error:
        raise CellError(f"{error}. The cell names files beside its own: write the new one into {file.parent}") from None
