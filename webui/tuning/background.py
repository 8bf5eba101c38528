"""Tuning beside a page: as the command line does it, told how far it is, and stopped where it is no longer wanted."""

from dataclasses import dataclass
from pathlib import Path

from boards.board import Board
from cleaning.parameters.model import Parameters
from cleaning.prepared_board import PreparedBoard
from rulesengine.planning.pipeline import Run
from rulesengine.tuning.trial.request import Asked
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.trial.trial_runner import Bench
from rulesengine.tuning.tune import tune
from specs.progress import Progress, subprogress
from webui.page.analysed import Analysed, make_ready
from webui.page.document import Document
from webui.page.proposal import Proposal


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What to tune, and for what."""

    document: Document
    board: Board
    parameters_name: str
    parameters: Parameters
    asked: Asked


class ToldBench(Bench):
    """Says how many analyses were made whenever a recipe is tried; who is told may stop it there."""

    def __init__(self, file: Path, prepared: PreparedBoard, goal: Goal, most: int, progress: Progress) -> None:
        """Build a bench that reports to ``progress``."""
        super().__init__(file, prepared, goal, most)
        self._callback = progress
        self.progress = self._report

    def planned(self, text: str) -> Run | None:
        """Plan a text as every bench does."""
        self._report("tuning", self.used / self.most)
        return super().planned(text)

    def _report(self, what: str, done: float) -> None:
        self._callback(f"{what}, {self.used} of at most {self.most} analyses", min(1.0, done))


def propose(task: Task, before: Analysed | None, progress: Progress) -> Proposal:
    """Tune a recipe.

    Args:
        task: What, and for what.
        before: An analysis whose board may be the same.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the recipe cannot be read, planned or analysed.
    """
    prepared = make_ready(task.board, task.parameters, before, subprogress(progress, 0.0, 0.1))
    part = subprogress(progress, 0.1, 0.99)
    bench = ToldBench(task.document.file, prepared, task.asked.goal, task.asked.analyses, part)
    tuned = tune(bench, task.document.text, task.asked)
    return Proposal(task.document, task.board, task.parameters_name, tuned)
