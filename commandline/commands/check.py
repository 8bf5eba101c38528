"""``washboard check``: whether the robot of a cell can carry out a program."""

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import CellSource, MadeFor, Parts
from commandline.errors import job_errors

if TYPE_CHECKING:
    from robotcell.track import CellReport

_FOUND = 1
"""Exit code where a finding of severity error was not allowed."""
_PICTURES = (".png", ".svg")


def check(
    program: Annotated[Path, typer.Argument(help="Native program.", metavar="PROGRAM.wash")],
    cell: CellSource,
    board: MadeFor = None,
    parts: Parts = None,
    report: Annotated[
        list[Path] | None,
        typer.Option(
            "--report",
            help="What came out: as data (.json), or joints against their limits as a picture (.png, .svg); may be "
            "repeated.",
            metavar="JSON|PNG|SVG",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Program as the robot does it, in its own time.", metavar="OUT.wash"),
    ] = None,
    tilt_band: Annotated[
        float,
        typer.Option(
            "--tilt-band",
            help="Largest jet tilt, degrees, the robot may add to avoid collisions or limits, if the recipe grants "
            "less.",
            min=0,
            max=45,
        ),
    ] = 0.0,
    allow: Annotated[
        list[str] | None,
        typer.Option("--allow", help="Do not count errors of this rule; may be repeated.", metavar="RULE"),
    ] = None,
) -> None:
    """Check whether the robot of a cell reaches every point without collision, in one configuration, at which speed.

    Exit code 0: nothing forbids it. 1: a finding of severity error does. 2: the job could not be done.

    [dim]washboard check demo.wash ur5e-bench
    washboard check demo.wash cell.yaml --board board.step --report check.json --report joints.png[/dim]
    """
    with job_errors():
        from commandline.loading import progress_bar, read_board_of
        from programs.load import load_program
        from reports.files.write_run import check_apart
        from reports.pictures.sheet import check_suffix
        from reports.terminal.cell_report import print_cell_report
        from reports.terminal.console import open_console
        from robotcell.cell.load import read_cell
        from robotcell.track import terms_of, track
        from specs.finding import blocking
        from specs.finding_rules import check_allowed

        reports, allowed = report or [], check_allowed(allow or [])
        for path in reports:
            if path.suffix.lower() != ".json":
                check_suffix(path.suffix)
        check_apart((program, cell, board, parts), [*reports, *([] if output is None else [output])])
        loaded, asked = read_cell(cell), load_program(program)
        made_for = read_board_of(asked, program, board, parts)
        with progress_bar() as progress:
            terms = terms_of(loaded, tilt_band=math.radians(tilt_band))
            done = track(asked, loaded.cell, made_for, terms=terms, progress=progress)
        stops = blocking(done.findings, allowed)
        written = _write(done, reports, output if not stops else None)
        console = open_console()
        print_cell_report(console, done)
        for path in written:
            console.print(f"Written  {path}", markup=False, soft_wrap=True)
        if stops:
            raise typer.Exit(_FOUND)


def _write(done: "CellReport", reports: list[Path], output: Path | None) -> list[Path]:
    """Render everything, then write it; a picture of joints is left out where there is no motion."""
    from programs.native import write as native
    from reports.files.atomic_write import write_bytes_atomically
    from robotcell.report import cell_report

    contents: list[tuple[Path, bytes]] = []
    for path in reports:
        if path.suffix.lower() in _PICTURES:
            from reports.pictures.joint_picture import draw_joints

            if done.possible:
                contents.append((path, draw_joints(done, path.suffix)))
        else:
            text = json.dumps(cell_report(done), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
            contents.append((path, text.encode("utf-8", errors="replace")))
    if output is not None and done.possible:
        contents.append((output, native.render(done.program).encode("utf-8", errors="replace")))
    for path, content in contents:
        write_bytes_atomically(path, content)
    return [path for path, _ in contents]
