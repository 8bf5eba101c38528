"""``washboard show``: a program read back."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from commandline.arguments import Parts, Picture, ProgramSource, input_option, output_option
from specs.output_file import OutputFile

if TYPE_CHECKING:
    from programs.program import TimedProgram


def show(
    program: ProgramSource,
    picture: Picture = None,
    board: Annotated[
        str | None,
        input_option(
            "--board",
            "BOARD",
            "Board of the program: file, or name of a sample. Needed for a picture, unless it is a "
            "sample; without a picture it is only compared.",
        ),
    ] = None,
    parts: Parts = None,
    cell: Annotated[
        str | None,
        input_option(
            "--cell",
            "CELL",
            "Cell of a program in a robot's language; left out, the library cell that its header names.",
        ),
    ] = None,
    output: Annotated[
        OutputFile | None,
        output_option(
            "--output -o", "OUT.wash", "Native program to make of one in a robot's language; it has no recipe paths."
        ),
    ] = None,
) -> None:
    """Read a program back and print its functions, totals, extent and commands to the cell.

    A program in a robot's language (a file or a folder) is executed line by line and timed by the speeds it states.

    [dim]washboard show demo.wash
    washboard show demo.wash --board smt-demo --picture demo.png[/dim]
    """
    from commandline.loading import finish, open_program_workpiece
    from programs import native
    from programs.errors import ProgramError
    from programs.foreign import is_foreign
    from programs.load import load_program
    from reports.cards.program import instructions_card
    from reports.files.write_run import draw_program

    if cell is not None and not is_foreign(program):
        raise ProgramError(
            "--cell is for programs in a robot's language, and this is a native one. Leave it out.", file=program
        )
    if parts is not None and picture is None and board is None:
        raise ProgramError("--parts goes with --picture or --board: no board is read without them.", file=program)
    loaded = _read_robot_program(program, cell, output) if is_foreign(program) else load_program(program)
    text = "" if output is None else native.render(loaded)
    drawn_on = None
    if picture is not None or board is not None:
        drawn_on = open_program_workpiece(loaded, program, board, parts)
        if drawn_on is None:
            named = f"made for {loaded.origin.board}, which is no sample and not beside it"
            raise ProgramError(f"{named}; name its board with --board.", file=program)
    drawing = b"" if drawn_on is None else partial(draw_program, drawn_on, loaded)
    finish(instructions_card(loaded), program=(output, text), picture=(picture, drawing))


def _read_robot_program(path: Path, cell: str | None, output: OutputFile | None) -> "TimedProgram":
    """Read a program in a robot's language.

    Raises:
        JobError: it is not understood, its cell is not known, or it does not hold what a native program needs.
    """
    from programs.foreign import check_origin, read_files
    from reports.files.robot_programs import find_cell, rebuild_in_cell
    from robotcell.cell.load import read_cell

    dialect, files = read_files(path)
    if output is not None:
        check_origin(files)
    loaded = read_cell(cell) if cell else find_cell(files, path, "name its cell with --cell.")
    return rebuild_in_cell(dialect, files, loaded)
