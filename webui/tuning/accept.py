"""Accepting what tuning found, as one edit or as a new file: a proposal, or a single change for one part."""

from dataclasses import dataclass, replace

from rulesengine.tuning.trial.outcome import Figures
from webui.page.document import Document
from webui.page.project import Project
from webui.page.proposal import TuningError
from webui.page.session import Change, Session


@dataclass(frozen=True, slots=True)
class Fix:
    """One change of a recipe, with its predicted effect."""

    component: str
    """Part that it is suggested for."""
    what: str
    """Such as ``"templates.sweep.speed_mm_s: 60 -> 40"``."""
    document: Document
    """The recipe before it."""
    text: str
    """The recipe with it."""
    before: Figures
    after: Figures
    resolved: bool
    """Whether the part is clean then."""


def apply_fix(fix: Fix) -> Change:
    """Apply one change: one edit, which can be undone."""

    def change(session: Session) -> Session:
        if session.document.file != fix.document.file or session.document.text != fix.document.text:
            raise TuningError("The recipe was edited since this was suggested. Undo that, or suggest again.")
        return session.edited(fix.text)

    return change


def apply_proposal(session: Session) -> Session:
    """Apply the proposed recipe: one edit, which can be undone.

    Raises:
        TuningError: it was edited meanwhile, and these edits would be lost.
    """
    proposal = session.proposal
    if proposal is None:
        return session
    if not proposal.fits(session.document):
        raise TuningError(
            "The text is not the one that was tuned any more. Undo the edits since, save the tuned one as a new "
            "recipe, or discard it and tune again."
        )
    return replace(session.edited(proposal.text), proposal=None)


def save_proposal(project: Project, name: str) -> Change:
    """Write the proposed recipe to a new file of the project, and open that."""

    def change(session: Session) -> Session:
        proposal = session.proposal
        if proposal is None:
            return session
        document = proposal.document.edited(proposal.text).save_as(project.recipe_file(name))
        return replace(session.with_document(document), proposal=None)

    return change
