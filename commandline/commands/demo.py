"""``washboard demo``: the sample board and recipe through all of it."""

from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import DialectOption, input_option, output_folder
from specs.output_file import OutputFile, OutputFolder

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell
    from washboard.planned import Planned

_FOLDER = OutputFolder(Path("washboard-demo"))
_SAMPLE = "ur5e-bench"
"""Cell in which the demonstration is checked where none is named."""


def demo(
    into: Annotated[
        OutputFolder, typer.Option("--into", help="Folder to write into.", metavar="DIR", parser=output_folder())
    ] = _FOLDER,
    board: Annotated[str, input_option("--board", "BOARD", "Board; left out, the sample.")] = "smt-demo",
    recipe: Annotated[str, input_option("--recipe", "RECIPE", "Recipe; left out, the default.")] = "smt-aqueous",
    cell: Annotated[
        str | None,
        input_option(
            "--cell", "CELL", "Cell, for whose robot the program is planned; left out, it is checked in the sample."
        ),
    ] = None,
    dialect: DialectOption = None,
) -> None:
    """Plan the sample board, check it in a robot cell, predict what is cleaned; write programs, reports and pictures.

    What is predicted does not change the exit code: 0 means that all of it was done.

    [dim]washboard demo
    washboard demo --into /tmp/demo --board tiny[/dim]
    """
    from commandline.loading import finish, plan_on
    from programs.export import check_maker, find_dialect, own_dialect
    from reports.cards.program import run_card
    from reports.files.write_run import write_run
    from reports.pictures.board_picture import draw_board
    from robotcell.cell.installation import installation_of
    from robotcell.cell.load import read_cell

    folder = into.path
    loaded_cell = read_cell(cell or _SAMPLE)
    installation = installation_of(loaded_cell)
    language = dialect or own_dialect(installation)
    check_maker(find_dialect(language), installation)
    planned = plan_on(board, recipe, None, cell if find_spec("coal") else None)
    done, card = planned.run, draw_board(planned.run.board, ".png")
    into.make()
    program, report, paths, picture = (
        OutputFile(folder / f"{done.board.name}{end}") for end in (".wash", ".json", "-paths.png", "-board.png")
    )
    write_run(done, output=program, picture=paths, report_file=report, allowed=[])
    finish(run_card(done), program=program, report=report, paths=paths, board=(picture, card))
    if find_spec("coal") is None:
        typer.echo("Robot    not checked: `pip install washboard[robot]` adds what that takes.")
    else:
        _export(planned, loaded_cell, language, folder)
    _analyse(planned, folder)


def _export(planned: "Planned", cell: "LoadedCell", dialect: str, folder: Path) -> None:
    """Track the program in a cell, and write it in the language of the robot."""
    from commandline.loading import finish, progress_bar
    from reports.cards.robot import check_card
    from reports.files.robot_programs import export_tracked, write_program
    from specs.finding import blocking
    from washboard.checked import check

    name = planned.workpiece.name
    with progress_bar() as progress:
        checked = check(planned, cell, progress)
    exported = export_tracked(checked.report, checked.cell, dialect)
    finish(check_card(checked.report))
    if blocking(exported.findings, []) or not checked.report.possible:
        return
    files = exported.exported.files
    place = OutputFolder(folder / f"{name}-{dialect}" if len(files) > 1 else folder)
    written = write_program(place, files, exported.exported.language, exported.page)
    joints = OutputFile(folder / f"{name}-joints.png")
    robot, beside = (place, []) if len(files) > 1 else (written[0], written[1:])
    finish(*beside, joints=(joints, checked.picture), robot=robot)


def _analyse(planned: "Planned", folder: Path) -> None:
    """Predict what the program cleans, with the default parameter set; write the page and its data.

    Raises:
        JobError: it cannot be done, or not be written.
    """
    from commandline.loading import finish, progress_bar
    from reports.cards.cleaning import worst_card
    from washboard.cleaned import analyse

    begun = perf_counter()
    with progress_bar() as progress:
        done = analyse(planned, progress=progress)
    card = worst_card(done.board_report, perf_counter() - begun)
    page, data = (OutputFile(folder / f"{planned.workpiece.name}-cleaning{end}") for end in (".html", ".json"))
    finish(card, cleaning=(page, done.html()), data=(data, done.data()))
