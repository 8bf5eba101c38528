"""Reading boards and recipes for a command, with a progress bar while it lasts."""

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import rich.progress
import typer
from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn

from boards.board import Board
from boards.load import load_board
from specs.progress import Progress, subprogress

if TYPE_CHECKING:
    from programs.program import TimedProgram
    from rulesengine.planning.pipeline import Run


@contextmanager
def progress_bar() -> Generator[Progress]:
    """Show a bar on the terminal's error stream; nothing where there is no terminal."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    console = Console(stderr=True)
    with rich.progress.Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("", total=1.0)

        def progress(what: str, done: float) -> None:
            begun = bar.tasks[0].description != what  # shown at once: what follows may keep the bar's thread waiting
            bar.update(task, description=what, completed=done, refresh=begun)

        yield progress


def read_board(board: str, parts: Path | None) -> Board:
    """Load a board by name or file, showing progress.

    Raises:
        BoardError: it cannot be used.
    """
    with progress_bar() as progress:
        return load_board(Path(board), parts, progress)


def read_board_of(program: "TimedProgram", file: Path, board: str | None, parts: Path | None) -> Board | None:
    """Load the board that was named, or look for the one that a program was made for; ``None`` if it is not at hand.

    Raises:
        BoardError: the one that was named cannot be used.
    """
    from reports.files.find_board import find_board

    if board is None:
        with progress_bar() as progress:
            return find_board(program, file, progress, parts)
    found = read_board(board, parts)
    if found.sha256 != program.origin.board_sha256:
        typer.echo(f"warning: {found.name} is not quite the board this program was made for. Plan it again.", err=True)
    return found


def read_and_run(board: str, recipe: str, parts: Path | None) -> "Run":
    """Load both and plan, showing progress.

    Raises:
        JobError: one of them cannot be used.
    """
    from recipes.load import load_recipe
    from rulesengine.planning.pipeline import run

    loaded_recipe = load_recipe(recipe)
    with progress_bar() as progress:
        loaded = load_board(Path(board), parts, subprogress(progress, 0.0, 0.4))
        return run(loaded_recipe, loaded, subprogress(progress, 0.4, 1.0))
