"""The remedy that a check in a cell found: its edits, and the button that makes them."""

from html import escape

from robotcell.cell.cell_edits import describe_edits
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import button, html, show_while
from webui.theme.html import box_html, small_html

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
