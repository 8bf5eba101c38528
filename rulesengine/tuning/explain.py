"""Why a tuned recipe does not clean everything: component, rule, and what stands in the way."""

from dataclasses import dataclass

from cleaning.verdicts.rules import PLUGGED_GAP, SPENT_BATH, Rule
from rulesengine.tuning.changes.candidate_changes import knobs_for, moves_of
from rulesengine.tuning.changes.expected_effect import helps
from rulesengine.tuning.trial.request import Allowed
from rulesengine.tuning.trial.requirements import Want
from rulesengine.tuning.trial.result import Tuned
from rulesengine.tuning.variables.design_variables import KINDS
from rulesengine.tuning.variables.recipe_edits import is_kept
from specs.yaml.located import spell_path

_BEYOND = {
    PLUGGED_GAP: "No recipe opens a plugged gap: it takes other paste, pads or standoff.",
    SPENT_BATH: "No recipe changes the bath.",
}
_NEAR = 0.95
"""From this share of a limit on, the limit is what stands in the way."""
_MOST_NAMED = 4


@dataclass(frozen=True, slots=True)
class Reason:
    """What is wanting of one component, and why it stays so."""

    component: str
    rule: Rule
    name: str
    because: str
    """The judgement's own sentence."""
    why: str
    """Why the recipe could not be tuned further for it."""


def explain(tuned: Tuned) -> tuple[Reason, ...]:
    """Give one reason for each component that is still wanting: for what lacks most of it."""
    heaviest: dict[str, Want] = {}
    for want in tuned.last.wants:
        known = heaviest.get(want.component)
        if known is None or want.weight > known.weight:
            heaviest[want.component] = want
    return tuple(
        Reason(name, want.judgement.rule, want.judgement.name, want.judgement.because, _why(tuned, want))
        for name, want in heaviest.items()
    )


def is_unfinished(tuned: Tuned) -> bool:
    """Say whether something is still wanting for which more analyses may find a change."""
    return tuned.spent and bool(tuned.last.mendable)


def _beyond(tuned: Tuned, want: Want) -> str:
    """Say what it takes where no recipe helps; nothing where one may."""
    return "" if want in tuned.last.mendable else _BEYOND.get(want.judgement.rule, want.judgement.advice)


def _why(tuned: Tuned, want: Want) -> str:
    beyond = _beyond(tuned, want)
    if beyond:
        return beyond
    parts = [_forbidden(tuned, want), _limited(tuned), _ended(tuned, want)]
    told = " ".join(part for part in parts if part)
    return told or want.judgement.advice


def _forbidden(tuned: Tuned, want: Want) -> str:
    """Name the kinds of change that are believed to help and were not allowed, and what was kept."""
    allowed = tuned.asked.allowed
    everything = Allowed(frozenset(KINDS))
    moves = moves_of(tuned.last, [want], everything)
    kinds = list(dict.fromkeys(move.kind for move in moves if move.kind not in allowed.kinds))
    kept = [
        spell_path(path)
        for path in allowed.kept
        if any(is_kept(edit, (path,)) for move in moves if move.kind in allowed.kinds for edit, _ in move.edits)
    ]
    told = f"Not allowed, though it may help: {', '.join(kinds)}." if kinds else ""
    return told + (" " if told and kept else "") + (f"Kept, though it may help: {', '.join(kept)}." if kept else "")


def _limited(tuned: Tuned) -> str:
    limits, last = tuned.asked.limits, tuned.last
    told: list[str] = []
    if limits.seconds is not None and last.seconds >= _NEAR * limits.seconds:
        told.append(f"the limit on time, {limits.seconds:g} s, leaves no more of it")
    if limits.litres is not None and last.litres >= _NEAR * limits.litres:
        told.append(f"the limit on litres, {limits.litres:g} l, leaves no more of them")
    return f"Besides, {' and '.join(told)}." if told else ""


def _ended(tuned: Tuned, want: Want) -> str:
    bounds = _at_bound(tuned, want)
    told = f"At their bounds: {', '.join(bounds)}." if bounds else ""
    if tuned.spent:
        return f"{told} The {tuned.asked.analyses} analyses were spent.".strip()
    moves = moves_of(tuned.last, [want], tuned.asked.allowed)
    return f"{told} None of the changes that are allowed takes it away.".strip() if moves or bounds else told


def _at_bound(tuned: Tuned, want: Want) -> list[str]:
    """Name numbers that are believed to help and cannot go further."""
    found = [
        f"{spell_path(knob.path)} {knob.value:g}"
        for knob in knobs_for(tuned.last)
        if knob.kind in tuned.asked.allowed.kinds
        and helps(knob, want, tuned.last) > 0
        and knob.value == (knob.most if knob.gain > 0 else knob.least)
    ]
    return found[:_MOST_NAMED]
