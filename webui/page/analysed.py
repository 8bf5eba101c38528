"""What came of analysing a program, as one frozen value."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from cleaning.parameters.model import Parameters
from cleaning.verdicts.results import CleaningReport
from programs.program import TimedProgram
from rulesengine.planning.pipeline import Run
from specs.progress import Progress, subprogress

if TYPE_CHECKING:
    from boards.board import Board
    from cleaning.analyse import Effort
    from cleaning.prepared_board import PreparedBoard

_LEAST_SHARE = 0.1
"""Of the volume on a part: strokes that give less are not named."""


@dataclass(frozen=True, slots=True, eq=False)
class Analysed:
    """A program and what it cleans."""

    program: TimedProgram
    """The very one: another one with the same moves is another one."""
    parameters_name: str
    """As the project lists it."""
    report: CleaningReport
    prepared: "PreparedBoard | None" = None
    """The board made ready: the next program on it need not wait for that."""
    effort: "Effort" = "fast"

    def makers_of(self, component: str) -> frozenset[str]:
        """Name who sprays a component more than a little; nobody where there is no such component."""
        part = next((each for each in self.report.parts if each.component == component), None)
        return frozenset() if part is None else frozenset(name for name, share in part.makers if share >= _LEAST_SHARE)


@dataclass(frozen=True, slots=True)
class Asked:
    """How to analyse."""

    parameters_name: str
    """As the project lists it."""
    parameters: Parameters
    effort: "Effort"


def analyse_run(run: Run, asked: Asked, before: Analysed | None, progress: Progress) -> Analysed:
    """Analyse a program, as the command line does.

    Args:
        run: Its program, board and recipe.
        asked: With which parameters, and how thoroughly.
        before: An analysis whose board may be the same.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the program cannot be analysed with these parameters.
    """
    from cleaning.analyse import analyse_on

    prepared = make_ready(run.board, asked.parameters, before, subprogress(progress, 0.0, 0.2))
    report = analyse_on(prepared, run.program, run.recipe, asked.effort, subprogress(progress, 0.2, 1.0))
    return Analysed(run.program, asked.parameters_name, report, prepared, asked.effort)


def make_ready(board: "Board", parameters: Parameters, before: Analysed | None, progress: Progress) -> "PreparedBoard":
    """Make a board ready for analyses with some parameters, unless it is already."""
    from cleaning.prepared_board import prepare

    known = None if before is None else before.prepared
    if known is not None and known.board is board and known.parameters == parameters:
        return known
    return prepare(board, parameters, progress)
