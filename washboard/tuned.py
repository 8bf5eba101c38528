"""Tuning a recipe until all components are predicted clean, in little time."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from boards.board import Board
from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import Parameters
from cleaning.prepared_board import prepare
from recipes.load import read_recipe_text
from rulesengine.tuning.report import explain
from rulesengine.tuning.trial.record import TrialStore
from rulesengine.tuning.trial.request import AllowedChanges, Trial, TuningRequest, TuningResult, read_limits
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.trial.trial_runner import TrialRunner
from rulesengine.tuning.tune import ignore
from rulesengine.tuning.tune import tune as search
from rulesengine.tuning.variables import read_kept, read_kinds
from specs.progress import Progress, no_progress, subprogress
from specs.rows import Rows
from washboard.inputs import OpenedRecipe, open_cell
from washboard.planned import Planned

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell

KINDS = "speeds,tilts,passes,dwells,heights,sides,wash_time"
"""Kinds of change that are allowed unless others are named."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Tuned:
    """A tuning: the new recipe, what it is predicted to do, and all recipes that were analysed."""

    result: TuningResult
    recipe: OpenedRecipe

    @property
    def clean(self) -> bool:
        """Whether all is predicted clean within the limits."""
        return self.result.last.clean and self.result.within_limits

    @property
    def trials(self) -> Rows[Trial]:
        """All recipes that were analysed, in order."""
        return Rows(self.result.trials)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why requirements are not met; empty where all are."""
        return tuple(map(str, explain(self.result)))

    def __repr__(self) -> str:
        return f"<tuning, {len(self.result.trials)} trials>"

    def _repr_html_(self) -> str:
        last = self.result.last
        words = f"{last.figures.clean_components} of {last.total} clean, {last.seconds:.0f} s, {last.litres:.1f} l"
        return f"<p><b>{words}</b></p>{self.recipe.html()}"


def tune(
    plan: Planned,
    goal: Goal = "clean",
    limits: Mapping[str, float] | None = None,
    parameters: Parameters | str | Path = "default",
    cell: "LoadedCell | str | Path | None" = None,
    progress: Progress = no_progress,
    *,
    allow: str = KINDS,
    keep: Sequence[str] = (),
    analyses: int = 30,
) -> Tuned:
    """Change the recipe of a plan until every component is predicted clean.

    Args:
        plan: Its recipe and its board.
        goal: What is to be met.
        limits: Most of the program: ``{"time": 600, "litres": 20}``.
        parameters: Parameter set: one that is open, the name of one of the library, or a file.
        cell: Cell whose robot it is tuned for.
        progress: Receives the stage and the share done.
        allow: Kinds of change, separated by commas.
        keep: Paths of the recipe, all below which stays.
        analyses: Most analyses.

    Raises:
        JobError: something cannot be used, or the workpiece is no board.
    """
    board, opened = plan.workpiece.require_board("tuning"), plan.opened
    known = parameters if isinstance(parameters, Parameters) else load_parameters(parameters)
    most = read_limits([f"{name}={value:g}" for name, value in (limits or {}).items()])
    allowed = AllowedChanges(read_kinds(allow), read_kept(keep, opened.loaded.root))
    request = TuningRequest(goal, most, allowed, analyses)
    result = search_on(board, opened, request, known, None if cell is None else open_cell(cell), progress)
    text = result.last.text
    return Tuned(result, OpenedRecipe(text, opened.file, read_recipe_text(text, file=opened.file)))


def search_on(
    board: Board,
    opened: OpenedRecipe,
    request: TuningRequest,
    parameters: Parameters,
    cell: "LoadedCell | None",
    progress: Progress = no_progress,
    *,
    store: TrialStore | None = None,
    observe: "Callable[[TrialRunner, TuningResult], None] | None" = None,
) -> TuningResult:
    """As ``tune``, from a request, with records of trials that are kept.

    Args:
        board: Is made ready for the model.
        opened: The recipe.
        request: What counts, what may change, and when to stop.
        parameters: Parameter set.
        cell: Cell whose robot it is tuned for.
        progress: Receives the stage and the share done.
        store: Keeps the records, and has those of a tuning that was interrupted.
        observe: Receives what counts the analyses, and each better result.

    Raises:
        JobError: something cannot be used.
    """
    from robotcell.cell.load import hold_board

    prepared = prepare(board, parameters, subprogress(progress, 0.0, 0.05))
    held = None if cell is None else hold_board(cell, board)
    analyses, rest = request.max_analyses, subprogress(progress, 0.05, 1.0)
    runner = TrialRunner(opened.file, prepared, request.goal, analyses, rest, cell=held)
    if store is not None:
        runner.keep_in(store)
    return search(runner, opened.text, request, ignore if observe is None else partial(observe, runner))
