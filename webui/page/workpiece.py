"""Boards and parts on the page: how each is read and planned, as the command line does."""

from collections.abc import Callable
from pathlib import Path

from boards.errors import BoardError
from boards.load import load_board
from boards.part.load import MESH_SUFFIXES, load_part
from boards.part.part import BoardOrPart, Part
from programs.plan import Plan
from programs.program import TimedProgram
from recipes.recipe import Recipe
from rulesengine.planning.pipeline import Run, run
from rulesengine.surface.plan_part import PartRun, PlannedRun, has_surfaces, plans_part, run_part
from specs.progress import Progress, no_progress


def read_workpiece(
    source: str | Path, recipe: Recipe, table: Path | None = None, progress: Progress = no_progress
) -> BoardOrPart:
    """Read a board, or a part where the name, the file or the recipe makes it one.

    Args:
        source: Name of a library, or a file.
        recipe: A mesh is a part for a recipe that follows the faces of parts, and a board for all others.
        table: Parts table that is joined to a board.
        progress: Receives the stage and the share done.

    Raises:
        BoardError: it cannot be found, read or used.
    """
    if table is None and plans_part(str(source), recipe):
        return load_part(source, progress)
    try:
        return load_board(Path(source), table, progress)
    except BoardError as error:
        if str(source).lower().endswith(MESH_SUFFIXES) and not has_surfaces(recipe):
            advice = "To clean it as a part, open a recipe for parts first, such as part-degrease."
            raise BoardError(f"{error} {advice}") from None
        raise


def is_read_otherwise(source: str | Path, workpiece: BoardOrPart, recipe: Recipe) -> bool:
    """Whether a workpiece is to be read anew for a recipe: as a part in place of a board, or the reverse."""
    return plans_part(str(source), recipe) != isinstance(workpiece, Part)


def plan_workpiece(
    recipe: Recipe,
    workpiece: BoardOrPart,
    progress: Progress,
    sketched: Callable[[Plan], None] | None = None,
    before: PlannedRun | None = None,
) -> PlannedRun:
    """Plan and time a recipe on a board or a part.

    Args:
        recipe: The recipe.
        workpiece: The board or part.
        progress: Receives the stage and the share done.
        sketched: Receives a first plan of a board.
        before: A run whose strokes are taken where nothing changed that they depend on.

    Raises:
        RecipeError: it cannot be planned.
    """
    match workpiece:
        case Part():
            return run_part(recipe, workpiece, progress)
        case _:
            return run(recipe, workpiece, progress, sketched, before if isinstance(before, Run) else None)


def run_of_program(recipe: Recipe, workpiece: BoardOrPart, plan: Plan, program: TimedProgram) -> PlannedRun:
    """A run of a program that was read: with its paths, without what planning finds."""
    match workpiece:
        case Part():
            return PartRun(recipe, workpiece, plan, program, (), ())
        case _:
            return Run(recipe, recipe, workpiece, (), plan, program, ())
