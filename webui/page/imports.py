"""Boards and parts tables that a browser sends."""

from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

from boards.board import Board
from boards.load import load_board
from specs.progress import Progress
from webui.page.project import Project, ProjectError
from webui.theme.palette import QUIET, to_hex

_TABLES = (".csv", ".tsv", ".txt", ".pos")
_LARGEST_TABLE = 20_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Loaded:
    """A board, and the name under which the page lists it."""

    name: str
    board: Board


def import_board(project: Project, name: str, content: bytes, progress: Progress) -> Loaded:
    """Keep an uploaded board in the project folder and read it; what cannot be read, or is not wanted, is not kept.

    Raises:
        ProjectError: its name, kind or size cannot be used.
        OutputError: it cannot be written.
        BoardError: it cannot be read.
    """
    stored = project.store(name, content)
    try:
        return Loaded(stored.name, load_board(project.locate(stored.name), None, progress))
    except BaseException:
        if stored.fresh:
            project.discard(stored.name)
        raise


def join_table(name: str, content: bytes, read: Callable[[Path], Board]) -> Board:
    """Read a board anew with an uploaded parts table, which is not kept.

    Args:
        name: Of the table; says what kind it is.
        content: Of the table.
        read: Reads the board with the table in this file.

    Raises:
        ProjectError: the table's kind or size cannot be used.
        BoardError: the table or the board cannot be read.
    """
    suffix = next((each for each in _TABLES if name.lower().endswith(each)), None)
    if suffix is None:
        raise ProjectError(f"{name[:40]!r} is no parts table. Known are {', '.join(_TABLES)}.")
    if len(content) > _LARGEST_TABLE:
        raise ProjectError(f"{name[:40]!r}: {len(content) / 1e6:.0f} MB are too many for a parts table.")
    with TemporaryDirectory(prefix="washboard-") as folder:
        table = Path(folder) / f"parts{suffix}"
        table.write_bytes(content)
        return read(table)


def progress_html(what: str, percent: int) -> str:
    """Say what is being done and how much of it is done."""
    return f'<div style="margin:0 12px;font-size:12px;color:{to_hex(QUIET)}">{escape(what)}, {percent} %</div>'
