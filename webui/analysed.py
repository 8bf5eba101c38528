"""What came of analysing a program, as one frozen value."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from cleaning.parameters import Parameters
from cleaning.results import CleaningReport
from geometry.progress import Progress
from programs.program import TimedProgram
from rulesengine.pipeline import Run

Effort: TypeAlias = Literal["sketch", "fast", "full"]

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

    def makers_of(self, component: str) -> frozenset[str]:
        """Name who sprays a component more than a little; nobody where there is no such component."""
        part = next((each for each in self.report.parts if each.component == component), None)
        return frozenset() if part is None else frozenset(name for name, share in part.makers if share >= _LEAST_SHARE)


def analyse_run(run: Run, parameters_name: str, parameters: Parameters, effort: Effort, tell: Progress) -> Analysed:
    """Analyse a program, as the command line does.

    Args:
        run: Its program, board and recipe.
        parameters_name: What the set is called on the page.
        parameters: Of the model.
        effort: How many rays to spend.
        tell: Is told how far it is.

    Raises:
        JobError: the program cannot be analysed with these parameters.
    """
    from cleaning.analyse import analyse  # pyright: ignore[reportAttributeAccessIssue]

    report = analyse(run.program, run.board, run.recipe, parameters, effort=effort, progress=tell)
    return Analysed(run.program, parameters_name, report)
