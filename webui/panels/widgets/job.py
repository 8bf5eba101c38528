"""Background work of a panel: its button, its progress, its failure, and the text at rest."""

from collections.abc import Callable
from operator import is_
from typing import Generic, TypeVar

import viser

from specs.errors import JobError
from specs.progress import Progress, no_progress
from webui.page.page import Page
from webui.panels.widgets.choices import button
from webui.theme.html import progress_html, remark_html
from webui.threads.worker import Worker

T = TypeVar("T")
CANCEL = "Cancel"


class Job(Generic[T]):
    """Work in the background, and a line below: its progress, why it failed, else the text at rest."""

    def __init__(
        self,
        page: Page,
        progress: Progress = no_progress,
        refuse: Callable[[str], None] | None = None,
        cancelled: Callable[[], None] | None = None,
    ) -> None:
        """Build the line in the container that is open.

        Args:
            page: The page of the work.
            progress: Receives the stage and the share done, besides the line.
            refuse: Shows why work failed, in place of the line.
            cancelled: Adds a button that cancels the work while it is under way, and is called then.
        """
        self._page, self._refuse = page, refuse
        self._at_rest = ""
        self._subject: tuple[object, ...] | None = None
        self._shown = ("", 0)
        self.running = False
        """Whether work is under way."""

        def show_progress(what: str, done: float) -> None:
            shown = (what, round(100 * done))
            if done < 1.0 and self.running:
                if shown != self._shown or not done:  # a line for each of a million records would choke the connection
                    self._shown, self._line.content = shown, progress_html(what, done)
                progress(what, done)

        self._worker: Worker[T] = Worker(show_progress)
        page.on_close(self._worker.close)
        self._line = page.client.gui.add_html("")
        self._cancel: viser.GuiButtonHandle | None = None
        if cancelled is not None:

            def give_up() -> None:
                self.stop()
                cancelled()

            hint = "Leaves all as it was."
            self._cancel = button(page.client.gui, CANCEL, give_up, hint, visible=False, color="gray")

    def show(self, at_rest: str, subject: tuple[object, ...] | None = None) -> None:
        """Set the HTML at rest, which replaces an older failure.

        Args:
            at_rest: Shown as soon as no work is under way.
            subject: What the HTML describes; for the subject of the last call nothing is done.
        """
        if subject is not None and self._subject is not None and all(map(is_, subject, self._subject)):
            return
        self._at_rest, self._subject = at_rest, subject
        if not self.running:
            self._line.content = at_rest

    def start(
        self, work: Callable[[Progress], T], done: Callable[[T], None], failed: Callable[[str], None] | None = None
    ) -> None:
        """Begin work in place of what is under way.

        Args:
            work: Returns the result.
            done: Takes the result.
            failed: Is called with the reason before it is shown; empty for a defect of ours, which the page reports.
        """

        def end(result: T) -> None:
            self._run(running=False)
            done(result)
            self.show(self._at_rest)

        def fail(error: Exception) -> None:
            self._run(running=False)
            reason = str(error) if isinstance(error, JobError) else ""
            if not reason:
                self._page.report(error)
            with self._page.client.atomic():
                if failed is not None:
                    failed(reason)
                self._line.content = remark_html(reason if self._refuse is None else "") or self._at_rest
                if reason and self._refuse is not None:
                    self._refuse(reason)

        self._run(running=True)
        self._worker.start(work, end, fail)

    def stop(self) -> None:
        """Cancel what is under way, if anything is."""
        if self.running:
            self._worker.cancel()
            with self._page.client.atomic():
                self._run(running=False)
                self.show(self._at_rest)

    def _run(self, *, running: bool) -> None:
        self.running = running
        if self._cancel is not None:
            self._cancel.visible = running


class RunButton(Job[T]):
    """A button that begins work and, while it is under way, cancels it; with the line of the work below."""

    def __init__(self, page: Page, label: str, begin: Callable[[], None], hint: str, cancel: str = CANCEL) -> None:
        """Build button and line in the container that is open.

        Args:
            page: The page of the work.
            label: Of the button at rest.
            begin: Is called when the button is pressed; it calls ``start``, or raises why it cannot.
            hint: Of the button.
            cancel: Label while work is under way.
        """
        self._labels = label, cancel

        def press() -> None:
            if self.running:
                self.stop()
                return
            try:
                begin()
            except JobError as error:
                page.report(error)

        self.handle = button(page.client.gui, label, press, hint)
        super().__init__(page)

    def _run(self, *, running: bool) -> None:
        super()._run(running=running)
        self.handle.label = self._labels[running]
