"""Whether a program was made for the board, and with the recipe, with which it is analysed; what is said if not."""

from dataclasses import replace
from pathlib import Path

from boards.board import Board
from boards.errors import BoardError
from cleaning.verdicts.results import CleaningReport
from programs.program import TimedProgram
from recipes.load import recipe_sha256
from recipes.recipe import Recipe
from reports.files.find_recipe import is_made_with
from specs.finding import Finding, worst_first
from specs.finding_rules import BOARD_DIFFERS, RECIPE_DIFFERS

_SHOWN = 16


def refuse_other_board(program: TimedProgram, file: Path, board: Board) -> None:
    """Refuse a board of another name and content than the one that a program, read from a file, was made for.

    Raises:
        BoardError: it is another board.
    """
    origin = program.origin
    if board.sha256 != origin.board_sha256 and board.name != origin.board:
        raise BoardError(
            f"{file}: this program was made for the board {origin.board} (sha256 {origin.board_sha256[:_SHOWN]}), not "
            f"for {board.name} (sha256 {board.sha256[:_SHOWN]}). Give its own board, or plan {board.name}."
        )


def refuse_other_version(program: TimedProgram, file: Path, board: Board) -> None:
    """Refuse every board but the very one that a program, read from a file, was made for.

    Raises:
        BoardError: it is another board, or another version of it.
    """
    refuse_other_board(program, file, board)
    wanted = program.origin.board_sha256
    if board.sha256 != wanted:
        raise BoardError(
            f"{file}: this program was made for another version of {board.name} (sha256 {wanted[:_SHOWN]}, not "
            f"{board.sha256[:_SHOWN]}). Plan it again."
        )


def find_differences(program: TimedProgram, board: Board, recipe: Recipe) -> list[Finding]:
    """Say where board or recipe are another version than the program was made from."""
    found: list[Finding] = []
    if board.sha256 != program.origin.board_sha256:
        message = (
            f"{board.name} is not quite the board this program was made for (sha256 "
            f"{program.origin.board_sha256[:_SHOWN]}): its paths are those of that one. Plan it again."
        )
        found.append(Finding(BOARD_DIFFERS, message))
    if not is_made_with(program, recipe):
        message = (
            f"{recipe.recipe} (sha256 {recipe_sha256(recipe)[:_SHOWN]}) is not quite the recipe this program was made "
            "with: nozzles and functions are its, paths are not. Plan it again."
        )
        found.append(Finding(RECIPE_DIFFERS, message))
    return found


def state_used(report: CleaningReport, differences: list[Finding]) -> CleaningReport:
    """Have a report name the board that was analysed, and what differs from that of the program."""
    origin = replace(report.origin, board=report.board.name, board_sha256=report.board.sha256)
    return replace(report, origin=origin, findings=worst_first((*differences, *report.findings)))
