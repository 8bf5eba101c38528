"""What a panel does in the background, what it requests in a window, and the remedy that a check found."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from html import escape
from operator import is_
from typing import Generic, TypeVar

import viser

from robotcell.cell.cell_edits import describe_edits
from specs.errors import JobError
from specs.progress import Progress, no_progress
from webui.forms.spec_form import reason_of
from webui.page.page import Page
from webui.page.session import Change, Session
from webui.panels.widgets.choices import button, html, show_while
from webui.theme.html import box_html, progress_html, quiet_html, remark_html, small_html
from webui.theme.palette import QUIET
from webui.threads.threads import Worker

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


class Dialog:
    """A window with inputs and buttons; a refused edit shows the reason and can be corrected."""

    def __init__(self, page: Page, title: str, note: str = "") -> None:
        """Open a window with a sentence; inputs and buttons are added to it."""
        self._page = page
        self._gui = page.client.gui
        self._window = self._gui.add_modal(title)
        self._remark: viser.GuiHtmlHandle | None = None
        with self._window:
            if note:
                self._gui.add_html(box_html(escape(note), "margin:0 10px 10px;font-size:13px"))
            self._form = self._gui.add_form(None)
        self._name: viser.GuiTextHandle | None = None
        self._choice: viser.GuiDropdownHandle[str] | None = None

    def name(self, label: str, value: str, hint: str) -> "Dialog":
        """Add a text input."""
        with self._form:
            self._name = self._gui.add_text(label, value, hint=hint)
        return self

    def choice(
        self,
        label: str,
        options: Sequence[str],
        hint: str,
        chosen: str = "",
        describe: Callable[[str], str] | None = None,
    ) -> "Dialog":
        """Add a dropdown; none where there are no options.

        Args:
            label: Of the dropdown.
            options: Its options.
            hint: Its hint.
            chosen: The one that is chosen first, where it is among them; else their first.
            describe: Gives the sentence that is shown below for an option.
        """
        if not options:
            return self
        first = chosen if chosen in options else options[0]
        with self._form:
            choice = self._gui.add_dropdown(label, tuple(options), initial_value=first, hint=hint)
            self._choice = choice
            if describe is not None:
                about = self._gui.add_html(quiet_html(describe(first)))

                def show() -> None:
                    about.content = quiet_html(describe(choice.value))

                choice.on_update(lambda _: show())
        return self

    def buttons(self, edits: Mapping[str, Callable[[str, str], Change]], otherwise: str = "Cancel") -> None:
        """Add a button for each edit and one that makes none; Enter makes the first.

        Args:
            edits: Edit by the label of its button, from the text and the choice of the inputs.
            otherwise: Label of the button that makes none.
        """
        first = next(iter(edits.values()))
        self._form.on_submit(lambda _: self._submit(first))
        with self._window:
            for label, edit in edits.items():
                button(self._gui, label, partial(self._submit, edit), color=None if edit is first else QUIET)
            button(self._gui, otherwise, self.close, color=QUIET)

    def button(self, label: str, begin: Callable[[str], object]) -> None:
        """Add a button that begins something with the choice and makes no edit, and one that does nothing."""

        def edit(_name: str, choice: str) -> Change:
            def change(session: Session) -> Session:
                begin(choice)
                return session

            return change

        self.buttons({label: edit})

    def _submit(self, edit: Callable[[str, str], Change]) -> None:
        def refuse(error: JobError) -> None:
            if self._remark is not None:
                self._remark.remove()
            with self._form:
                self._remark = self._gui.add_html(remark_html(reason_of(error)))

        name = "" if self._name is None else self._name.value.strip()
        choice = "" if self._choice is None else self._choice.value
        if self._page.attempt(edit(name, choice), refuse):
            self.close()

    def close(self) -> None:
        """Close the window."""
        if not self._window.closed:
            self._window.close()


APPLY = "Apply the remedy"


class RemedyButton:
    """The remedy of the newest check with its edits, and a button that writes them and checks again."""

    def __init__(self, page: Page) -> None:
        """Build both in the container that is open; they are visible where there is a remedy."""

        def apply() -> None:
            check, before = page.session.check, page.session.cell_name
            if check is None or check.report.remedy is None:
                return
            edits = check.report.remedy.edits
            if page.attempt(lambda session: session.edit_cell(edits, page.project)):
                name = page.session.cell_name
                what = f"{name} is written" if name == before else f"{name}, a copy of {before}, is written"
                page.notify("Remedy applied", f"{what} and checked. Undo takes it back.")
                page.check()

        html(page, remedy_html, lambda session: session.check)
        show_while(
            page,
            remedy_html,
            button(page.client.gui, APPLY, apply, "Writes the cell, then checks; Undo takes it back."),
        )


def remedy_html(session: Session) -> str:
    """The edits of the remedy that a check found, each with the line of the cell; empty where there is none."""
    check = session.check
    remedy = None if check is None else check.report.remedy
    if check is None or remedy is None or not remedy.edits:
        return ""
    file = check.cell.root.mark.file
    lines = [each.removeprefix(f"{file}:") for each in describe_edits(check.cell.root, remedy.edits)]
    rows = "".join(f"<div>Line {escape(line)}</div>" for line in lines)
    return box_html(
        f"Remedy: {escape(remedy.text)}.<div style='font-size:11px;font-family:monospace'>{rows}</div>"
        f"{small_html('The cell is a model: the real one has to be changed alike.')}"
    )
