"""Tuning in the background of a page: its progress is shown, and it stops where it is cancelled."""

from dataclasses import dataclass

from boards.board import Board
from cleaning.parameters.model import Parameters
from rulesengine.tuning.trial.request import TuningRequest
from rulesengine.tuning.trial.trial_runner import TrialRunner
from rulesengine.tuning.tune import tune
from specs.progress import Progress, subprogress
from webui.page.analysed import Analysed, prepare_board
from webui.page.document import Document
from webui.page.proposal import Proposal


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """A recipe, a board and a tuning request."""

    document: Document
    board: Board
    parameters_name: str
    parameters: Parameters
    request: TuningRequest


def propose(task: Task, before: Analysed | None, progress: Progress) -> Proposal:
    """Tune a recipe.

    Args:
        task: What to tune.
        before: An analysis whose board may be the same.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the recipe cannot be read, planned or analysed.
    """
    prepared = prepare_board(task.board, task.parameters, before, subprogress(progress, 0.0, 0.1))
    runner = TrialRunner(
        task.document.file, prepared, task.request.goal, task.request.max_analyses, subprogress(progress, 0.1, 0.99)
    )
    tuned = tune(runner, task.document.text, task.request)
    return Proposal(task.document, task.board, task.parameters_name, tuned)
