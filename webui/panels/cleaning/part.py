"""The card of the selected part; of the bare board where none is."""

from webui.cards.boxes import quiet_html
from webui.cards.cleaning_card import part_html
from webui.page.page import Page
from webui.page.session import Session


class PartCard:
    """The card of the selected part; of the bare board where none is."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; they are seen where there is an analysis."""
        self._folder = page.client.gui.add_folder("Why", visible=False)
        with self._folder:
            self._card = page.client.gui.add_html("")

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.analysis is not before.analysis or session.selection != before.selection:
            self._folder.visible = session.analysis is not None
            self._card.content = _content(session)


def _content(session: Session) -> str:
    if session.analysis is None:
        return ""
    report = session.analysis.report
    part = next((each for each in report.parts if each.component == session.selection.component), None)
    if part is not None:
        return part_html(report, part)
    return quiet_html("Choose a part, or click one in the picture. This is the bare board.") + part_html(
        report, report.bare
    )
