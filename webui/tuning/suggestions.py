"""Suggesting single changes for one part beside a page, and predicting what each would do."""

from dataclasses import dataclass

from cleaning.analyse import analyse_on
from cleaning.parameters.model import Parameters
from cleaning.verdicts.results import CleaningReport
from cleaning.verdicts.rules import WET_GAP
from rulesengine.planning.pipeline import Run
from rulesengine.tuning.suggest import Effect, Here, Suggestion, predict, suggest
from rulesengine.tuning.trial.requirements import Goal
from specs.errors import JobError
from specs.progress import Progress, subprogress
from webui.page.analysed import Analysed, make_ready
from webui.page.document import Document
from webui.tuning.quick_fix import Fix


@dataclass(frozen=True, slots=True, eq=False)
class Failing:
    """A part that lacks something, and of what that is known."""

    component: str
    """``"board"`` for the bare board."""
    document: Document
    run: Run
    parameters: Parameters
    analysed: Analysed
    """Of the run, or of what a robot makes of it."""


def suggest_fixes(failing: Failing, progress: Progress) -> tuple[Fix, ...]:
    """Suggest changes for a part, each with what it is predicted to do; what leaves least wanting comes first.

    Raises:
        JobError: the recipe cannot be analysed.
    """
    here = _here(failing, subprogress(progress, 0.0, 0.3))
    goal = goal_for(here.report, failing.component)
    asked = [each for each in suggest(here.run, here.report, goal) if each.component == failing.component]
    found: list[Fix] = []
    for number, each in enumerate(asked):
        part = subprogress(progress, 0.3 + 0.7 * number / len(asked), 0.3 + 0.7 * (number + 1) / len(asked))
        effect = _effect(each, here, goal, part)
        if effect is not None:
            before, after = effect.before, effect.after
            found.append(
                Fix(each.component, each.what, failing.document, effect.text, before, after, mended=effect.mended)
            )
    return tuple(sorted(found, key=lambda fix: (not fix.mended, fix.after.wanting)))


def goal_for(report: CleaningReport, component: str) -> Goal:
    """Choose what counts for a part, so that what it lacks does."""
    part = next((each for each in report.parts if each.component == component), report.bare)
    lacking = {each.rule for each in part.judgements if each.verdict in ("dirty", "marginal")}
    return "clean-and-dry" if lacking == {WET_GAP} else "clean"


def _effect(suggestion: Suggestion, here: Here, goal: Goal, progress: Progress) -> Effect | None:
    try:
        return predict(suggestion, here, goal, progress)
    except JobError:  # there are others
        return None


def _here(failing: Failing, progress: Progress) -> Here:
    """Have a fast analysis of what was planned, because predictions are such and are compared with it."""
    analysed, run, document = failing.analysed, failing.run, failing.document
    prepared = make_ready(run.board, failing.parameters, analysed, subprogress(progress, 0.0, 0.5))
    report = analysed.report
    if analysed.effort != "fast" or analysed.program is not run.program:
        report = analyse_on(prepared, run.program, run.recipe, "fast", subprogress(progress, 0.5, 1.0))
    return Here(document.file, document.text, run, report, prepared)
