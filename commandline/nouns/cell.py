"""``washboard cell``: look at the robot cells, place a board in one, get the schema."""

from typing import Annotated

import typer

from commandline.arguments import CellSource, DialectOption, input_option, output_option
from commandline.nouns.place import place, require_readable
from specs.errors import JobError
from specs.output_file import OutputFile

app = typer.Typer(help="Look at robot cells, place a board in one, get the schema.", no_args_is_help=True)
app.command()(place)


@app.command("list")
def list_cells() -> None:
    """List the cells and the robots that come with Washboard."""
    from commandline.loading import print_library
    from robotcell.cell.load import cell_library, describe_cell
    from robotcell.cell.robot_library import read_robot_file, robot_library

    cells = {name: describe_cell(name) for name in cell_library()}
    robots = {name: read_robot_file(name)[1].description for name in robot_library()}
    width = max(map(len, (*cells, *robots)), default=0)
    for title, entries in (("cells", cells), ("robots", robots)):
        typer.echo(title)
        print_library(entries, "  ", width)


@app.command()
def show(
    source: CellSource,
    board: Annotated[
        str | None, input_option("--board", "BOARD", "Board to place in the cell; its corners are shown.")
    ] = None,
) -> None:
    """Show a cell: joints and limits, where its frames lie, tools, fixtures, channels; then what is probably a mistake.

    [dim]washboard cell show ur5e-bench --board smt-demo[/dim]
    """
    from boards.workpiece import load_workpiece
    from commandline.loading import progress_bar
    from reports.cards.robot import cell_card
    from reports.terminal.console import open_console, print_card, print_findings
    from robotcell.cell.load import hold_board, read_cell
    from robotcell.diagnosis.plausibility import check_cell, frame_card

    with progress_bar() as progress:
        placed = None if board is None else load_workpiece(board, None, progress)
    loaded = hold_board(read_cell(source), placed)
    console = open_console()
    print_card(console, cell_card(loaded, frame_card(loaded.cell, placed)))
    print_findings(console, check_cell(loaded.cell, placed, loaded.spec.io))


@app.command()
def edit(
    cell: CellSource,
    edits: Annotated[
        list[str],
        typer.Argument(
            help="A key with its new value, as a check gives its remedy: 'tools.1.tcp.xyz_mm: [0, 0, 300]'.",
            metavar="'KEY: VALUE'...",
        ),
    ],
    output: Annotated[
        OutputFile,
        output_option("--output -o", "OUT.yaml", "Cell with these values; all else as it was.", in_place=True),
    ],
) -> None:
    """Write values into a cell, such as the remedy of a check; comments stay, and the result is read before.

    [dim]washboard cell edit ur5e-bench 'board.pose: {xyz_mm: [420, -50, 150]}' -o my-cell.yaml[/dim]
    """
    from commandline.loading import finish

    edited, lines = _edited(cell, edits, output)
    finish(*lines, written=(output, edited))


def _edited(cell: str, edits: list[str], output: OutputFile) -> tuple[str, list[str]]:
    """Give the text of a cell with edits, and a line for each of them.

    Raises:
        CellError: an edit is none, or the result could not be read where it is to be written.
    """
    from robotcell.cell.cell_edits import apply_edits, describe_edits, parse_edit
    from robotcell.cell.load import CELL
    from specs.errors import printable
    from specs.yaml.load import find_file, read_text
    from specs.yaml.located import read_yaml

    file = find_file(cell, CELL)
    text = read_text(file, CELL)
    root = read_yaml(text, file, CELL)
    parsed = [parse_edit(each, root) for each in edits]
    edited = apply_edits(text, parsed, file)
    require_readable(edited, file, output.path)
    return edited, [f"{printable(line)}\n" for line in describe_edits(root, parsed)]


@app.command()
def interview(
    cell: CellSource,
    dialect: DialectOption = None,
    answer: Annotated[
        list[str] | None,
        typer.Option(
            "--answer", help="A key with its value, as `cell edit` takes it; repeat it.", metavar="'KEY: VALUE'"
        ),
    ] = None,
    output: Annotated[
        OutputFile | None,
        output_option("--output -o", "OUT.yaml", "Cell with the answers; all else as it was.", in_place=True),
    ] = None,
) -> None:
    """List what a cell leaves out that a program in a language could have of it, each with what happens otherwise.

    [dim]washboard cell interview kr6-bench --dialect kuka
    washboard cell interview kr6-bench --answer 'tools.1.centre_mm: [0, 10, 75]' -o my-cell.yaml[/dim]
    """
    from commandline.loading import finish
    from programs.export import find_dialect, own_dialect
    from robotcell.cell.installation import installation_of
    from robotcell.cell.interview import find_questions
    from robotcell.cell.load import read_cell, read_cell_text

    if (output is None) != (not answer):
        raise JobError("--answer and -o OUT.yaml go together: the answers are written into a cell of that name.")
    loaded, lines, written = read_cell(cell), list[str](), None
    language = find_dialect(dialect or own_dialect(installation_of(loaded)))
    if output is not None and answer:
        edited, lines = _edited(cell, answer, output)
        loaded, written = read_cell_text(edited, file=output.path), (output, edited)
    questions = find_questions(loaded.spec, language)
    for each in questions:
        lines += [f"{each.path}: {each.example}\n", f"  {each.why}\n", f"  Left out: {each.otherwise}.\n"]
    left = f"{len(questions)} left out" if questions else "Nothing is left out"
    lines.append(f"{left} of what a program in {language.title} takes from a cell.\n")
    finish(*lines, written=written)


@app.command()
def schema() -> None:
    """Print the JSON schema; an editor that knows it completes keys and marks mistakes.

    [dim]washboard cell schema > cell.schema.json[/dim]
    """
    from robotcell.cell.load import cell_schema

    typer.echo(cell_schema().encode(), nl=False)  # UTF-8 whatever encoding the terminal has


@app.command()
def keys() -> None:
    """Print every key of a cell with its default and meaning, as Markdown."""
    from robotcell.cell.load import cell_keys

    typer.echo(cell_keys().encode(), nl=False)
