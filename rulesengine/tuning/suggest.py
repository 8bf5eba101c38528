"""Single edits for components that are not clean, as the browser offers them, and what each would do."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from cleaning.analyse import analyse_on
from cleaning.prepared_board import PreparedBoard
from cleaning.verdicts.results import CleaningReport
from cleaning.verdicts.rules import Rule
from recipes.load import parse_recipe
from rulesengine.planning.pipeline import Run, run
from rulesengine.tuning.changes.candidate_changes import moves_of
from rulesengine.tuning.trial.outcome import Outcome, outcome_of
from rulesengine.tuning.trial.request import Allowed
from rulesengine.tuning.trial.requirements import Goal, Want
from rulesengine.tuning.trial.result import Figures, figures_of
from rulesengine.tuning.variables.design_variables import KINDS
from rulesengine.tuning.variables.recipe_edits import Edits, apply_edits
from specs.progress import Progress, no_progress, subprogress
from specs.yaml.located import YamlPath
from specs.yaml.tree import Tree

_MOST = 3
"""Suggestions for one component."""
_ALL = Allowed(frozenset(KINDS))


@dataclass(frozen=True, slots=True)
class Suggestion:
    """One edit of the recipe that may help one component."""

    component: str
    rule: Rule
    """What is wanting most there."""
    what: str
    """Such as ``"templates.around.passes.small: 2 -> 4"``."""
    edits: Edits
    """Values at paths, all of one edit."""

    @property
    def values(self) -> Mapping[YamlPath, Tree]:
        """Values by path, in the order in which they are to be written."""
        return dict(self.edits)


@dataclass(frozen=True, slots=True, eq=False)
class Here:
    """A recipe that is being edited, and what it is predicted to clean."""

    file: Path
    text: str
    run: Run
    report: CleaningReport
    prepared: PreparedBoard


@dataclass(frozen=True, slots=True)
class Effect:
    """What a suggestion is predicted to do."""

    text: str
    """The recipe with the edit."""
    before: Figures
    after: Figures
    mended: bool
    """Whether the component lacks nothing then."""


def suggest(run: Run, report: CleaningReport, goal: Goal = "clean") -> tuple[Suggestion, ...]:
    """Suggest edits for each component that is not clean, those believed to help most first; nothing is analysed.

    Args:
        run: A recipe on a board.
        report: What its program cleans.
        goal: What counts; see ``goals``.

    Returns:
        At most three for each component, in the report's order; none where no recipe helps.
    """
    outcome = outcome_of(run, report, goal)
    wants: dict[str, list[Want]] = {}
    for want in outcome.wants:
        wants.setdefault(want.component, []).append(want)
    return tuple(each for lacking in wants.values() for each in _for_one(outcome, lacking))


def _for_one(outcome: Outcome, wants: list[Want]) -> list[Suggestion]:
    heaviest = max(wants, key=lambda want: want.weight)
    moves = moves_of(outcome, wants, _ALL)[:_MOST]
    return [Suggestion(heaviest.component, heaviest.judgement.rule, move.what, move.edits) for move in moves]


def predict(suggestion: Suggestion, here: Here, goal: Goal = "clean", progress: Progress = no_progress) -> Effect:
    """Plan and analyse a recipe with an edit, and compare.

    Raises:
        JobError: the edit cannot be written, or what comes of it cannot be planned or analysed.
    """
    text = apply_edits(here.text, here.file, suggestion.edits)
    planned = run(parse_recipe(text, file=here.file), here.run.board, subprogress(progress, 0.0, 0.3), before=here.run)
    report = analyse_on(here.prepared, planned.program, planned.recipe, "fast", subprogress(progress, 0.3, 1.0))
    before, after = outcome_of(here.run, here.report, goal), outcome_of(planned, report, goal, text)
    mended = all(want.component != suggestion.component for want in after.wants)
    return Effect(text, figures_of(before), figures_of(after), mended)
