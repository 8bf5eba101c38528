"""A board from whatever file it comes in."""

import difflib
import re
from dataclasses import replace
from pathlib import Path

from boards.board import Board
from boards.errors import MAX_BYTES, BoardError
from boards.formats.names import stem_of
from boards.formats.table import suffixes_of
from boards.parts_table.read import Tables, tables_of
from specs.confinement import refusal
from specs.errors import printable, shorten_line
from specs.finding_rules import PANEL_BOARDS
from specs.input_file import InputFile
from specs.progress import Progress, no_progress, subprogress

SUFFIXES = suffixes_of("read")
"""What a board file's name may end with; an ODB++ job and a set of Gerber files may be a folder, too."""

PANEL_SUFFIX = ".yaml"
"""Of a panel file; other files end so as well."""
_YAML = (PANEL_SUFFIX, ".yml")

_PANEL_KEY = re.compile(rb"^(?:\xef\xbb\xbf)?([\"']?)panel\1\s*:", re.MULTILINE)
_HEAD = 20_000
"""Bytes of a panel file in which its key stands."""
_LIBRARY = Path(__file__).parent / "library"


def load_board(path: Path, parts: Tables = None, progress: Progress = no_progress) -> Board:
    """Read a board file and understand it.

    Args:
        path: A file, or the bare name of a sample board of the library.
        parts: Tables of placements, bills of materials and netlists that are joined to the bodies by designator; left
            out, those that a folder or an archive holds.
        progress: Receives the stage and the share done.

    Raises:
        BoardError: There is no such board, or it cannot be read or understood.
    """
    from boards.models import read_order  # late: they bring the libraries for polygons and meshes
    from boards.panel import PanelLayout, compose_panel
    from boards.parts_table.order import open_order
    from boards.parts_table.tables import contradiction_findings
    from boards.sub_boards import take_apart
    from boards.understand import understand

    file = find_board_file(path)
    if file.suffix.lower() in _YAML:
        return _load_panel(file, parts, progress)
    progress(f"reading {file.name}", 0.0)
    try:
        with open_order(file, parts) as opened:
            order, bodies, findings = read_order(opened, subprogress(progress, 0.0, 0.85))
            panel = order.stated.model.panel
            steps = order.form.function("panel")(order.board) if panel == "apart" and order.form.panel else None
        progress("understanding the board", 0.85)
        # What would break a line of a report, a program or a board file is escaped in the names of bodies.
        words = ("name", "package", "part", "value")
        plain = (
            replace(
                body,
                **{key: printable(word) for key in words if (word := getattr(body, key)) is not None},
                extra=tuple((printable(key), printable(value)) for key, value in body.extra),
            )
            for body in bodies
        )
        noticed = [*findings, *contradiction_findings(order.given.contradictions)]
        noticed = [each for each in noticed if panel is None or each.rule is not PANEL_BOARDS]
        board = understand(plain, name_of(file), noticed)
        if steps is None:
            board = take_apart(board, noticed, panel)
        else:
            board = compose_panel(PanelLayout(board=order.label), board, name_of(file), steps)
        sources = order.sources(len(board.components))
        board = replace(board, sources=sources, contradictions=tuple(order.given.contradictions))
    except BoardError as error:
        raise error if error.file is not None else BoardError(str(error), file=file) from None
    progress("board understood", 1.0)
    return board


def is_panel_file(path: Path) -> bool:
    """Whether a file is a YAML file with the key of panels, without parsing it; others end so as well."""
    file = InputFile(path, BoardError, "board file")
    return path.suffix.lower() in _YAML and _PANEL_KEY.search(file.head(_HEAD)) is not None


def _load_panel(file: Path, parts: Tables, progress: Progress) -> Board:
    """Read a panel file and its board; a parts table is that of the single board."""
    from boards.panel import compose_panel, read_panel
    from boards.parts_table.order import open_order

    layout = read_panel(file)
    named = Path(layout.board)
    single = named if layout.board in board_library() else file.parent / named
    if single.suffix.lower() in _YAML:
        raise BoardError(f"its board {printable(layout.board)[:80]} is a panel itself; name a single board.", file=file)
    table = parts if tables_of(parts) or layout.parts is None else file.parent / layout.parts
    try:
        board = load_board(single, table, subprogress(progress, 0.0, 0.7))
    except (BoardError, OSError) as error:
        reason = shorten_line(str(getattr(error, "strerror", None) or error))
        raise BoardError(f"its board {printable(layout.board)[:80]} cannot be used: {reason}", file=file) from None
    progress("composing the panel", 0.7)
    try:
        found = None
        if layout.is_left_to_the_file:
            with open_order(find_board_file(single), table) as order:
                found = order.form.function("panel")(order.board) if order.form.panel else None
        panel = compose_panel(layout, board, name_of(file), found)
    except BoardError as error:
        raise error if error.file is not None else BoardError(str(error), file=file) from None
    progress("board understood", 1.0)
    return panel


def board_library() -> dict[str, Path]:
    """The sample boards that come with the program, by name."""
    files = sorted(file for file in _LIBRARY.iterdir() if file.name.endswith((".tri", ".tri.gz")))
    return {stem_of(file): file for file in files}


def name_of(file: Path) -> str:
    """Return what a board is called after its file: printable, and without blanks at its ends."""
    return printable(stem_of(file)).strip() or "board"


def find_board_file(path: Path) -> Path:
    """Return the file that is meant: the path itself, or the board of that name in the library.

    Raises:
        BoardError: There is no such file and no such sample, or it is too large.
    """
    InputFile(path, BoardError, "board file").check_kind()
    if len(path.parts) == 1 and not path.suffix and not path.is_file():
        library = board_library()
        if path.name in library:
            return library[path.name]
        if not path.exists():
            close = difflib.get_close_matches(path.name, library, 1)
            hint = f"Did you mean {close[0]!r}? " if close else ""
            known = ", ".join(library)
            raise BoardError(f"no board of this name. {hint}The samples are: {known}. Or name a file.", file=path)
    if path.is_dir() and not path.name.lower().endswith(SUFFIXES):  # a job of ODB++, or a set of Gerber files
        if reason := refusal(path):
            raise BoardError(reason, file=path)
        return path
    InputFile(path, BoardError, "board file", MAX_BYTES).check()
    return path
