"""A window that requests a name, a choice or a decision; it closes when the edit was made."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from html import escape

import viser

from specs.errors import JobError
from webui.forms.spec_form import reason_of
from webui.page.page import Page
from webui.page.session import Change, Session
from webui.panels.widgets.choices import button
from webui.theme.html import box_html, quiet_html, remark_html
from webui.theme.palette import QUIET


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
