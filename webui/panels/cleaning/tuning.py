"""Tuning the recipe: the button that opens its window, the job in the background, and the decision on its proposal."""

from specs.errors import JobError
from specs.progress import Progress
from webui.forms.spec_form import reason_of
from webui.page.page import Page
from webui.page.proposal import Proposal, TuningError, TuningSettings
from webui.page.session import Change, Session
from webui.panels.cleaning.tuning_window import APPLY, CANCEL, CLOSE, DISCARD, SAVE, START, TuningWindow
from webui.panels.widgets.job import Job
from webui.theme.html import quiet_html
from webui.tuning.accept import apply_proposal, save_proposal
from webui.tuning.proposal_html import headline_of


class TuneCard:
    """Tuning the recipe: the button that opens its window, the job in the background, and the decision."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        self._settings = TuningSettings()
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
            self._settings,
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
        self._settings = self._window.settings()
        try:
            request = self._settings.request()
        except TuningError as error:
            self._window.show_form(str(error))
            return
        session, project = self._page.session, self._page.project
        name = session.parameters_name

        def work(progress: Progress) -> Proposal:
            from webui.tuning.background import Task, propose

            task = Task(session.document, session.board, name, project.open_parameters(name), request)
            return propose(task, session.analysed, progress)

        self._job.start(work, self._propose, self._show_form)

    def _cancel(self) -> None:
        with self._page.client.atomic():
            self._job.stop()
            self._show_form("")

    def _propose(self, proposal: Proposal) -> None:
        if proposal.board is not self._page.session.board:  # another one was chosen just now
            return
        self._page.remember(lambda session: session.with_proposal(proposal))
        if self._window is not None:
            with self._page.client.atomic():
                self._window.propose(proposal)

    def _show_form(self, remark: str) -> None:
        if self._window is not None:
            self._window.show_form(remark)

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
            self._window.show_form()

    def _refuse(self, error: JobError) -> None:
        if self._window is not None:
            self._window.refuse(reason_of(error))


def state_html(session: Session) -> str:
    """Whether a tuned recipe waits for a decision, and whether it is of the present text."""
    proposal = session.proposal
    if proposal is None:
        return ""
    older = "" if proposal.fits(session.document) else " The recipe was edited since."
    return quiet_html(f"Tuned, not applied: {headline_of(proposal.tuned).lower()}{older}")
