"""Accepting a proposal of tuning: as one edit, or as a new file."""

from webui.page.project import Project
from webui.page.proposal import TuningError
from webui.page.session import Change, Session


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
    return session.edited(proposal.text).with_proposal(None)


def save_proposal(project: Project, name: str) -> Change:
    """Write the proposed recipe to a new file of the project, and open that."""
    file = name if name.endswith((".yaml", ".yml")) else f"{name}.yaml"

    def change(session: Session) -> Session:
        proposal = session.proposal
        if proposal is None:
            return session
        document = proposal.document.edited(proposal.text).save_as(project.locate(file))
        return session.with_document(document).with_proposal(None)

    return change
