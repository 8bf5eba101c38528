"""Suggested single changes for one part, with the predicted effect of each; in the background of a page."""

from dataclasses import dataclass

from cleaning.analyse import analyse_on
from cleaning.parameters.model import Parameters
from cleaning.verdicts.results import CleaningReport
from cleaning.verdicts.rules import WET_GAP
from rulesengine.planning.pipeline import Run
from rulesengine.tuning.suggest import AnalysedRecipe, Effect, Suggestion, predict, suggest
from rulesengine.tuning.trial.requirements import Goal
from specs.errors import JobError
from specs.progress import Progress, subprogress
from webui.page.analysed import Analysed, prepare_board
from webui.page.document import Document
from webui.tuning.quick_fix import Fix


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
        effect = _effect(each, recipe, goal, part)
        if effect is not None:
            before, after = effect.before, effect.after
            found.append(
                Fix(each.component, each.what, failing.document, effect.text, before, after, resolved=effect.resolved)
            )
    return tuple(sorted(found, key=lambda fix: (not fix.resolved, fix.after.open_requirements)))


def goal_for(report: CleaningReport, component: str) -> Goal:
    """Goal for a part, such that its open requirements count."""
    part = next((each for each in report.parts if each.component == component), report.bare)
    open_rules = {each.rule for each in part.judgements if each.verdict in ("dirty", "marginal")}
    return "clean-and-dry" if open_rules == {WET_GAP} else "clean"


def _effect(suggestion: Suggestion, recipe: AnalysedRecipe, goal: Goal, progress: Progress) -> Effect | None:
    try:
        return predict(suggestion, recipe, goal, progress)
    except JobError:  # there are others
        return None


def _analysed(failing: Failing, progress: Progress) -> AnalysedRecipe:
    """Fast analysis of the planned program, because predictions are fast ones and are compared with it."""
    analysed, run, document = failing.analysed, failing.run, failing.document
    prepared = prepare_board(run.board, failing.parameters, analysed, subprogress(progress, 0.0, 0.5))
    report = analysed.report
    if analysed.effort != "fast" or analysed.program is not run.program:
        report = analyse_on(prepared, run.program, run.recipe, "fast", subprogress(progress, 0.5, 1.0))
    return AnalysedRecipe(document.file, document.text, run, report, prepared)
