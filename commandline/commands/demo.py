"""``washboard demo``: the sample board and recipe through all of it."""

from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import complete_board, complete_cell, complete_recipe

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell
    from rulesengine.planning.pipeline import Run


_SAMPLE = "ur5e-bench"
"""Cell in which the demonstration is checked where none is named."""


def demo(
    folder: Annotated[Path, typer.Option("--into", help="Folder to write into.", metavar="DIR")] = Path(
        "washboard-demo"
    ),
    board: Annotated[
        str,
        typer.Option("--board", help="Board; left out, the sample.", metavar="BOARD", autocompletion=complete_board),
    ] = "smt-demo",
    recipe: Annotated[
        str,
        typer.Option(
            "--recipe", help="Recipe; left out, the default.", metavar="RECIPE", autocompletion=complete_recipe
        ),
    ] = "smt-aqueous",
    cell: Annotated[
        str | None,
        typer.Option(
            "--cell",
            help="Cell, for whose robot the program is planned; left out, it is checked in the sample.",
            metavar="CELL",
            autocompletion=complete_cell,
        ),
    ] = None,
    dialect: Annotated[
        str | None, typer.Option("--dialect", help="Language; left out, that of the maker of the cell's robot.")
    ] = None,
) -> None:
    """Plan the sample board, check it in a robot cell, predict what is cleaned; write programs, reports and pictures.

    What is predicted does not change the exit code: 0 means that all of it was done.

    [dim]washboard demo
    washboard demo --into /tmp/demo --board tiny[/dim]
    """
    from commandline.loading import plan_on
    from programs.export import check_maker, find_dialect, own_dialect
    from reports.cards.program import run_card
    from reports.files.atomic_write import output_errors, write_bytes_atomically
    from reports.files.write_run import check_folder, write_run
    from reports.pictures.board_picture import draw_board
    from reports.terminal.console import open_console, print_card, print_files
    from robotcell.cell.installation import installation_of
    from robotcell.cell.load import read_cell

    check_folder(folder)
    loaded_cell = read_cell(cell or _SAMPLE)
    installation = installation_of(loaded_cell)
    language = dialect or own_dialect(installation)
    check_maker(find_dialect(language), installation)
    done = plan_on(board, recipe, None, cell if find_spec("coal") else None).run
    card = draw_board(done.board, ".png")
    with output_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
    program, report, paths, picture = (
        folder / f"{done.board.name}{end}" for end in (".wash", ".json", "-paths.png", "-board.png")
    )
    write_run(done, output=program, picture=paths, report_file=report, allowed=[])
    write_bytes_atomically(picture, card)
    console = open_console()
    print_card(console, run_card(done))
    print_files(console, program=program, report=report, paths=paths, board=picture)
    _export(done, loaded_cell, language, folder)
    _analyse(done, folder)


def _export(run: "Run", cell: "LoadedCell", dialect: str, folder: Path) -> None:
    """Track the program in a cell, and write it in the language of the robot."""
    from commandline.loading import progress_bar
    from programs.export import find_dialect
    from reports.cards.robot import check_card
    from reports.files.atomic_write import write_bytes_atomically
    from reports.files.export_robot import export_in_cell
    from reports.files.robot_files import write_program
    from reports.pictures.joint_picture import draw_joints
    from reports.terminal.console import open_console, print_card, print_files
    from specs.finding import blocking

    console = open_console()
    if find_spec("coal") is None:
        console.print("Robot    not checked: `pip install washboard[robot]` adds what that takes.", markup=False)
        return
    with progress_bar() as progress:
        exported = export_in_cell(run.program, cell, dialect, run.board, progress)
    print_card(console, check_card(exported.report))
    if blocking(exported.findings, []) or not exported.report.possible:
        return
    joints = folder / f"{run.board.name}-joints.png"
    write_bytes_atomically(joints, draw_joints(exported.report, joints.suffix))
    files = exported.exported.files
    several = len(files) > 1
    place = folder / f"{run.board.name}-{dialect}" if several else folder
    written = write_program(place, files, find_dialect(dialect))
    print_files(console, joints=joints, robot=place if several else written[0])


def _analyse(run: "Run", folder: Path) -> None:
    """Predict what the program cleans, with the default parameter set; write the page and its data.

    Raises:
        JobError: it cannot be done, or not be written.
    """
    from cleaning.analyse import analyse
    from cleaning.parameters.load import load_parameters
    from cleaning.report import Traceability
    from commandline.loading import progress_bar
    from reports.cards.cleaning import worst_card
    from reports.files.atomic_write import write_outputs
    from reports.files.write_run import cleaning_bytes
    from reports.html.cleaning_page import cleaning_page
    from reports.tables.cleaning_tables import this_producer
    from reports.terminal.console import open_console, print_card, print_files
    from rulesengine.tuning.suggest import advise

    begun = perf_counter()
    with progress_bar() as progress:
        report = analyse(run.program, run.board, run.recipe, load_parameters(), "fast", progress)
    report = advise(report, run.program, run.recipe)
    seconds = perf_counter() - begun
    page, data = (folder / f"{run.board.name}-cleaning{end}" for end in (".html", ".json"))
    producer = this_producer("fast")
    html = cleaning_page(report, Traceability(), producer=producer)
    write_outputs({page: html, data: cleaning_bytes(report, producer, Traceability())})
    console = open_console()
    print_card(console, worst_card(report, seconds))
    print_files(console, cleaning=page, data=data)
