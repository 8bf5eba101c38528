"""Measured cleanliness of the board's components, compared with the analysis."""

from dataclasses import replace

import viser

from reports.cards.measured import measured_card
from webui.page.measured import comparison_of, read_uploaded
from webui.page.page import Page
from webui.page.session import Session
from webui.theme.html import card_html, quiet_html

UPLOAD = "Compare with measurements"
_HINT = "CSV: component, method (sir, ic, rose, tear-off), value, unit, limit. Not kept in the project."
_LATER = "Read; it is compared as soon as the program is analysed."


class MeasuredCard:
    """Measured cleanliness of the board's components, compared with the analysis."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        gui = page.client.gui
        self._folder = gui.add_folder(None)  # viser does not hide upload buttons themselves
        with self._folder:
            self._upload = gui.add_upload_button(UPLOAD, color="gray", hint=_HINT)
        self._text = gui.add_html("", visible=False)
        self._upload.on_upload(lambda event: self._take(event.target.value))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.board is not before.board:
            self._folder.visible = session.board is not None
        same = before is not None and session.analysis is before.analysis and session.measured is before.measured
        if not same:
            self._text.content = measured_html(session)
            self._text.visible = session.measured is not None

    def _take(self, file: viser.UploadedFile) -> None:
        def read(session: Session) -> Session:
            if session.board is None:  # uploaded before the browser heard of the part
                return session
            return replace(session, measured=read_uploaded(file.name, file.content, session.board))

        self._page.attempt(read)


def measured_html(session: Session) -> str:
    """Hit rate, what was predicted otherwise than measured, and what its errors lead to; nothing without a table."""
    found = comparison_of(session)
    if found is None or session.analysis is None:
        return "" if session.measured is None else quiet_html(_LATER)
    return card_html(measured_card(session.analysis.report, *found))
