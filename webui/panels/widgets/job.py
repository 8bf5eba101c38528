"""Work that somebody asks for and waits for: the button, how far it is, and why it came to nothing."""

from collections.abc import Callable
from html import escape
from typing import Generic, TypeVar

from specs.errors import JobError
from specs.progress import Progress, no_progress
from webui.cards.boxes import box_html
from webui.forms.refusals import remark_html
from webui.page.page import Page
from webui.theme.palette import ACCENT, QUIET, to_hex
from webui.threads.worker import Worker

T = TypeVar("T")
_CANCEL = "Cancel"


def _leave(_remark: str) -> None:
    """Do nothing about work that came to nothing."""


class Job(Generic[T]):
    """Work beside the page, and the line that tells of it: how far it is, why it came to nothing, else what holds."""

    def __init__(self, page: Page, progress: Progress = no_progress) -> None:
        """Build the line in the container that is open.

        Args:
            page: Whose work it is.
            progress: Receives it too.
        """
        self._page, self._progress = page, progress
        self._holds = ""
        self._running = False
        self._worker: Worker[T] = Worker(self._show_progress)
        page.on_close(self._worker.close)
        self._line = page.client.gui.add_html("")

    @property
    def running(self) -> bool:
        """Whether the work is under way."""
        return self._running

    def show(self, holds: str) -> None:
        """Say what holds, as soon as nothing is under way; why older work came to nothing is forgotten."""
        self._holds = holds
        if not self._running:
            self._line.content = holds

    def start(
        self, work: Callable[[Progress], T], done: Callable[[T], None], failed: Callable[[str], None] = _leave
    ) -> None:
        """Begin; what was under way is given up.

        Args:
            work: What to do.
            done: Takes the result.
            failed: Hears why there is none, before it is shown; empty for a defect of ours, which the page reports.
        """
        self._running = True
        self._worker.start(work, lambda result: self._end(done, result), lambda error: self._fail(error, failed))

    def stop(self) -> None:
        """Give up what is under way, if anything is."""
        if self._running:
            self._worker.cancel()
            self._running = False
            self.show(self._holds)

    def _end(self, done: Callable[[T], None], result: T) -> None:
        self._running = False
        done(result)
        self.show(self._holds)

    def _fail(self, error: Exception, failed: Callable[[str], None]) -> None:
        self._running = False
        remark = str(error) if isinstance(error, JobError) else ""
        if not remark:
            self._page.report(error)
        with self._page.client.atomic():
            failed(remark)
            self._line.content = remark_html(remark) if remark else self._holds

    def _show_progress(self, what: str, done: float) -> None:
        if done < 1.0 and self._running:
            self._line.content = progress_html(what, done)
            self._progress(what, done)


class RunButton(Generic[T]):
    """A button that begins work and, while that is under way, gives it up; the line beneath tells of it."""

    def __init__(self, page: Page, label: str, begin: Callable[[], None], hint: str, cancel: str = _CANCEL) -> None:
        """Build button and line in the container that is open.

        Args:
            page: Whose work it is.
            label: Of the button at rest.
            begin: Is called when somebody wants the work; it calls ``start``, or says why not.
            hint: What the button is for.
            cancel: Label while the work is under way.
        """
        self._page, self._begin = page, begin
        self._labels = label, cancel
        self.handle = page.client.gui.add_button(label, hint=hint)
        self._job: Job[T] = Job(page)
        self.handle.on_click(lambda _: self.stop() if self._job.running else self._begin())

    def show(self, holds: str) -> None:
        """Say what holds, as soon as nothing is under way; why older work came to nothing is forgotten."""
        self._job.show(holds)

    def start(
        self, work: Callable[[Progress], T], done: Callable[[T], None], failed: Callable[[str], None] = _leave
    ) -> None:
        """Begin; the same as for a job."""

        def end(result: T) -> None:
            self.handle.label = self._labels[0]
            done(result)

        def fail(remark: str) -> None:
            self.handle.label = self._labels[0]
            failed(remark)

        self.handle.label = self._labels[1]
        self._job.start(work, end, fail)

    def stop(self) -> None:
        """Give up what is under way, if anything is."""
        with self._page.client.atomic():
            self.handle.label = self._labels[0]
            self._job.stop()


def progress_html(what: str, done: float) -> str:
    """Say how far work is."""
    return box_html(
        f'<div style="color:{to_hex(QUIET)}">{escape(what.capitalize())}\N{HORIZONTAL ELLIPSIS} {done:.0%}</div>'
        '<div style="height:3px;border-radius:2px;margin-top:4px;background:#e6eaed"><div style="height:3px;'
        f'border-radius:2px;width:{100 * min(max(done, 0.03), 1.0):.0f}%;background:{to_hex(ACCENT)}"></div></div>'
    )
