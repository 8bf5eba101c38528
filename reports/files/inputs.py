"""Board and recipe of a program: found again, and compared with those it was planned with, by fingerprint.

What reads parts and recipes is imported where one is looked for: a check of a board needs neither.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from boards.board import Board, Workpiece
from boards.errors import BoardError
from boards.load import PANEL_SUFFIX, SUFFIXES, board_library, load_board
from programs.program import TimedProgram
from specs.confinement import find_beside
from specs.finding import Finding, worst_first
from specs.finding_rules import BOARD_DIFFERS, RECIPE_DIFFERS
from specs.progress import Progress, no_progress

if TYPE_CHECKING:
    from boards.board import Part
    from cleaning.verdicts.results import CleaningReport
    from recipes.recipe import Recipe

_SHOWN = 16


def find_board(
    program: TimedProgram, file: Path, progress: Progress = no_progress, parts: Path | None = None
) -> Board | None:
    """Look for the board of a program among the samples and beside the program; its fingerprint must be the same.

    Args:
        program: States the board.
        file: Where the program was read.
        progress: Receives the stage and the share done.
        parts: A table that is joined to the board, as it was when the program was planned.

    Raises:
        BoardError: the table cannot be used.
    """
    for place in _places(program.origin.board, file, board_library(), (*SUFFIXES, PANEL_SUFFIX)):
        try:
            board = load_board(place, parts, progress)
        except BoardError as error:
            if parts is not None and error.file == parts:
                raise
            continue  # what cannot be read is not the board that was planned
        if board.sha256 == program.origin.board_sha256:
            return board
    return None


def find_part(program: TimedProgram, file: Path, progress: Progress = no_progress) -> "Part | None":
    """Look for the part of a program among the library's and beside the program; its fingerprint must be the same."""
    from boards.part.load import PART_SUFFIXES, load_part, part_library

    for place in _places(program.origin.board, file, part_library(), PART_SUFFIXES):
        try:
            part = load_part(place, progress)
        except BoardError:
            continue  # what cannot be read is not the part that was planned
        if part.sha256 == program.origin.board_sha256:
            return part
    return None


def load_workpiece(
    source: str, program: TimedProgram, parts: Path | None, progress: Progress = no_progress
) -> Workpiece:
    """Read a board or a part: a mesh is a part where the program was planned on just that part.

    Raises:
        BoardError: it cannot be used as either.
    """
    from boards.part.load import PART_SUFFIXES, is_part_source, load_part

    if is_part_source(source):
        return load_part(source, progress)
    if parts is None and source.lower().endswith(PART_SUFFIXES):
        try:
            part = load_part(source, progress)
            if part.sha256 == program.origin.board_sha256:
                return part
        except BoardError:
            pass  # it may be a board
    return load_board(Path(source), parts, progress)


def find_recipe(
    program: TimedProgram, file: Path, advice: str = "Name it with --recipe, or plan the board again."
) -> "Recipe":
    """Look for the recipe of a program in the library and beside the program; its fingerprint must be the same.

    Args:
        program: States the recipe.
        file: Where the program was read.
        advice: What to do where it is not found.

    Raises:
        RecipeError: it is not there, cannot be used, or has been changed since.
    """
    from recipes.errors import RecipeError
    from recipes.load import load_recipe, recipe_library, recipe_sha256

    name, sha256 = program.origin.recipe, program.origin.recipe_sha256
    places = _places(name, file, recipe_library(), (".yaml", ".yml"))
    for place in places:
        try:
            recipe = load_recipe(place)
        except RecipeError:
            continue  # what cannot be used is not the recipe that was planned
        if recipe_sha256(recipe) == sha256:
            return recipe
    reason = f"{places[-1]} has changed since" if places else "it is neither in the library nor beside the program"
    message = f"the recipe {name!r} of this program (sha256 {sha256[:_SHOWN]}) was not found: {reason}. {advice}"
    raise RecipeError(message, file=file)


def _places(name: str, file: Path, library: Mapping[str, Path], suffixes: tuple[str, ...]) -> list[Path]:
    """Where an input of that name may be: in the library, or beside the program."""
    found = [library[name]] if name in library else []
    for suffix in suffixes:
        with suppress(ValueError):  # a program names what lies in its folder and nothing else
            path = find_beside(f"{name}{suffix}", file)
            found += [path] if path.is_file() else []
    return found


def require_board(program: TimedProgram, file: Path, board: Board, *, exactly: bool = False) -> None:
    """Refuse a board of another name and content than the one that a program, read from a file, was planned on.

    Args:
        program: States its board.
        file: Where the program was read.
        board: The board.
        exactly: Refuse other versions of the same board too.

    Raises:
        BoardError: it is another board.
    """
    origin = program.origin
    planned, given = origin.board_sha256[:_SHOWN], board.sha256[:_SHOWN]
    if board.sha256 == origin.board_sha256:
        return
    if board.name != origin.board:
        raise BoardError(
            f"this program was made for the board {origin.board} (sha256 {planned}), not for {board.name} "
            f"(sha256 {given}). Give its own board, or plan {board.name}.",
            file=file,
        )
    if exactly:
        raise BoardError(
            f"this program was made for another version of {board.name} (sha256 {planned}, not {given}). "
            "Plan it again.",
            file=file,
        )


def find_differences(program: TimedProgram, board: Workpiece, recipe: "Recipe | None" = None) -> list[Finding]:
    """Compare board and recipe with those that a program was planned with; a finding for each that differs."""
    found: list[Finding] = []
    origin = program.origin
    if board.sha256 != origin.board_sha256:
        message = (
            f"{board.name} (sha256 {board.sha256[:_SHOWN]}) differs from the board of this program, {origin.board} "
            f"(sha256 {origin.board_sha256[:_SHOWN]}), on which its paths were planned. Plan it again."
        )
        found.append(Finding(BOARD_DIFFERS, message))
    if recipe is None:
        return found
    from recipes.load import recipe_sha256

    if recipe_sha256(recipe) != origin.recipe_sha256:
        message = (
            f"{recipe.recipe} (sha256 {recipe_sha256(recipe)[:_SHOWN]}) differs from the recipe of this program: its "
            "nozzles and functions are used, its paths are not. Plan it again."
        )
        found.append(Finding(RECIPE_DIFFERS, message))
    return found


def with_differences(report: "CleaningReport", differences: list[Finding]) -> "CleaningReport":
    """Have a report state the board that was analysed, and the differences from the inputs of the program."""
    origin = replace(report.origin, board=report.board.name, board_sha256=report.board.sha256)
    return replace(report, origin=origin, findings=worst_first((*differences, *report.findings)))
