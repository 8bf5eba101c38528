"""``washboard export``: a program in the language of a robot."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import (
    Allow,
    CellName,
    DialectOption,
    ParametersOption,
    Parts,
    ProgramBoard,
    ProgramRecipe,
    VerdictOption,
    input_argument,
)
from specs.errors import JobError
from specs.output_file import OutputPlace, output_place

if TYPE_CHECKING:
    from reports.files.robot_programs import CellExport
    from washboard.driven import DrivenVerdict


def export(
    program: Annotated[Path | None, input_argument("PROGRAM.wash", "Native program.")] = None,
    cell: CellName = None,
    dialect: DialectOption = None,
    output: Annotated[
        OutputPlace | None,
        typer.Option(
            "--output",
            "-o",
            help="Folder, or file of a language that has one; --list states which.",
            metavar="OUT",
            parser=output_place,
        ),
    ] = None,
    board: ProgramBoard = None,
    parts: Parts = None,
    allow: Allow = None,
    without_joints: Annotated[
        bool,
        typer.Option(
            "--without-joints", help="Write poses only, so that a robot of another maker may execute the program."
        ),
    ] = False,
    first_run: Annotated[
        bool,
        typer.Option(
            "--first-run",
            help="Write its first run, under another name: no valve opens, it is slow, and stops before each step.",
        ),
    ] = False,
    verdict: VerdictOption = False,
    recipe: ProgramRecipe = None,
    parameters: ParametersOption = "default",
    list_dialects: Annotated[bool, typer.Option("--list", help="List the languages and stop.")] = False,
) -> None:
    """Write a program in the language of a robot, as the robot of a cell does it.

    [dim]washboard export --list
    washboard export demo.wash --cell ur5e-bench --dialect ur -o demo.script
    washboard export demo.wash --cell ur5e-bench --verdict -o demo.script[/dim]
    """
    from commandline.loading import (
        check_for_verdict,
        open_program_workpiece,
        open_subject,
        print_library,
        progress_bar,
    )
    from programs.export import Variant, find_dialect, own_dialect
    from programs.load import load_program
    from programs.posts.dialects import DIALECTS
    from reports.files.robot_programs import check_output, export_in_cell
    from robotcell.cell.installation import installation_of
    from robotcell.cell.load import read_cell
    from specs.finding_rules import check_allowed
    from washboard.driven import judge_driven

    if list_dialects:
        print_library({
            name: f"{each.title}, class {each.capability.controller_class}. {each.form.describe(each.most_steps)} "
            f"{each.notes}"
            for name, each in DIALECTS.items()
        })  # fmt: skip
        return
    if program is None or cell is None:
        raise JobError("a program and --cell CELL are needed, or --list; `washboard export --help` shows how.")
    if verdict and first_run:
        raise JobError("no jet is on in a first run, so it has no verdict; leave out --verdict or --first-run.")
    check_for_verdict(verdict, recipe=recipe, parameters=parameters)
    allowed = check_allowed(allow or [])
    if dialect is not None:
        find_dialect(dialect)
    loaded, planned, subject = read_cell(cell), load_program(program), None
    language = dialect or own_dialect(installation_of(loaded))
    if output is not None:
        check_output(output, find_dialect(language), planned, installation_of(loaded))
    if verdict:
        subject = open_subject(program, board, recipe, parts, "export {file} --cell CELL --verdict --board BOARD")
    placed = open_program_workpiece(planned, program, board, parts) if subject is None else subject.workpiece
    judged = None
    with progress_bar() as progress:
        done = export_in_cell(planned, loaded, language, placed, progress, Variant(without_joints, first_run))
        if subject is not None and done.report.possible:
            judged = judge_driven(subject, done, parameters, progress)
    _write(done, judged, language, output, allowed)


def _write(
    done: "CellExport",
    judged: "DrivenVerdict | None",
    dialect: str,
    output: OutputPlace | None,
    allowed: list[str],
) -> None:
    """Write the files unless a finding forbids it, and print what was found in any case.

    Raises:
        ProgramError: a finding forbids it.
    """
    from programs.errors import ProgramError
    from reports.cards.robot import export_facts
    from reports.files.robot_programs import write_program
    from reports.files.write_run import export_refusal
    from reports.terminal.console import open_console, print_card, print_facts, print_files, print_findings, print_note
    from specs.finding import blocking

    console = open_console()
    written: list[Path] = []
    stops = blocking(done.findings, allowed)
    try:
        if output is not None and stops:
            raise ProgramError(export_refusal(stops), file=output.path)
        if output is not None:
            written = write_program(output, done.exported.files, done.exported.language, done.page)
    finally:
        print_facts(console, export_facts(done.report, done.exported, dialect))
        print_findings(console, done.findings)
        if judged is not None:
            print_card(console, judged.card())
    print_files(console, *written)
    if output is None:
        print_note(console, "Nothing was written; -o OUT writes it.")
