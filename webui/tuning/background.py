"""Background work of tuning: a proposal for a recipe, and suggested single changes for one part."""

from contextlib import suppress
from dataclasses import dataclass

from boards.board import Board
from cleaning.analyse import analyse_on
from cleaning.parameters.model import Parameters
from cleaning.verdicts.results import CleaningReport
from cleaning.verdicts.rules import WET_GAP
from robotcell.cell.load import LoadedCell
from rulesengine.planning.pipeline import Run
from rulesengine.tuning.suggest import AnalysedRecipe, predict, suggest
from rulesengine.tuning.trial.request import TuningRequest
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.trial.trial_runner import TrialRunner
from rulesengine.tuning.tune import tune
from specs.errors import JobError
from specs.progress import Progress, subprogress
from webui.page.document import Document
from webui.page.evaluations import Analysed, prepare_board
from webui.page.proposal import Proposal
from webui.tuning.accept import Fix


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """A recipe, a board and a tuning request."""

    document: Document
    board: Board
    parameters_name: str
    parameters: Parameters
    request: TuningRequest
    cell: LoadedCell | None = None
    """Whose robot the recipe is tuned for; it holds the board."""


def propose(task: Task, before: Analysed | None, progress: Progress) -> Proposal:
    """Tune a recipe.

    Args:
        task: What to tune.
        before: An analysis whose board may be the same.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the recipe cannot be read, planned or analysed, or the robot cannot carry it out.
    """
    prepared = prepare_board(task.board, task.parameters, before, subprogress(progress, 0.0, 0.1))
    request, part = task.request, subprogress(progress, 0.1, 0.99)
    runner = TrialRunner(task.document.file, prepared, request.goal, request.max_analyses, part, cell=task.cell)
    tuned = tune(runner, task.document.text, task.request)
    return Proposal(task.document, task.board, task.parameters_name, tuned)


@dataclass(frozen=True, slots=True, eq=False)
class Failing:
    """A part that is not clean, with the run and its analysis."""

    component: str
    """``"board"`` for the bare board."""
    document: Document
    run: Run
    parameters: Parameters
    analysed: Analysed
    """Of the run, or of its execution by a robot."""


def suggest_fixes(failing: Failing, progress: Progress) -> tuple[Fix, ...]:
    """Suggest changes for a part with their predicted effects, those that leave the fewest requirements open first.

    Raises:
        JobError: the recipe cannot be analysed.
    """
    recipe = _analysed(failing, subprogress(progress, 0.0, 0.3))
    goal = goal_for(recipe.report, failing.component)
    suggested = [each for each in suggest(recipe.run, recipe.report, goal) if each.component == failing.component]
    found: list[Fix] = []
    for number, each in enumerate(suggested):
        part = subprogress(progress, 0.3 + 0.7 * number / len(suggested), 0.3 + 0.7 * (number + 1) / len(suggested))
        with suppress(JobError):  # of one suggestion among others
            done = predict(each, recipe, goal, part)
            found.append(
                Fix(each.component, each.what, failing.document, done.text, done.before, done.after, done.resolved)
            )
    return tuple(sorted(found, key=lambda fix: (not fix.resolved, fix.after.open_requirements)))


def goal_for(report: CleaningReport, component: str) -> Goal:
    """Goal for a part, such that its open requirements count."""
    part = next((each for each in report.parts if each.component == component), report.bare)
    open_rules = {each.rule for each in part.judgements if each.verdict in ("dirty", "marginal")}
    return "clean-and-dry" if open_rules == {WET_GAP} else "clean"


def _analysed(failing: Failing, progress: Progress) -> AnalysedRecipe:
    """Fast analysis of the planned program, because predictions are fast ones and are compared with it."""
    analysed, run, document = failing.analysed, failing.run, failing.document
    prepared = prepare_board(run.board, failing.parameters, analysed, subprogress(progress, 0.0, 0.5))
    report = analysed.report
    if analysed.effort != "fast" or analysed.program is not run.program:
        report = analyse_on(prepared, run.program, run.recipe, "fast", subprogress(progress, 0.5, 1.0))
    return AnalysedRecipe(document.file, document.text, run, report, prepared)
