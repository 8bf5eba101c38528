"""Suggested single edits for components that are not clean, and the predicted effect of each."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from cleaning.analyse import analyse_on
from cleaning.prepared_board import PreparedBoard
from cleaning.verdicts.results import CleaningReport
from cleaning.verdicts.rules import Rule
from recipes.load import parse_recipe
from rulesengine.planning.pipeline import Run, run
from rulesengine.tuning.changes.candidate_changes import candidate_changes
from rulesengine.tuning.trial.outcome import Figures, outcome_of
from rulesengine.tuning.trial.request import AllowedChanges
from rulesengine.tuning.trial.requirements import Goal, UnmetRequirement
from rulesengine.tuning.variables.design_variables import CHANGE_KINDS
from rulesengine.tuning.variables.recipe_edits import Edits, apply_edits
from specs.progress import Progress, no_progress, subprogress
from specs.yaml.located import YamlPath
from specs.yaml.tree import Tree

_MOST = 3
"""Suggestions for one component."""


@dataclass(frozen=True, slots=True)
class Suggestion:
    """One edit of the recipe that may help one component."""

    component: str
    rule: Rule
    """Of its requirement of the most weight."""
    what: str
    """Such as ``"templates.around.passes.small: 2 -> 4"``."""
    edits: Edits
    """Values at paths, all of one edit."""

    @property
    def values(self) -> Mapping[YamlPath, Tree]:
        """Values by path, in the order in which they are to be written."""
        return dict(self.edits)


@dataclass(frozen=True, slots=True, eq=False)
class AnalysedRecipe:
    """A recipe that is being edited, with the analysis of its run."""

    file: Path
    text: str
    run: Run
    report: CleaningReport
    prepared: PreparedBoard


@dataclass(frozen=True, slots=True)
class Effect:
    """Predicted effect of a suggestion."""

    text: str
    """The recipe with the edit."""
    before: Figures
    after: Figures
    resolved: bool
    """Whether the component is clean then."""


def suggest(run: Run, report: CleaningReport, goal: Goal = "clean") -> tuple[Suggestion, ...]:
    """Suggest at most three edits for each component that is not clean, the highest expected gain first.

    Components come in the report's order; there are none for what no recipe can meet. Nothing is analysed.
    """
    outcome = outcome_of(run, report, goal)
    unmet: dict[str, list[UnmetRequirement]] = {}
    for each in outcome.unmet:
        unmet.setdefault(each.component, []).append(each)
    found: list[Suggestion] = []
    for component, own in unmet.items():
        rule = max(own, key=lambda each: each.weight).judgement.rule
        changes = candidate_changes(outcome, own, AllowedChanges(frozenset(CHANGE_KINDS)))
        found += [Suggestion(component, rule, change.what, change.edits) for change in changes[:_MOST]]
    return tuple(found)


def predict(
    suggestion: Suggestion, analysed: AnalysedRecipe, goal: Goal = "clean", progress: Progress = no_progress
) -> Effect:
    """Plan and analyse a recipe with an edit, and compare.

    Raises:
        JobError: the edit cannot be written, or what comes of it cannot be planned or analysed.
    """
    text = apply_edits(analysed.text, analysed.file, suggestion.edits)
    recipe = parse_recipe(text, file=analysed.file)
    planned = run(recipe, analysed.run.board, subprogress(progress, 0.0, 0.3), before=analysed.run)
    report = analyse_on(analysed.prepared, planned.program, planned.recipe, "fast", subprogress(progress, 0.3, 1.0))
    before, after = outcome_of(analysed.run, analysed.report, goal), outcome_of(planned, report, goal, text)
    resolved = all(each.component != suggestion.component for each in after.unmet)
    return Effect(text, before.figures, after.figures, resolved)
