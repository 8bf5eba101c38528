"""Reading boards and recipes for a command, with a progress bar while it lasts."""

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from boards.load import load_board
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from boards.board import Board
from recipes.load import load_recipe
from rulesengine import pipeline


@contextmanager
def progress_bar() -> Generator[pipeline.Progress]:
    """Show a bar on the terminal's error stream; nothing where there is no terminal."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("", total=1.0)

        def tell(what: str, done: float) -> None:
            bar.update(task, description=what, completed=done)

        yield tell


def read_board(board: str, parts: Path | None) -> Board:
    """Load a board by name or file, showing progress.

    Raises:
        BoardError: it cannot be used.
    """
    with progress_bar() as tell:
        return load_board(Path(board), parts, tell)


def read_and_run(board: str, recipe: str, parts: Path | None) -> pipeline.Run:
    """Load both and plan, showing progress.

    Raises:
        JobError: one of them cannot be used.
    """
    loaded_recipe = load_recipe(recipe)
    with progress_bar() as tell:
        loaded = load_board(Path(board), parts, _part(tell, 0.0, 0.4))
        return pipeline.run(loaded_recipe, loaded, _part(tell, 0.4, 1.0))


def _part(tell: pipeline.Progress, begin: float, end: float) -> pipeline.Progress:
    """Map the progress of a part onto its share of the whole."""

    def told(what: str, done: float) -> None:
        tell(what, begin + (end - begin) * done)

    return told
