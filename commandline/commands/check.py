"""``washboard check``: whether the robot of a cell can carry out a program."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import (
    Allow,
    CellSource,
    DialectOption,
    ParametersOption,
    Parts,
    ProgramBoard,
    ProgramRecipe,
    ProgramSource,
    VerdictOption,
    output_option,
)
from specs.output_file import OutputFile

if TYPE_CHECKING:
    from robotcell.track import CellReport
    from washboard.driven import DrivenVerdict

_FOUND = 1
"""Exit code where a finding of severity error was not allowed."""


def check(
    program: ProgramSource,
    cell: CellSource,
    board: ProgramBoard = None,
    parts: Parts = None,
    report: Annotated[
        list[OutputFile] | None,
        output_option(
            "--report",
            "JSON|PNG|SVG",
            "Result: as data (.json), or joints against their limits as a picture (.png, .svg); may be repeated.",
        ),
    ] = None,
    output: Annotated[
        OutputFile | None, output_option("--output -o", "OUT.wash", "Program as the robot does it, with its own times.")
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
    verdict: VerdictOption = False,
    dialect: DialectOption = None,
    recipe: ProgramRecipe = None,
    parameters: ParametersOption = "default",
    allow: Allow = None,
) -> None:
    """Check whether the robot of a cell reaches every point without collision, in one configuration, at which speed.

    Exit code 0: nothing forbids it. 1: a finding of severity error does. 2: the job could not be done.

    [dim]washboard check demo.wash ur5e-bench
    washboard check demo.wash ur5e-bench --verdict
    washboard check demo.wash cell.yaml --board board.step --report check.json --report joints.png[/dim]
    """
    from commandline.loading import check_for_verdict, finish, open_program_workpiece, open_subject, progress_bar
    from programs.export import check_maker, find_dialect, own_dialect
    from programs.load import load_program
    from reports.cards.robot import check_card, remedy_card
    from reports.pictures.sheet import check_suffix
    from robotcell.cell.installation import installation_of
    from specs.finding import blocking
    from specs.finding_rules import check_allowed
    from washboard.checked import check_in
    from washboard.driven import judge_driven
    from washboard.inputs import open_cell

    reports, allowed = report or [], check_allowed(allow or [])
    for each in reports:
        if each.path.suffix.lower() != ".json":
            check_suffix(each.path.suffix)
    check_for_verdict(verdict, dialect=dialect, recipe=recipe, parameters=parameters)
    loaded = open_cell(cell)
    language, subject = "", None
    if verdict:
        language = dialect or own_dialect(installation_of(loaded))
        check_maker(find_dialect(language), installation_of(loaded))
        subject = open_subject(program, board, recipe, parts, f"check {{file}} {cell} --verdict --board BOARD")
    planned = load_program(program) if subject is None else subject.program
    placed = open_program_workpiece(planned, program, board, parts) if subject is None else subject.workpiece
    with progress_bar() as progress:
        checked = check_in(planned, placed, loaded, progress, tilt_band_deg=tilt_band)
        judged = None
        if subject is not None and checked.report.possible:
            judged = judge_driven(subject, checked.written(language), parameters, progress)
    done, loaded = checked.report, checked.cell
    stops = blocking(done.findings, allowed)
    written = _write(done, judged, reports, None if stops else output)
    remedy = [] if done.remedy is None else [remedy_card(cell, loaded, done.remedy)]
    finish(check_card(done), *([] if judged is None else [judged.card()]), *remedy, *written)
    if stops:
        raise typer.Exit(_FOUND)


def _write(
    done: "CellReport", judged: "DrivenVerdict | None", reports: list[OutputFile], output: OutputFile | None
) -> list[Path]:
    """Render everything, then write it; a picture of joints is left out where there is no motion."""
    from programs import native
    from reports.files.write_run import json_bytes
    from reports.pictures.joint_picture import draw_joints
    from robotcell.report import cell_report
    from specs.output_file import write_outputs

    contents: dict[OutputFile | None, str | bytes | None] = {}
    for each in reports:
        if each.path.suffix.lower() == ".json":
            contents[each] = json_bytes({**cell_report(done), **({} if judged is None else {"verdict": judged.data()})})
        elif done.possible:
            contents[each] = draw_joints(done, each.path.suffix)
    if output is not None and done.possible:
        contents[output] = native.render(done.program)
    write_outputs(contents)
    return [each.path for each in contents if each is not None]
