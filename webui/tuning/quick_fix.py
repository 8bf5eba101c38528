"""Single changes that may mend one part: what they are predicted to do, and taking one of them."""

from collections.abc import Callable
from dataclasses import dataclass

from rulesengine.tuning.trial.result import Figures
from webui.page.document import Document
from webui.page.proposal import TuningError
from webui.page.session import Session


@dataclass(frozen=True, slots=True)
class Fix:
    """One change of a recipe, and what it is predicted to do."""

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
    mended: bool
    """Whether the part lacks nothing then."""


def apply_fix(fix: Fix) -> Callable[[Session], Session]:
    """Take one change: one edit, which can be undone."""

    def change(session: Session) -> Session:
        if session.document.file != fix.document.file or session.document.text != fix.document.text:
            raise TuningError("The recipe was edited since this was suggested. Undo that, or ask again.")
        return session.edited(fix.text)

    return change
