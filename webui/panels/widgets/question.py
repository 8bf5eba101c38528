"""A question in a window of its own: it closes when the answer was taken."""

from collections.abc import Callable, Mapping, Sequence
from html import escape

import viser

from specs.errors import JobError
from webui.forms.refusals import reason_of, remark_html
from webui.page.page import Page
from webui.page.session import Change
from webui.theme.palette import INK, QUIET, to_hex


class Question:
    """Asks for a name, a choice, or only for a decision; a refused answer says why and can be corrected."""

    def __init__(self, page: Page, title: str, note: str = "") -> None:
        """Open a window with a sentence in it; the inputs and answers are added to it."""
        self._page = page
        self._gui = page.client.gui
        self._window = self._gui.add_modal(title)
        self._remark: viser.GuiHtmlHandle | None = None
        with self._window:
            if note:
                style = f"margin:0 10px 10px;font-size:13px;line-height:1.5;color:{to_hex(INK)}"
                self._gui.add_html(f'<div style="{style}">{escape(note)}</div>')
            self._form = self._gui.add_form(None)
        self._name: viser.GuiTextHandle | None = None
        self._choice: viser.GuiDropdownHandle[str] | None = None

    def name(self, label: str, value: str, hint: str) -> "Question":
        """Ask for a text."""
        with self._form:
            self._name = self._gui.add_text(label, value, hint=hint)
        return self

    def choice(self, label: str, options: Sequence[str], hint: str) -> "Question":
        """Ask for one of several; nothing is asked where there is no choice."""
        if options:
            with self._form:
                self._choice = self._gui.add_dropdown(label, tuple(options), hint=hint)
        return self

    def answers(self, answers: Mapping[str, Callable[[str, str], Change]], otherwise: str = "Cancel") -> None:
        """Add a button for each answer and one that gives up; Enter is the first answer.

        Args:
            answers: Label of a button to the edit it makes, from the text and the choice as they stand.
            otherwise: Label of the button that changes nothing.
        """
        first = next(iter(answers.values()))
        self._form.on_submit(lambda _: self._give(first))
        with self._window:
            for index, (label, answer) in enumerate(answers.items()):
                button = self._gui.add_button(label, color=None if index == 0 else QUIET)
                button.on_click(lambda _, answer=answer: self._give(answer))
            self._gui.add_button(otherwise, color=QUIET).on_click(lambda _: self.close())

    def _give(self, answer: Callable[[str, str], Change]) -> None:
        name = "" if self._name is None else self._name.value.strip()
        choice = "" if self._choice is None else self._choice.value
        if self._page.attempt(answer(name, choice), self._refuse):
            self.close()

    def _refuse(self, error: JobError) -> None:
        if self._remark is not None:
            self._remark.remove()
        with self._form:
            self._remark = self._gui.add_html(remark_html(reason_of(error)))

    def close(self) -> None:
        """Ask no longer."""
        if not self._window.closed:
            self._window.close()
