"""Single changes that may make one part clean: their predicted effect, and applying one of them."""

from collections.abc import Callable
from dataclasses import dataclass

from rulesengine.tuning.trial.outcome import Figures
from webui.page.document import Document
from webui.page.proposal import TuningError
from webui.page.session import Session


@dataclass(frozen=True, slots=True)
class Fix:
    """One change of a recipe, with its predicted effect."""

    component: str
    """Part that it is suggested for."""
    what: str
    """Such as ``"templates.sweep.speed_mm_s: 60 -> 40"``."""
    document: Document
    """What would be changed."""
    text: str
    """The recipe with it."""
    before: Figures
    after: Figures
    resolved: bool
    """Whether the part is clean then."""


def apply_fix(fix: Fix) -> Callable[[Session], Session]:
    """Apply one change: one edit, which can be undone."""

    def change(session: Session) -> Session:
        if session.document.file != fix.document.file or session.document.text != fix.document.text:
            raise TuningError("The recipe was edited since this was suggested. Undo that, or suggest again.")
        return session.edited(fix.text)

    return change
