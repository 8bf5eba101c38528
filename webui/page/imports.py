"""Uploaded boards and parts tables."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from boards.board import Board
from boards.load import load_board
from specs.progress import Progress
from webui.page.project import Project, ProjectError

_TABLES = (".csv", ".tsv", ".txt", ".pos")
_LARGEST_TABLE = 20_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Loaded:
    """A board, and its name in the project's list."""

    name: str
    board: Board


def import_board(project: Project, name: str, content: bytes, progress: Progress) -> Loaded:
    """Store an uploaded board in the project folder and read it; if reading fails or is cancelled, it is removed.

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
    """Read a board again with an uploaded parts table, which is not stored.

    Args:
        name: Of the table, whose suffix is its kind.
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
