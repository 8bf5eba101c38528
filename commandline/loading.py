"""Begin and end of a command: inputs read with a progress bar, results written and printed."""

import os
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import rich.progress
import typer
from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn

from specs.ending import undone_at_end
from specs.output_file import OutputFile, OutputPlace
from specs.progress import Progress

if TYPE_CHECKING:
    from boards.board import Workpiece
    from boards.parts_table.read import Tables
    from programs.program import TimedProgram
    from reports.tables.table import Card
    from specs.finding import Finding
    from washboard.inputs import OpenedProgram
    from washboard.planned import Planned

Content: TypeAlias = str | bytes | Callable[[str], str | bytes]
"""Of a file: as it is, or what makes it, given the file's suffix."""
Output: TypeAlias = Path | OutputPlace


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


def open_subject(file: Path, workpiece: str | None, recipe: str | None, parts: "Tables", again: str) -> "OpenedProgram":
    """Open a program with its workpiece and its recipe, and print how these differ from those that it states.

    Args:
        file: The program.
        workpiece: Name or file; left out, it is looked for.
        recipe: Likewise.
        parts: Tables that are joined to a board.
        again: The command that names a workpiece which was not found, with ``{file}`` for the program.

    Raises:
        JobError: one of them cannot be used or was not found.
    """
    from washboard.inputs import open_program

    with progress_bar() as progress:
        opened = open_program(file, workpiece, recipe, parts, progress, again=f"washboard {again}")
    print_warnings(opened.differences)
    return opened


def check_for_verdict(verdict: bool, **given: object) -> None:
    """Refuse options that only a verdict heeds.

    Raises:
        JobError: one is given without ``--verdict``.
    """
    from specs.errors import JobError

    for name, value in given.items():
        if not verdict and value not in (None, "default"):
            raise JobError(f"--{name} is for the verdict: give --verdict too, or leave it out.")


def open_program_workpiece(
    program: "TimedProgram", file: Path, named: str | None, parts: "Tables", *, warn: bool = True
) -> "Workpiece | None":
    """Open the workpiece that was named, or look for that of a program; print how it differs from the program's.

    Returns:
        ``None`` where none was named and none was found.

    Raises:
        BoardError: what was named cannot be used.
    """
    from washboard.inputs import find_differences, open_workpiece_of

    with progress_bar() as progress:
        found = open_workpiece_of(program, file, named, parts, progress)
    if found is not None and warn:
        print_warnings(find_differences(program, found))
    return found


def plan_on(workpiece: str, recipe: str, parts: "Tables", cell: str | None = None) -> "Planned":
    """Open a workpiece and a recipe, and plan; for the robot of a cell, if one is named.

    Raises:
        JobError: one of them cannot be used.
    """
    from washboard.planned import plan

    with progress_bar() as progress:
        return plan(workpiece, recipe, cell, progress, parts=parts)


def finish(*shown: "Card | str | Path", **files: Output | tuple[OutputFile | None, Content] | None) -> None:
    """Write the results of a command, once all of them are made; print cards or text, then the files by their names.

    Files without content were written before; those without a name are printed as written.

    Raises:
        JobError: one of them cannot be made or written.
    """
    from reports.terminal.console import open_console, print_card, print_files
    from specs.output_file import write_outputs

    made = [each for each in files.values() if isinstance(each, tuple)]
    write_outputs({file: content(file.path.suffix) if callable(content) else content for file, content in made if file})
    console = open_console()
    for each in shown:
        if isinstance(each, str):
            typer.echo(each, nl=False)
        elif not isinstance(each, Path):
            print_card(console, each)
    paths = {name: each[0] if isinstance(each, tuple) else each for name, each in files.items()}
    print_files(console, *(each for each in shown if isinstance(each, Path)), **paths)


def print_warnings(findings: "Iterable[Finding]") -> None:
    """Print findings as warnings on the error stream."""
    for each in findings:
        typer.echo(f"warning: {each.message}", err=True)


def print_library(entries: dict[str, str], indent: str = "", width: int = 0) -> None:
    """Print names with their descriptions, aligned."""
    width = max(width, *map(len, entries), 0)
    for name, description in entries.items():
        typer.echo(f"{indent}{name:<{width}}  {description}")
