"""A proposal of tuning made by hand: a slower sweep, with its effect and an open requirement."""

from dataclasses import fields

from cleaning.verdicts.results import Judgement, Number
from cleaning.verdicts.rules import RESIDUE_LEFT
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import (
    AcceptedChange,
    AllowedChanges,
    ProgramLimits,
    Trial,
    TuningRequest,
    TuningResult,
)
from rulesengine.tuning.trial.requirements import UnmetRequirement
from rulesengine.tuning.variables import CHANGE_KINDS
from webui.page.evaluations import Proposal

UNMET = UnmetRequirement(
    "U1",
    Judgement(
        rule=RESIDUE_LEFT,
        verdict="dirty",
        numbers=(Number("residue", 31.0, "%", 20.0),),
        because="31 % is left <here>.",
        advice="Wash on.",
    ),
    0.5,
)


def slower(text):
    """The text of ``smt-aqueous`` with another speed of its sweep."""
    before, after = "speed_mm_s: 60", "speed_mm_s: 45"
    assert before in text
    return text.replace(before, after, 1)


def outcome(session, text, unmet=(), seconds=90.0, litres=2.5):
    """What the page shows; the rest, which the search needs, is empty."""
    nothing = {each.name: {} for each in fields(Outcome)}
    shown = {
        "text": text, "recipe": session.recipe, "unmet": tuple(unmet), "residues": {"U1": 0.31 if unmet else 0.01},
        "excluded": frozenset(), "total": 5, "seconds": seconds, "litres": litres, "shortfall": float(len(unmet)),
    }  # fmt: skip
    return Outcome(**(nothing | shown))


def proposal(session, *, unmet=(), limits=None, used=7):
    """One change of the session's recipe; clean in the end unless requirements are open."""
    text = session.document.text
    first, last = outcome(session, text, (UNMET, UNMET)), outcome(session, slower(text), unmet, 110.0, 3.0)
    change = AcceptedChange(("templates.sweep.speed_mm_s: 60 -> 45",), first.figures, last.figures)
    trials = tuple(Trial(each.text, each.figures, 0.0 if each.unmet else 1.02) for each in (first, last))
    request = TuningRequest("clean", limits or ProgramLimits(), AllowedChanges(frozenset(CHANGE_KINDS)), 40)
    result = TuningResult(request, first, last, (change,), used, ended=("Nothing saves 1 %.",), trials=trials)
    return Proposal(session.document, session.board, "default", result)
