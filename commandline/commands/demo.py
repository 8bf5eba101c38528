"""``washboard demo``: the sample board and recipe through all of it."""

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import complete_board, complete_cell, complete_recipe
from commandline.errors import job_errors

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell
    from rulesengine.planning.pipeline import Run


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
    cell: Annotated[
        str,
        typer.Option("--cell", help="Another cell than the sample.", metavar="CELL", autocompletion=complete_cell),
    ] = "ur5e-bench",
    dialect: Annotated[str, typer.Option("--dialect", help="Language of the cell's robot.")] = "ur",
) -> None:
    """Plan the sample board, check it in a robot cell, predict what is cleaned; write programs, reports and pictures.

    What is predicted does not change the exit code: 0 means that all of it was done.

    [dim]washboard demo
    washboard demo --into /tmp/demo --board tiny[/dim]
    """
    with job_errors():
        from commandline.commands.demo_cleaning import clean_for_demo
        from commandline.loading import read_and_run
        from programs.export import find_dialect
        from reports.files.atomic_write import OutputError, write_bytes_atomically
        from reports.files.write_run import check_folder, write_run
        from reports.pictures.plan_picture import draw_board
        from reports.tables.summary import print_run
        from reports.terminal.console import open_console, print_files
        from robotcell.cell.load import read_cell

        check_folder(folder)
        find_dialect(dialect)
        lies_in = read_cell(cell)
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
        _carry_out(done, lies_in, dialect, folder)
        clean_for_demo(done, folder)


def _carry_out(run: "Run", lies_in: "LoadedCell", dialect: str, folder: Path) -> None:
    """Have a robot carry out what was planned, and write its program."""
    from commandline.loading import progress_bar
    from reports.files.atomic_folder import write_files
    from reports.files.atomic_write import write_bytes_atomically
    from reports.files.export_robot import export_in_cell
    from reports.pictures.joint_picture import draw_joints
    from reports.terminal.cell_report import print_cell_report
    from reports.terminal.console import open_console, print_files
    from specs.finding import blocking

    console = open_console()
    if find_spec("coal") is None:
        console.print("Robot    not checked: `pip install washboard[robot]` adds what that takes.", markup=False)
        return
    with progress_bar() as progress:
        exported = export_in_cell(run.program, lies_in, dialect, run.board, progress)
    print_cell_report(console, exported.report)
    if blocking(exported.findings, []) or not exported.report.possible:
        return
    joints = folder / f"{run.board.name}-joints.png"
    write_bytes_atomically(joints, draw_joints(exported.report, joints.suffix))
    files = exported.exported.files
    place = folder / (f"{run.board.name}-{dialect}" if len(files) > 1 else next(iter(files)))
    write_files(place, files)
    print_files(console, joints=joints, robot=place)
