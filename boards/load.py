"""A board from whatever file it comes in."""

import difflib
import re
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from boards.board import Board, Body
from boards.errors import MAX_BYTES, BoardError, read_bytes
from specs.confinement import refusal
from specs.errors import printable
from specs.finding import Finding
from specs.progress import Progress, no_progress, subprogress
from specs.read_file import check_file

if TYPE_CHECKING:
    from boards.formats.placed import StepPanel

SUFFIXES = (
    ".tri", ".tri.gz", ".step", ".stp", ".glb", ".gltf", ".stl", ".obj", ".ply", ".emn", ".emp", ".idf", ".kicad_pcb",
    ".brd", ".xml", ".cvg", ".zip", ".tgz", ".tar.gz", ".gbr", ".gm1", ".gko",
)  # fmt: skip
"""What a board file's name may end with; an ODB++ job and a set of Gerber files may be a folder, too."""

PANEL_SUFFIX = ".yaml"
"""Of a panel file; other files end so as well."""

_PANEL_KEY = re.compile(rb"^panel\s*:", re.MULTILINE)
_HEAD = 20_000
"""Bytes of a panel file in which its key stands."""
_LIBRARY = Path(__file__).parent / "library"
_Read: TypeAlias = tuple[tuple[Body, ...], tuple[Finding, ...]]
_PACKED = ("zip", "tgz")


def load_board(path: Path, parts: Path | None = None, progress: Progress = no_progress) -> Board:
    """Read a board file and understand it.

    Args:
        path: A file, or the bare name of a sample board of the library.
        parts: A table of placements or a bill of materials that is joined to the bodies.
        progress: Receives the stage and the share done.

    Raises:
        BoardError: There is no such board, or it cannot be read or understood.
    """
    from boards.understand import understand  # late: it brings the libraries for polygons and meshes

    file = find_board_file(path)
    if file.suffix.lower() == PANEL_SUFFIX:
        return _load_panel(file, parts, progress)
    progress(f"reading {file.name}", 0.0)
    try:
        bodies, findings, is_placed = _read(file, parts, subprogress(progress, 0.0, 0.8))
        if parts is not None and not is_placed:
            from boards.parts_table.join import join_parts

            progress(f"joining {parts.name}", 0.8)
            bodies, more = join_parts(bodies, parts)
            findings += more
        progress("understanding the board", 0.85)
        board = understand(map(_printable, bodies), name_of(file), findings)
    except BoardError as error:
        raise error if error.file is not None else BoardError(str(error), file=file) from None
    progress("board understood", 1.0)
    return board


def is_panel_file(path: Path) -> bool:
    """Whether a file is a YAML file with the key of panels, without parsing it; others end so as well."""
    if path.suffix.lower() != PANEL_SUFFIX:
        return False
    with suppress(OSError), path.open("rb") as file:
        return _PANEL_KEY.search(file.read(_HEAD)) is not None
    return False


def _load_panel(file: Path, parts: Path | None, progress: Progress) -> Board:
    """Read a panel file and its board; a parts table is that of the single board."""
    from boards.panel import compose_panel, read_panel

    layout = read_panel(file)
    named = Path(layout.board)
    single = named if layout.board in board_library() else file.parent / named
    if single.suffix.lower() == PANEL_SUFFIX:
        raise BoardError(f"its board {printable(layout.board)[:80]} is a panel itself; name a single board.", file=file)
    table = parts if parts is not None or layout.parts is None else file.parent / layout.parts
    board = load_board(single, table, subprogress(progress, 0.0, 0.7))
    progress("composing the panel", 0.7)
    try:
        found = _step_repeat(find_board_file(single)) if layout.is_left_to_the_file else None
        panel = compose_panel(layout, board, name_of(file), found)
    except BoardError as error:
        raise error if error.file is not None else BoardError(str(error), file=file) from None
    progress("board understood", 1.0)
    return panel


def _step_repeat(file: Path) -> "StepPanel | None":
    """Read how an IPC-2581 file or an ODB++ job repeats its board on a panel; ``None`` where it does not."""
    from boards.formats.archive import is_archive, read_members

    if is_archive(file):
        from boards.formats.odb.odb import read_odb_panel, root_of

        return read_odb_panel(file) if root_of(read_members(file, lambda _: False)[0]) is not None else None
    if file.suffix.lower() in (".xml", ".cvg"):
        from boards.formats.ipc2581.ipc2581 import read_ipc2581_panel

        return read_ipc2581_panel([read_bytes(file)], file)
    return None


def board_library() -> dict[str, Path]:
    """The sample boards that come with the program, by name."""
    files = sorted(file for file in _LIBRARY.iterdir() if file.name.endswith((".tri", ".tri.gz")))
    return {stem_of(file): file for file in files}


def stem_of(file: Path) -> str:
    """Return a file's name without the suffixes of its format."""
    return file.name.removesuffix(".gz").rpartition(".")[0] or file.name


def name_of(file: Path) -> str:
    """Return what a board is called after its file: printable, and without blanks at its ends."""
    return printable(stem_of(file)).strip() or "board"


def _printable(body: Body) -> Body:
    """Escape in the names of a body what would break a line of a report, a program or a board file."""
    words = {key: getattr(body, key) for key in ("name", "package", "part", "value")}
    odd = {key: printable(word) for key, word in words.items() if word is not None and not word.isprintable()}
    extra = tuple((printable(key), printable(value)) for key, value in body.extra)
    return replace(body, **odd, extra=extra) if odd or extra != body.extra else body


def find_board_file(path: Path) -> Path:
    """Return the file that is meant: the path itself, or the board of that name in the library.

    Raises:
        BoardError: There is no such file and no such sample, or it is too large.
    """
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
    check_file(path, BoardError, "board file", MAX_BYTES)
    return path


def _read(file: Path, parts: Path | None, progress: Progress) -> tuple[tuple[Body, ...], tuple[Finding, ...], bool]:
    """Read bodies and findings, and whether the table of parts went into them already."""
    name = file.name.lower()
    suffix = name.removesuffix(".gz").rpartition(".")[2] if name.endswith(".tri.gz") else name.rpartition(".")[2]
    if file.is_dir() or suffix in _PACKED or name.endswith(".tar.gz"):
        return _read_packed(file, parts)
    if suffix in ("gbr", "gm1", "gko"):
        return *_read_gerber(file, parts), True
    return *_read_single(file, suffix, progress), False


def _read_packed(file: Path, parts: Path | None) -> tuple[tuple[Body, ...], tuple[Finding, ...], bool]:
    """Read what lies in a folder or an archive: an ODB++ job, an IPC-2581 file, or Gerber files."""
    from boards.formats.archive import read_members
    from boards.formats.odb.odb import read_odb, root_of

    names, _ = read_members(file, lambda _: False)
    if root_of(names) is not None:
        return *read_odb(file), False
    inside = [name for name in names if name.lower().endswith((".xml", ".cvg")) and not name.startswith("__MACOSX")]
    if len(inside) == 1:
        from boards.formats.ipc2581.ipc2581 import read_ipc2581_chunks

        _, contents = read_members(file, lambda name: name == inside[0])
        return *read_ipc2581_chunks([contents[inside[0]]], file / inside[0]), False
    if len(inside) > 1:
        raise BoardError(f"holds {len(inside)} XML files. Keep one IPC-2581 file in it.", file=file)
    return *_read_gerber(file, parts), True


def _read_gerber(file: Path, parts: Path | None) -> _Read:
    from boards.formats.gerber.gerber import read_gerber
    from boards.parts_table.place import place_parts

    return place_parts(read_gerber(file), parts)


def _read_single(file: Path, suffix: str, progress: Progress) -> _Read:
    match suffix:
        case "tri":
            from boards.formats.tri.tri import read_tri

            return read_tri(file)
        case "step" | "stp" | "glb" | "gltf" | "stl" | "obj" | "ply":
            from boards.formats.scene import read_scene

            return read_scene(file, progress)
        case "emn" | "emp" | "idf":
            from boards.formats.idf.idf import read_idf

            return read_idf(file)
        case "brd":
            from boards.formats.eagle.eagle import read_eagle
            from boards.formats.idf.idf import read_idf

            # Some tools give the board file of an IDF this suffix, too.
            is_idf = read_bytes(file)[:200].lstrip(b"\xef\xbb\xbf \t\r\n").upper().startswith(b".HEADER")
            return read_idf(file) if is_idf else read_eagle(file)
        case "kicad_pcb":
            from boards.formats.kicad.kicad import read_kicad

            return read_kicad(file)
        case "xml" | "cvg":
            from boards.formats.ipc2581.ipc2581 import read_ipc2581

            return read_ipc2581(file)
        case _:
            message = f"no reader for this kind of file. Known are {', '.join(SUFFIXES)}."
            raise BoardError(message, file=file)
