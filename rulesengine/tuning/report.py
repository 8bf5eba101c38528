"""Report of tuning: a reason for each component that is not clean yet, and the result as plain data.

And suggested single edits for components that are not clean, with the predicted effect of each.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from cleaning.analyse import analyse_on
from cleaning.prepared_board import PreparedBoard
from cleaning.verdicts import rules
from cleaning.verdicts.results import CleaningReport, Part, deciding_judgement
from cleaning.verdicts.rules import Rule
from programs.program import TimedProgram
from recipes.load import parse_recipe
from recipes.recipe import Recipe
from rulesengine.planning.fit_recipe import fit_recipe
from rulesengine.planning.pipeline import Run, run
from rulesengine.strokes.classify import classify
from rulesengine.tuning.changes.candidate_changes import candidate_changes, expected_share, variables_of
from rulesengine.tuning.trial.outcome import Figures, Planned, ReadProgram, outcome_of
from rulesengine.tuning.trial.request import AllowedChanges, TuningResult, pareto_front
from rulesengine.tuning.trial.requirements import Goal, UnmetRequirement
from rulesengine.tuning.variables import CHANGE_KINDS, Edits, apply_edits, is_kept
from specs.json import Json
from specs.progress import Progress, no_progress, subprogress
from specs.yaml.located import YamlPath, spell_path
from specs.yaml.tree import Tree

VERSION = 1
"""Of the data: it changes when a key changes its meaning or goes."""
_UNATTAINABLE = {
    rules.PLUGGED_GAP: "No recipe opens a plugged gap: it takes other paste, pads or standoff.",
    rules.SPENT_BATH: "No recipe changes the bath.",
}
_NEAR = 0.95
"""From this share of a limit on, the limit is a reason."""
_MOST_NAMED = 4


@dataclass(frozen=True, slots=True)
class Reason:
    """The requirement of a component that is not met, and why tuning could not meet it."""

    component: str
    rule: Rule
    name: str
    because: str
    """The judgement's own sentence."""
    why: str
    """Why the recipe could not be tuned further for it."""


def explain(result: TuningResult) -> tuple[Reason, ...]:
    """One reason for each component that is not clean yet: for its requirement of the most weight."""
    heaviest: dict[str, UnmetRequirement] = {}
    for unmet in result.last.unmet:
        heaviest[unmet.component] = max(heaviest.get(unmet.component, unmet), unmet, key=lambda each: each.weight)
    return tuple(
        Reason(name, unmet.rule, unmet.judgement.name, unmet.judgement.because, _why(result, unmet))
        for name, unmet in heaviest.items()
    )


def describe_end(result: TuningResult) -> str:
    """Why tuning ended, in sentences."""
    request = result.request
    if result.out_of_analyses:
        return f"The {request.max_analyses} analyses are spent."
    met = [] if result.last.attainable else ["All that a recipe can meet is met."]
    return " ".join([*met, *result.ended])


def is_unfinished(result: TuningResult) -> bool:
    """Whether requirements are not met yet for which more analyses may find a change."""
    return result.out_of_analyses and bool(result.last.attainable)


def _why(result: TuningResult, unmet: UnmetRequirement) -> str:
    judgement = unmet.judgement
    if unmet not in result.last.attainable:
        return _UNATTAINABLE.get(judgement.rule, judgement.advice)
    limits, last = result.request.limits, result.last
    reached: list[str] = []
    if limits.seconds is not None and last.seconds >= _NEAR * limits.seconds:
        reached.append(f"the limit on time, {limits.seconds:g} s, leaves no more of it")
    if limits.litres is not None and last.litres >= _NEAR * limits.litres:
        reached.append(f"the limit on litres, {limits.litres:g} l, leaves no more of them")
    besides = [f"Besides, {' and '.join(reached)}."] if reached else []
    # Kinds of change that are expected to help and were not allowed, and paths that were kept.
    allowed = result.request.allowed
    changes = candidate_changes(result.last, [unmet], AllowedChanges(frozenset(CHANGE_KINDS)))
    kinds = list(dict.fromkeys(change.kind for change in changes if change.kind not in allowed.kinds))
    edits = [edit for change in changes if change.kind in allowed.kinds for edit, _ in change.edits]
    kept = [spell_path(path) for path in allowed.kept if any(is_kept(edit, (path,)) for edit in edits)]
    sentences = [f"Not allowed, though it may help: {', '.join(kinds)}."] if kinds else []
    sentences += [f"Kept, though it may help: {', '.join(kept)}."] if kept else []
    return " ".join([*sentences, *besides, *_end_of_search(result, unmet)]) or judgement.advice


def _end_of_search(result: TuningResult, unmet: UnmetRequirement) -> list[str]:
    """Variables that are expected to help and are at their bounds, and why the search ended."""
    last, request = result.last, result.request
    bounds = [
        f"{spell_path(variable.path)} {variable.value:g}"
        for variable in variables_of(last)
        if variable.kind in request.allowed.kinds
        and expected_share(variable, unmet, last) > 0
        and variable.value == (variable.upper if variable.direction > 0 else variable.lower)
    ]
    sentences = [f"At their bounds: {', '.join(bounds[:_MOST_NAMED])}."] if bounds else []
    if result.robot is not None and result.robot.infeasible:
        robot = result.robot
        sentences.append(f"Left out, because {robot.name} cannot carry them out: {robot.infeasible} candidates.")
    if result.out_of_analyses:
        return [*sentences, f"The {request.max_analyses} analyses were spent."]
    if bounds or candidate_changes(last, [unmet], request.allowed):
        return [*sentences, "None of the allowed changes meets it."]
    return sentences


def tuning_report(result: TuningResult, reasons: Sequence[Reason], diff: str) -> dict[str, Json]:
    """The request, the changes and the result as plain data; the same tuning gives the same data."""
    request, last = result.request, result.last
    numbers = {each.text: number for number, each in enumerate(pareto_front(result.trials), 1)}
    return {
        "washboard_tuning": VERSION,
        "for": request.goal,
        "clean": last.clean,
        "kinetics_calibrated": result.calibrated,
        "within_limits": result.within_limits,
        "limits": {"time": request.limits.seconds, "litres": request.limits.litres},
        "allowed": [str(kind) for kind in sorted(request.allowed.kinds)],
        "robot": None if result.robot is None else asdict(result.robot),
        "worth": asdict(request.worth),
        "analyses": {"used": result.used, "most": request.max_analyses},
        "ended": describe_end(result),
        "components": last.total,
        "left_out": list[Json](sorted(last.excluded)),
        "before": asdict(result.first.figures),
        "after": asdict(last.figures),
        "changes": [asdict(each) | {"what": list[Json](each.what)} for each in result.changes],
        "unmet": [asdict(each) | {"rule": each.rule.id} for each in reasons],
        "trials": [
            {**asdict(each.figures), "margin": each.margin, "front": numbers.get(each.text)} for each in result.trials
        ],
        "residues": dict[str, Json]({name: float(f"{share:.6g}") for name, share in last.residues.items()}),
        "diff": diff,
    }


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
