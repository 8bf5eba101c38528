"""The workpiece on the page, board or part: its card, and the list and the card of what can be chosen on it."""

from collections.abc import Sequence
from dataclasses import dataclass

from boards.board import Workpiece
from reports.tables.part_tables import part_facts
from reports.tables.run_report import board_facts
from specs.finding import worst_first
from webui.cards.component_card import component_html, list_rows, rows_html
from webui.cards.face_card import face_html, faces_html, list_faces
from webui.cards.finding_list import messages_html, tally
from webui.layers.paths.strokes import StrokeLine
from webui.page.session import Session
from webui.theme.html import box_html, facts_html, name_html

_MOST_FINDINGS = 5


@dataclass(frozen=True, slots=True)
class Listing:
    """Components of a board, or faces of a part."""

    names: tuple[str, ...]
    html: str


def workpiece_html(workpiece: Workpiece) -> str:
    """Card of a board or part: what was understood of it, and the findings of its import."""
    known = dict(part_facts(workpiece)) if workpiece.faces else board_facts(workpiece.require_board("this"))
    facts = {name.capitalize(): value for name, value in known.items() if name != "sha256"}
    facts["Findings"] = tally(workpiece.findings)
    found = messages_html(worst_first(workpiece.findings), _MOST_FINDINGS)
    return box_html(name_html(workpiece.name) + facts_html(facts) + found)


def list_places(session: Session, pattern: str) -> Listing:
    """What can be chosen and fits a filter, as a table with the selected one marked."""
    selected = session.selection.component
    if session.workpiece.faces:
        faces = list_faces(session.workpiece, pattern)
        return Listing(tuple(face.name for face in faces), faces_html(faces, session, selected))
    rows = list_rows(session, pattern)
    return Listing(tuple(row.component.name for row in rows), rows_html(rows, selected))


def place_html(session: Session, lines: Sequence[StrokeLine]) -> str:
    """Card of the selected component or face.

    Args:
        session: With the selection.
        lines: The strokes of its run.
    """
    if session.workpiece.faces:
        return face_html(session, session.selection.component)
    return component_html(session, lines)
