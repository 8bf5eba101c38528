"""Inputs of a command, read with a progress bar."""

import os
from collections.abc import Generator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import rich.progress
import typer
from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn

from boards.board import Board, Workpiece
from boards.load import load_board
from specs.ending import undone_at_end
from specs.progress import Progress, subprogress

if TYPE_CHECKING:
    from programs.program import TimedProgram
    from recipes.recipe import Recipe
    from robotcell.cell.load import LoadedCell
    from rulesengine.planning.pipeline import Run


@contextmanager
def progress_bar() -> Generator[Progress]:
    """Show a bar on the terminal's error stream; nothing where there is no terminal."""
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
    console = Console(stderr=True)
    with rich.progress.Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("", total=1.0)

        def progress(what: str, done: float) -> None:
            begun = bar.tasks[0].description != what  # shown at once: what follows may keep the bar's thread waiting
            bar.update(task, description=what, completed=done, refresh=begun)

        with undone_at_end(_clear_bar) if console.is_terminal else nullcontext():
            yield progress


def _clear_bar() -> None:
    """Empty the line of a bar and show the cursor again: an interrupt leaves the bar no time to do so."""
    with suppress(OSError):
        os.write(2, b"\r\x1b[2K\x1b[?25h")


def read_board(board: str, parts: Path | None) -> Board:
    """Load a board by name or file.

    Raises:
        BoardError: it cannot be used.
    """
    with progress_bar() as progress:
        return load_board(Path(board), parts, progress)


def read_program_board(
    program: "TimedProgram", file: Path, board: str | None, parts: Path | None, *, warn: bool = True
) -> Board | None:
    """Load the board that was named, or look for the board of a program; ``None`` where it is not found.

    Args:
        program: States its board.
        file: Where the program was read.
        board: Name or file; ``None`` to look for it.
        parts: A table that is joined to the board.
        warn: Print a warning where the board that was named differs from that of the program.

    Raises:
        BoardError: the board that was named cannot be used.
    """
    from reports.files.inputs import find_board, find_differences

    if board is None:
        with progress_bar() as progress:
            return find_board(program, file, progress, parts)
    found = read_board(board, parts)
    for each in find_differences(program, found) if warn else ():
        typer.echo(f"warning: {each.message}", err=True)
    return found


def read_program_workpiece(
    program: "TimedProgram", file: Path, named: str | None, parts: Path | None
) -> Workpiece | None:
    """Load the board or part that was named, or look for that of a program; ``None`` where it is not found.

    Raises:
        BoardError: what was named cannot be used.
    """
    from reports.files.inputs import find_board, find_differences, find_part, load_workpiece

    with progress_bar() as progress:
        if named is None:
            found = find_board(program, file, progress, parts)
            return found if found is not None else find_part(program, file, progress)
        workpiece = load_workpiece(named, program, parts, progress)
    for each in find_differences(program, workpiece):
        typer.echo(f"warning: {each.message}", err=True)
    return workpiece


def read_program_inputs(
    file: Path, board: str | None, recipe: str | None, parts: Path | None, command: str
) -> "tuple[TimedProgram, Board, Recipe]":
    """Read a program with its board and its recipe.

    Raises:
        JobError: one of them cannot be used or was not found.
    """
    from boards.errors import BoardError
    from programs.load import load_program
    from recipes.load import load_recipe
    from reports.files.inputs import find_recipe, require_board
    from specs.errors import printable

    program = load_program(file)
    loaded_recipe = find_recipe(program, file) if recipe is None else load_recipe(recipe)
    loaded = read_program_board(program, file, board, parts, warn=False)
    if loaded is None:
        raise BoardError(
            f"the board {program.origin.board!r} of this program was not found. "
            f"Name it: washboard {command} {printable(str(file))} BOARD.",
            file=file,
        )
    require_board(program, file, loaded)
    return program, loaded, loaded_recipe


def read_and_run(workpiece: str, recipe: str, parts: Path | None, cell: str | None = None) -> "Run":
    """Load a workpiece and a recipe, and plan; for the robot of a cell, if one is named.

    Raises:
        JobError: one of them cannot be used.
    """
    from boards.workpiece import load_workpiece
    from recipes.errors import RecipeError
    from recipes.load import locate_error, read_recipe
    from rulesengine.planning.pipeline import run

    loaded_recipe = read_recipe(recipe)
    loaded_cell = None if cell is None else read_named_cell(cell)
    with progress_bar() as progress:
        ends = (0.4, 1.0) if loaded_cell is None else (0.1, 0.2)
        reading, planning = subprogress(progress, 0.0, ends[0]), subprogress(progress, *ends)
        loaded = load_workpiece(workpiece, parts, reading, over_faces=loaded_recipe.recipe.over_faces)
        try:
            done = run(loaded_recipe.recipe, loaded, planning)
            if loaded_cell is None:
                return done
            from robotcell.cell.hold import hold_board
            from rulesengine.planning.cell_plan import plan_for_cell

            return plan_for_cell(done, hold_board(loaded_cell, loaded), subprogress(progress, ends[1], 1.0))
        except RecipeError as error:
            raise locate_error(error, loaded_recipe) from None


def read_named_cell(cell: str) -> "LoadedCell":
    """Read a cell by name or file.

    Raises:
        CellError: it cannot be used.
    """
    from robotcell.cell.load import read_cell  # a plan without a cell needs no robot

    return read_cell(cell)


def print_library(entries: dict[str, str], indent: str = "", width: int = 0) -> None:
    """Print names with their descriptions, aligned."""
    width = max(width, *map(len, entries), 0)
    for name, description in entries.items():
        typer.echo(f"{indent}{name:<{width}}  {description}")
