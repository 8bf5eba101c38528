"""``washboard demo``: the sample board and recipe through all of it."""

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rulesengine.commands.arguments import complete_board, complete_cell, complete_recipe
from rulesengine.errors import job_errors

if TYPE_CHECKING:
    from robotcell.load import LoadedCell
    from rulesengine.pipeline import Run


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
        from programs.export import find_dialect
        from robotcell.load import read_cell
        from rulesengine.commands.demo_cleaning import clean_for_demo
        from rulesengine.commands.loading import read_and_run
        from rulesengine.commands.terminal import open_console, print_files
        from rulesengine.commands.writing import check_folder, write_run
        from rulesengine.output import OutputError, write_bytes_atomically
        from rulesengine.picture import draw_board
        from rulesengine.summary import print_run

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
    from rulesengine.commands.cell_report import print_cell_report
    from rulesengine.commands.loading import progress_bar
    from rulesengine.commands.terminal import open_console, print_files
    from rulesengine.exporting import export_in_cell
    from rulesengine.folder import write_files
    from rulesengine.joint_picture import draw_joints
    from rulesengine.output import write_bytes_atomically
    from rulesengine.report import blocking

    console = open_console()
    if find_spec("coal") is None:
        console.print("Robot    not checked: `pip install washboard[robot]` adds what that takes.", markup=False)
        return
    with progress_bar() as tell:
        exported = export_in_cell(run.program, lies_in, dialect, run.board, tell)
    print_cell_report(console, exported.report)
    if blocking(exported.findings, []) or not exported.report.possible:
        return
    joints = folder / f"{run.board.name}-joints.png"
    write_bytes_atomically(joints, draw_joints(exported.report, joints.suffix))
    files = exported.exported.files
    place = folder / (f"{run.board.name}-{dialect}" if len(files) > 1 else next(iter(files)))
    write_files(place, files)
    print_files(console, joints=joints, robot=place)
