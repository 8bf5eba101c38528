"""Tuning beside a page: as the command line does it, told how far it is, and stopped where it is no longer wanted."""

from dataclasses import dataclass

from boards.board import Board
from cleaning.parameters import Parameters
from geometry.progress import Progress, part_of
from rulesengine.pipeline import Run
from rulesengine.tuning.asked import Asked
from rulesengine.tuning.bench import Bench
from rulesengine.tuning.search import tune
from webui.analysed import Analysed, make_ready
from webui.document import Document
from webui.tuning import Proposal


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What to tune, and for what."""

    document: Document
    board: Board
    parameters_name: str
    parameters: Parameters
    asked: Asked


class _ToldBench(Bench):
    """Says how many analyses were made whenever a recipe is tried; who is told may stop it there."""

    told: Progress
    what: str = "looking at the recipe"

    def planned(self, text: str) -> Run | None:
        """Plan a text as every bench does."""
        self.say(self.what)
        return super().planned(text)

    def say(self, what: str) -> None:
        """Tell what is going on."""
        self.what = what
        self.told(f"{what}, {self.used} of at most {self.most} analyses", self.used / self.most)


def propose(task: Task, before: Analysed | None, tell: Progress) -> Proposal:
    """Tune a recipe.

    Args:
        task: What, and for what.
        before: An analysis whose board may be the same.
        tell: Is told how far it is.

    Raises:
        JobError: the recipe cannot be read, planned or analysed.
    """
    subject = make_ready(task.board, task.parameters, before, part_of(tell, 0.0, 0.1))
    bench = _ToldBench(task.document.file, subject, task.asked.goal, task.asked.analyses)
    bench.told = part_of(tell, 0.1, 0.99)
    tuned = tune(bench, task.document.text, task.asked, bench.say)
    return Proposal(task.document, task.board, task.parameters_name, tuned)
