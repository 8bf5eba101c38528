"""Background work of tuning: a proposal for a recipe, and suggested single changes for one part."""

import logging
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from boards.board import Board
from cleaning.analyse import analyse_on
from cleaning.parameters.model import Parameters
from cleaning.verdicts.results import CleaningReport
from cleaning.verdicts.rules import WET_GAP
from reports.files.tuning_state import SUFFIX, StateError, TuningState, fingerprints_of, open_state
from robotcell.cell.load import LoadedCell
from rulesengine.tuning.report import AnalysedRecipe, predict, suggest
from rulesengine.tuning.trial.request import TuningRequest, TuningResult
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.trial.trial_runner import TrialRunner
from rulesengine.tuning.tune import tune
from specs.errors import JobError
from specs.json import content_sha256
from specs.output_file import OutputError, OutputFile, OutputFolder
from specs.progress import Progress, subprogress
from washboard.cleaned import prepare_again
from webui.page.document import Document
from webui.page.evaluations import Analysed, Proposal
from webui.page.session import Session
from webui.tuning.proposal_html import Fix

_FOLDER = Path(".washboard") / "tuning"
_MOST_KEPT = 5
"""Tunings whose trials are kept."""
_log = logging.getLogger(__name__)


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
    project: Path | None = None
    """Folder of the project, where trials are kept until the tuning is done; ``None``: nowhere."""
    take_best: Callable[[Proposal], None] = lambda _: None
    """Receives the best so far, whenever it is another one."""


def propose(task: Task, before: Analysed | None, progress: Progress) -> Proposal:
    """Tune a recipe.

    Args:
        task: What to tune.
        before: An analysis whose board may be the same.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the recipe cannot be read, planned or analysed, or the robot cannot carry it out.
    """
    prepared = prepare_again(task.board, task.parameters, before and before.prepared, subprogress(progress, 0.0, 0.1))
    request, part = task.request, subprogress(progress, 0.1, 0.99)
    runner = TrialRunner(task.document.file, prepared, request.goal, request.max_analyses, part, cell=task.cell)

    def take(so_far: TuningResult) -> None:
        task.take_best(Proposal(task.document, task.board, task.parameters_name, so_far, interrupted=True))

    with _kept(task) as state:
        if state is not None:
            runner.keep_in(state)
        tuned = tune(runner, task.document.text, request, take)
        if state is not None:
            state.remove()
    return Proposal(task.document, task.board, task.parameters_name, tuned)


@contextmanager
def _kept(task: Task) -> Generator[TuningState | None]:
    """Trials of the same tuning that was cancelled, or of a server that ended; ``None`` where they cannot be kept."""
    with ExitStack() as stack:
        state = None
        if task.project is not None:
            recipe = task.document.file, task.document.text
            fingerprints = fingerprints_of(recipe, task.board, task.parameters, task.cell, task.request)
            try:
                place = _place(task.project, content_sha256(dict(fingerprints)))
                state = stack.enter_context(open_state(place, fingerprints, resume=place.exists()))
            except (OSError, StateError, OutputError) as error:
                _log.warning("trials of tuning are not kept: %s", error)
        yield state


def _place(project: Path, digest: str) -> Path:
    """Where trials are kept; of the oldest tunings they go.

    Raises:
        OutputError: the folder cannot be made.
        OSError: it leads out of the project.
    """
    folder = project / _FOLDER
    OutputFolder(folder).make()
    if folder.resolve() != folder:
        raise OSError(f"{folder} leads somewhere else")
    place = folder / f"{digest[:16]}{SUFFIX}"
    others = [path for path in folder.glob(f"*{SUFFIX}") if path != place and not path.is_symlink()]
    for path in sorted(others, key=lambda path: -path.stat().st_mtime_ns)[_MOST_KEPT - 1 :]:
        OutputFile(path).remove()
    return place


def suggest_fixes(component: str, session: Session, parameters: Parameters, progress: Progress) -> tuple[Fix, ...]:
    """Suggest changes for a part with their predicted effects, those that leave the fewest requirements open first.

    Args:
        component: A part that is not clean; ``"board"`` for the bare board.
        session: With the run, and its analysis: of the run, or of its execution by a robot.
        parameters: Those of the analysis.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the recipe cannot be analysed.
    """
    document, run, analysed = session.document, session.run, session.analysis
    if run is None or analysed is None:
        return ()
    prepared = prepare_again(run.board, parameters, analysed.prepared, subprogress(progress, 0.0, 0.15))
    report = analysed.report
    if analysed.effort != "fast" or analysed.program is not run.program:  # predictions are fast ones of the plan
        report = analyse_on(prepared, run.program, run.recipe, "fast", subprogress(progress, 0.15, 0.3))
    recipe = AnalysedRecipe(document.file, document.text, run, report, prepared)
    goal = goal_for(report, component)
    suggested = [each for each in suggest(run, report, goal) if each.component == component]
    found: list[Fix] = []
    for number, each in enumerate(suggested):
        part = subprogress(progress, 0.3 + 0.7 * number / len(suggested), 0.3 + 0.7 * (number + 1) / len(suggested))
        with suppress(JobError):  # of one suggestion among others
            done = predict(each, recipe, goal, part)
            found.append(Fix(component, each.what, document, done.text, done.before, done.after, done.resolved))
    return tuple(sorted(found, key=lambda fix: (not fix.resolved, fix.after.open_requirements)))


def goal_for(report: CleaningReport, component: str) -> Goal:
    """Goal for a part, such that its open requirements count."""
    part = next((each for each in report.parts if each.component == component), report.bare)
    open_rules = {each.rule for each in part.judgements if each.verdict in ("dirty", "marginal")}
    return "clean-and-dry" if open_rules == {WET_GAP} else "clean"
