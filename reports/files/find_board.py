"""The board that a program was made for, if it is at hand."""

from pathlib import Path

from boards.board import Board
from boards.errors import BoardError
from boards.load import SUFFIXES, board_library, load_board
from programs.program import TimedProgram
from specs.progress import Progress, no_progress


def find_board(
    program: TimedProgram, file: Path, progress: Progress = no_progress, parts: Path | None = None
) -> Board | None:
    """Look for the board among the samples and beside the program; it must be the very same, by its fingerprint.

    Args:
        program: Names the board.
        file: Where the program was read.
        progress: Receives the stage and the share done.
        parts: A table that is joined to the board, as it was when the program was planned.

    Raises:
        BoardError: the table cannot be used.
    """
    named = program.origin.board
    places = [board_library()[named]] if named in board_library() else []
    places += [path for path in (file.parent / f"{named}{suffix}" for suffix in SUFFIXES) if path.is_file()]
    for place in places:
        try:
            board = load_board(place, parts, progress)
        except BoardError as error:
            if parts is not None and error.file == parts:
                raise
            continue  # what cannot be read is not the board that was planned
        if board.sha256 == program.origin.board_sha256:
            return board
    return None
