"""Where a command writes what a person reads: the terminal, or a pipe."""

import os
import sys
from pathlib import Path
from typing import TextIO, cast

from rich.console import Console

_ANY_WIDTH = 10_000
"""In a pipe a sentence stays on one line, so that ``grep`` finds it whole."""


def open_console() -> Console:
    """Give the console of stdout: as wide as the terminal or ``COLUMNS``; in a pipe nothing is wrapped or cut."""
    stdout = cast("TextIO | None", sys.stdout)  # a shell may have closed it: washboard >&-
    as_it_is = "COLUMNS" in os.environ or (stdout is not None and stdout.isatty())
    return Console(width=None if as_it_is else _ANY_WIDTH, highlight=False)


def print_files(console: Console, **files: Path | None) -> None:
    """Say which files were written, one a line."""
    for name, path in files.items():
        if path is not None:
            console.print(f"{name.capitalize():<8} {path}", markup=False, soft_wrap=True)
