"""What tuning may propose, made by hand: a slower sweep, with what it did and what is still wanting."""

from dataclasses import fields

from cleaning.verdicts.results import Judgement, Number
from cleaning.verdicts.rules import RESIDUE_LEFT
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import Allowed, Asked, Limits
from rulesengine.tuning.trial.requirements import Want
from rulesengine.tuning.trial.result import Change, Tuned, figures_of
from rulesengine.tuning.variables.design_variables import KINDS
from webui.page.proposal import Proposal

WANT = Want(
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


def outcome(session, text, wants=(), seconds=90.0, litres=2.5):
    """What the page looks at; the rest, by which the search goes, is empty."""
    nothing = {each.name: {} for each in fields(Outcome)}
    told = {
        "text": text, "recipe": session.recipe, "wants": tuple(wants), "residues": {"U1": 0.31 if wants else 0.01},
        "left_out": frozenset(), "total": 5, "seconds": seconds, "litres": litres, "shortfall": float(len(wants)),
    }  # fmt: skip
    return Outcome(**(nothing | told))


def proposal(session, *, wants=(), limits=None, used=7):
    """One change from what the session says now; clean in the end unless something is wanting."""
    text = session.document.text
    first, last = outcome(session, text, (WANT, WANT)), outcome(session, slower(text), wants, 110.0, 3.0)
    change = Change(("templates.sweep.speed_mm_s: 60 -> 45",), figures_of(first), figures_of(last))
    asked = Asked("clean", limits or Limits(), Allowed(frozenset(KINDS)), 40)
    return Proposal(session.document, session.board, "default", Tuned(asked, first, last, (change,), used))
