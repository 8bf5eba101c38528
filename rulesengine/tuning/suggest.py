"""Suggested single edits for components that are not clean, and the predicted effect of each."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from cleaning.analyse import analyse_on
from cleaning.prepared_board import PreparedBoard
from cleaning.verdicts.results import CleaningReport, Part, deciding_judgement
from cleaning.verdicts.rules import Rule
from programs.program import TimedProgram
from recipes.load import parse_recipe
from recipes.recipe import Recipe
from rulesengine.planning.fit_recipe import fit_recipe
from rulesengine.planning.pipeline import Run, run
from rulesengine.strokes.classify import classify
from rulesengine.tuning.changes.candidate_changes import candidate_changes
from rulesengine.tuning.trial.outcome import Figures, Planned, ReadProgram, outcome_of
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


def suggest(run: Planned, report: CleaningReport, goal: Goal = "clean") -> tuple[Suggestion, ...]:
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


def advise(report: CleaningReport, program: TimedProgram, recipe: Recipe) -> CleaningReport:
    """Add to the advice for each component the edit of the recipe that is expected to help it most, by key and value.

    Components come without one where no recipe can meet what they require. Nothing is analysed.

    Raises:
        RecipeError: a component matches no class.
    """
    fitted = fit_recipe(recipe, report.board)
    classified, _ = classify(fitted, report.board)
    best: dict[str, Suggestion] = {}
    for each in suggest(ReadProgram(recipe, fitted, report.board, classified, program), report):
        best.setdefault(each.component, each)
    parts = tuple(_advised(part, best.get(part.component)) for part in report.parts)
    return replace(report, parts=parts, bare=_advised(report.bare, best.get(report.bare.component)))


def _advised(part: Part, suggestion: Suggestion | None) -> Part:
    """Add a suggestion to the judgement that decides, if it is about what that found."""
    decides = deciding_judgement(part)
    if suggestion is None or suggestion.rule != decides.rule:
        return part
    advised = replace(decides, advice=f"{decides.advice} For example {suggestion.what}.".lstrip())
    return replace(part, judgements=tuple(advised if each is decides else each for each in part.judgements))


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
