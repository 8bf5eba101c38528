"""``washboard export``: a program in the language of a robot."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import Allow, CellName, Parts, ProgramBoard
from specs.errors import JobError

if TYPE_CHECKING:
    from reports.files.robot_programs import CellExport


def complete_dialect(incomplete: str) -> list[str]:
    """Names of the dialects."""
    from programs.posts.dialects import DIALECTS

    return [name for name in DIALECTS if name.startswith(incomplete)]


def export(
    program: Annotated[Path | None, typer.Argument(help="Native program.", metavar="PROGRAM.wash")] = None,
    cell: CellName = None,
    dialect: Annotated[
        str | None,
        typer.Option(
            "--dialect",
            help="Language; left out, that of the robot's maker. --list names them.",
            autocompletion=complete_dialect,
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Folder, or file of a language that has one; --list states which.", metavar="OUT"
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
    list_dialects: Annotated[bool, typer.Option("--list", help="List the languages and stop.")] = False,
) -> None:
    """Write a program in the language of a robot, as the robot of a cell does it.

    [dim]washboard export --list
    washboard export demo.wash --cell ur5e-bench --dialect ur -o demo.script[/dim]
    """
    from commandline.loading import open_program_workpiece, print_library, progress_bar
    from programs.export import find_dialect, own_dialect
    from programs.load import load_program
    from programs.posts.dialects import DIALECTS
    from reports.files.robot_programs import check_output, export_in_cell
    from robotcell.cell.installation import installation_of
    from robotcell.cell.load import read_cell
    from specs.finding_rules import check_allowed

    if list_dialects:
        print_library({
            name: f"{each.title}, class {each.capability.controller_class}. {each.form.describe(each.most_steps)} "
            f"{each.notes}"
            for name, each in DIALECTS.items()
        })  # fmt: skip
        return
    if program is None or cell is None:
        raise JobError("a program and --cell CELL are needed, or --list; `washboard export --help` shows how.")
    if dialect is not None:
        find_dialect(dialect)
    allowed = check_allowed(allow or [])
    loaded, planned = read_cell(cell), load_program(program)
    language = dialect or own_dialect(installation_of(loaded))
    if output is not None:
        check_output(output, find_dialect(language), (program, cell, board, parts))
    placed = open_program_workpiece(planned, program, board, parts)
    with progress_bar() as progress:
        done = export_in_cell(planned, loaded, language, placed, progress, without_joints=without_joints)
    _write(done, language, output, allowed)


def _write(done: "CellExport", dialect: str, output: Path | None, allowed: list[str]) -> None:
    """Write the files unless a finding forbids it, and print what was found in any case.

    Raises:
        ProgramError: a finding forbids it.
    """
    from programs.errors import ProgramError
    from programs.export import find_dialect
    from reports.cards.robot import export_facts
    from reports.files.robot_programs import write_program
    from reports.files.write_run import export_refusal
    from reports.terminal.console import open_console, print_facts, print_files, print_findings, print_note
    from specs.finding import blocking

    console = open_console()
    written: list[Path] = []
    stops = blocking(done.findings, allowed)
    try:
        if output is not None and stops:
            raise ProgramError(export_refusal(stops), file=output)
        if output is not None:
            written = write_program(output, done.exported.files, find_dialect(dialect))
    finally:
        print_facts(console, export_facts(done.report, done.exported, dialect))
        print_findings(console, done.findings)
    print_files(console, *written)
    if output is None:
        print_note(console, "Nothing was written; -o OUT writes it.")
