"""Edits that an earlier server did not save are offered again; those of this page are kept meanwhile."""

from webui.page.browser_identity import Visitor
from webui.page.drafts import Draft, Drafts
from webui.page.page import Page
from webui.page.session import Change, Session
from webui.panels.widgets.question import Question
from webui.threads.worker import Worker


class Unsaved:
    """Keeps what is not saved, beside the page: nobody waits for the disk."""

    def __init__(self, page: Page, drafts: Drafts, visitor: Visitor) -> None:
        """Know who edits, and where that is kept."""
        self._page, self._drafts, self._visitor = page, drafts, visitor
        self._worker: Worker[None] = Worker(lambda _what, _done: None)

    def show(self, session: Session, before: Session | None) -> None:
        """Keep the text of a session, or nothing when it is saved; offer at first what was left behind."""
        document = session.document
        if before is None and not document.dirty:
            draft = self._drafts.left_by(self._visitor, document.file)
            if draft is not None and draft.text != document.text:
                self._offer(draft)
        elif before is None or document is not before.document:
            self._worker.start(lambda _progress: self._keep(session, before), lambda _: None, self._page.report)

    def _keep(self, session: Session, before: Session | None) -> None:
        document = session.document
        if before is not None and before.document.file != document.file:
            self._drafts.forget(self._visitor, before.document.file)
        if document.dirty:
            self._drafts.keep(self._visitor, document.file, document.text)
        else:
            self._drafts.forget(self._visitor, document.file)

    def _offer(self, draft: Draft) -> None:
        name = self._page.session.document.file.name
        note = f"The server ended before your edits of {name} were saved. They are from {draft.written}."
        question = Question(self._page, "Unsaved edits", note)
        restored, gone = self._restored(draft), self._gone(draft)
        question.answers({"Restore them": lambda _name, _choice: restored, "Discard them": lambda _name, _choice: gone})

    def _restored(self, draft: Draft) -> Change:
        def change(session: Session) -> Session:
            after = session.edited(draft.text)
            self._drafts.discard(draft)
            return after

        return change

    def _gone(self, draft: Draft) -> Change:
        def change(session: Session) -> Session:
            self._drafts.discard(draft)
            return session

        return change
