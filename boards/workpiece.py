"""A workpiece from whatever it comes in: a board, a panel of boards, a part, or the points of a scan."""

from pathlib import Path

from boards.board import Workpiece
from boards.errors import BoardError
from boards.load import board_library, is_panel_file, load_board
from boards.part.sources import MESH_SUFFIXES, is_part_source
from boards.parts_table.read import Tables, tables_of
from specs.progress import Progress, no_progress


def load_workpiece(
    source: str | Path, parts: Tables = None, progress: Progress = no_progress, *, over_faces: bool = False
) -> Workpiece:
    """Read a board, or a part where its name, its file or what is to be done with it makes it one.

    Args:
        source: Name of a library, or a file.
        parts: Parts tables that are joined to a board; with one a mesh is a board.
        progress: Receives the stage and the share done.
        over_faces: Whether the recipe follows the faces of parts: a mesh is a part then, and a board otherwise.

    Raises:
        BoardError: it cannot be found, read or used.
    """
    if is_part(source, over_faces=over_faces):
        from boards.part.load import load_part  # late: boards need none of its libraries

        if tables := tables_of(parts):
            raise BoardError(f"--parts is for boards; {source} is a part. Leave it out.", file=tables[0])
        return load_part(source, progress)
    try:
        return load_board(Path(source), parts, progress)
    except BoardError as error:
        if Path(source).is_file() and str(source).lower().endswith(MESH_SUFFIXES) and not over_faces:
            advice = "To clean it as a part, open a recipe for parts first, such as part-degrease."
            raise BoardError(f"{error} {advice}") from None
        raise


def is_part(source: str | Path, *, over_faces: bool) -> bool:
    """Whether a source is read as a part: by its name or file, or because the recipe follows the faces of parts."""
    is_board = str(source) in board_library() or is_panel_file(Path(source))
    return is_part_source(source) or (over_faces and not is_board)


def is_read_otherwise(source: str | Path, workpiece: Workpiece, *, over_faces: bool) -> bool:
    """Whether a workpiece is to be read anew for another recipe: as a part in place of a board, or the reverse."""
    return is_part(source, over_faces=over_faces) != bool(workpiece.faces)
