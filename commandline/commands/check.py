"""``washboard check``: whether the robot of a cell can carry out a program."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import Allow, CellSource, Parts, ProgramBoard, ProgramSource

if TYPE_CHECKING:
    from robotcell.track import CellReport

_FOUND = 1
"""Exit code where a finding of severity error was not allowed."""


def check(
    program: ProgramSource,
    cell: CellSource,
    board: ProgramBoard = None,
    parts: Parts = None,
    report: Annotated[
        list[Path] | None,
        typer.Option(
            "--report",
            help="Result: as data (.json), or joints against their limits as a picture (.png, .svg); may be repeated.",
            metavar="JSON|PNG|SVG",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Program as the robot does it, with its own times.", metavar="OUT.wash"),
    ] = None,
    tilt_band: Annotated[
        float,
        typer.Option(
            "--tilt-band",
            help="Largest jet tilt, in degrees, that the robot may add to avoid collisions or limits, if the recipe "
            "grants less.",
            min=0,
            max=45,
        ),
    ] = 0.0,
    allow: Allow = None,
) -> None:
    """Check whether the robot of a cell reaches every point without collision, in one configuration, at which speed.

    Exit code 0: nothing forbids it. 1: a finding of severity error does. 2: the job could not be done.

    [dim]washboard check demo.wash ur5e-bench
    washboard check demo.wash cell.yaml --board board.step --report check.json --report joints.png[/dim]
    """
    from commandline.loading import finish, open_program_workpiece, progress_bar
    from programs.load import load_program
    from reports.cards.robot import check_card, remedy_card
    from reports.files.write_run import check_apart
    from reports.pictures.sheet import check_suffix
    from specs.finding import blocking
    from specs.finding_rules import check_allowed
    from washboard.checked import check_in
    from washboard.inputs import open_cell

    reports, allowed = report or [], check_allowed(allow or [])
    for path in reports:
        if path.suffix.lower() != ".json":
            check_suffix(path.suffix)
    check_apart((program, cell, board, parts), [*reports, output])
    planned = load_program(program)
    placed = open_program_workpiece(planned, program, board, parts)
    loaded = open_cell(cell)
    with progress_bar() as progress:
        checked = check_in(planned, placed, loaded, progress, tilt_band_deg=tilt_band)
    done, loaded = checked.report, checked.cell
    stops = blocking(done.findings, allowed)
    written = _write(done, reports, None if stops else output)
    finish(check_card(done), *([] if done.remedy is None else [remedy_card(cell, loaded, done.remedy)]), *written)
    if stops:
        raise typer.Exit(_FOUND)


def _write(done: "CellReport", reports: list[Path], output: Path | None) -> list[Path]:
    """Render everything, then write it; a picture of joints is left out where there is no motion."""
    from programs import native
    from reports.files.atomic_write import write_outputs
    from reports.files.write_run import json_bytes
    from reports.pictures.joint_picture import draw_joints
    from robotcell.report import cell_report

    contents: dict[Path | None, str | bytes | None] = {}
    for path in reports:
        if path.suffix.lower() == ".json":
            contents[path] = json_bytes(cell_report(done))
        elif done.possible:
            contents[path] = draw_joints(done, path.suffix)
    if output is not None and done.possible:
        contents[output] = native.render(done.program)
    write_outputs(contents)
    return [path for path in contents if path is not None]
