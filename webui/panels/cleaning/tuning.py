"""Tuning the recipe: the button that opens its window, the work beside the page, and what is done with the result."""

from specs.errors import JobError
from specs.progress import Progress
from webui.cards.boxes import quiet_html
from webui.forms.refusals import reason_of
from webui.page.page import Page
from webui.page.proposal import Proposal, TuningError, Wishes
from webui.page.session import Change, Session
from webui.panels.cleaning.tuning_window import APPLY, CANCEL, CLOSE, DISCARD, SAVE, START, TuningWindow
from webui.panels.widgets.job import Job
from webui.tuning.accept import apply_proposal, save_proposal
from webui.tuning.proposal_html import headline_of


class TuneCard:
    """Tuning the recipe: the button that opens its window, the work beside the page, and the decision."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        self._wishes = Wishes()
        self._window: TuningWindow | None = None
        gui = page.client.gui
        self._button = gui.add_button(
            "Tune\N{HORIZONTAL ELLIPSIS}", hint="Changes the recipe until all that it can clean is predicted clean."
        )
        self._job: Job[Proposal] = Job(page, self._show_progress)
        self._button.on_click(lambda _: self._open())

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is not None and session.board is not before.board and self._job.running:
            self._cancel()
        if before is None or session.proposal is not before.proposal or session.document is not before.document:
            self._job.show(state_html(session))

    def _open(self) -> None:
        self._close()
        self._window = TuningWindow(
            self._page,
            self._wishes,
            {
                START: self._start,
                CANCEL: self._cancel,
                APPLY: lambda: self._take(apply_proposal),
                SAVE: self._save,
                DISCARD: self._discard,
                CLOSE: self._close,
            },
        )
        proposal = self._page.session.proposal
        if self._job.running:
            self._window.show_progress("tuning", 0.0)
        elif proposal is not None:
            self._window.propose(proposal)

    def _close(self) -> None:
        window, self._window = self._window, None
        if window is not None:
            window.close()

    def _start(self) -> None:
        """Begin with the recipe as it is edited now; it need not be planned."""
        if self._window is None:
            return
        self._wishes = self._window.wishes()
        try:
            asked = self._wishes.asked()
        except TuningError as error:
            self._window.ask(str(error))
            return
        session, project = self._page.session, self._page.project
        name = session.parameters_name

        def work(progress: Progress) -> Proposal:
            from webui.tuning.background import Task, propose

            task = Task(session.document, session.board, name, project.open_parameters(name), asked)
            return propose(task, session.analysed, progress)

        self._job.start(work, self._propose, self._ask)

    def _cancel(self) -> None:
        with self._page.client.atomic():
            self._job.stop()
            self._ask("")

    def _propose(self, proposal: Proposal) -> None:
        if proposal.board is not self._page.session.board:  # another one was chosen just now
            return
        self._page.remember(lambda session: session.with_proposal(proposal))
        if self._window is not None:
            with self._page.client.atomic():
                self._window.propose(proposal)

    def _ask(self, remark: str) -> None:
        """Go back to asking."""
        if self._window is not None:
            self._window.ask(remark)

    def _show_progress(self, what: str, done: float) -> None:
        if self._window is not None:
            self._window.show_progress(what, done)

    def _take(self, change: Change) -> None:
        if self._page.attempt(change, self._refuse):
            self._close()

    def _save(self) -> None:
        if self._window is not None:
            self._take(save_proposal(self._page.project, self._window.name))

    def _discard(self) -> None:
        self._page.remember(lambda session: session.with_proposal(None))
        if self._window is not None:
            self._window.ask()

    def _refuse(self, error: JobError) -> None:
        if self._window is not None:
            self._window.refuse(reason_of(error))


def state_html(session: Session) -> str:
    """Say whether a tuned recipe waits for a decision, and of which text it is."""
    proposal = session.proposal
    if proposal is None:
        return ""
    older = "" if proposal.fits(session.document) else " The recipe was edited since."
    return quiet_html(f"Tuned, not applied: {headline_of(proposal.tuned).lower()}{older}")
