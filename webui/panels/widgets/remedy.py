"""The remedy that a check in a cell found: its edits, and the button that makes them."""

from html import escape

from robotcell.cell.cell_edits import describe_edits
from webui.page.page import Page
from webui.page.session import Session
from webui.theme.html import box_html, small_html

APPLY = "Apply the remedy"


class RemedyButton:
    """The remedy of the newest check with its edits, and a button that writes them and checks again."""

    def __init__(self, page: Page) -> None:
        """Build both in the container that is open; they are visible where there is a remedy."""
        self._page = page
        gui = page.client.gui
        self._text = gui.add_html("")
        self._button = gui.add_button(APPLY, visible=False, hint="Writes the cell, then checks; Undo takes it back.")
        self._button.on_click(lambda _: self._apply())

    def show(self, session: Session) -> None:
        """Show the remedy of a session."""
        self._text.content = remedy_html(session)
        self._button.visible = bool(self._text.content)

    def _apply(self) -> None:
        """Write the remedy into the cell, and check the program in it."""
        check, before = self._page.session.check, self._page.session.cell_name
        if check is None or check.report.remedy is None:
            return
        edits = check.report.remedy.edits
        if self._page.attempt(lambda session: session.edit_cell(edits, self._page.project)):
            name = self._page.session.cell_name
            what = f"{name} is written" if name == before else f"{name}, a copy of {before}, is written"
            self._page.notify("Remedy applied", f"{what} and checked. Undo takes it back.")
            self._page.check()


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
