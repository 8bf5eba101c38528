"""Report of tuning: a reason for each component that is not clean yet, and the result as plain data."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from cleaning.verdicts import rules
from cleaning.verdicts.rules import Rule
from rulesengine.tuning.changes.candidate_changes import candidate_changes, expected_share, variables_of
from rulesengine.tuning.trial.request import AllowedChanges, TuningResult, pareto_front
from rulesengine.tuning.trial.requirements import UnmetRequirement
from rulesengine.tuning.variables.design_variables import CHANGE_KINDS
from rulesengine.tuning.variables.recipe_edits import is_kept
from specs.json import Json
from specs.yaml.located import spell_path

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
