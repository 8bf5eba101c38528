"""Faces of a part: the list, the card of one, and the verdicts on all."""

from collections.abc import Sequence

from boards.board import Face, Workpiece
from cleaning.part_faces import FaceVerdict
from cleaning.verdicts.rules import VERDICTS
from reports.cards.cleaning import cleaned_face_card
from reports.cards.workpiece import face_card, kind_of
from reports.tables.run_report import FaceResult, face_results
from reports.tables.table import Column, Table, Text
from webui.cards.finding_list import source_words
from webui.page.session import Session
from webui.theme.html import box_html, card_html, grey_html, listing_html, quiet_html

_FACES = (
    Column("face", width="31%"),
    Column("kind", width="21%"),
    Column("area, mm2", "right", width="25%"),
    Column("stripes", "right", width="23%"),
)
_VERDICTS = (
    Column("face", width="30%"),
    Column("verdict", width="26%"),
    Column("held", "right", width="22%"),
    Column("least", "right", width="22%"),
)


def list_faces(part: Workpiece, pattern: str) -> list[Face]:
    """Faces whose name contains a text, in the order of the file."""
    return [face for face in part.faces if pattern.strip().casefold() in face.name.casefold()]


def faces_html(faces: Sequence[Face], session: Session, selected: str) -> str:
    """The list as a table."""
    if not faces:
        return quiet_html("No face fits. Clear the filter to see all.")
    stripes = {name: sum(each.pieces for each in results) for name, results in _results(session).items()}
    rows = [
        (
            face.name, kind_of(face), f"{face.area_mm2:,.0f}",
            str(stripes.get(face.name, "")) if face.serve else "left out",
        )
        for face in faces
    ]  # fmt: skip
    return listing_html(Table(_FACES, tuple(rows)), selected, height="34vh", more="more; filter to see them")


def face_html(session: Session, name: str) -> str:
    """Card of a face: what it is, and what the plan and the program do to it; what to do where there is none."""
    face = next((each for each in session.workpiece.faces if each.name == name), None)
    if face is None:
        return box_html(grey_html("Click a face in the picture, or choose one above."))
    run = session.run
    about = () if run is None else tuple(each for each in run.findings if name in each.made_by.components)
    return card_html(face_card(face, _results(session).get(name, ()), about))


def rank_faces(verdicts: Sequence[FaceVerdict]) -> list[FaceVerdict]:
    """Worst first: by verdict, then by the share that is held."""
    return sorted(verdicts, key=lambda each: (VERDICTS.index(each.verdict), each.held_share))


def verdicts_html(verdicts: Sequence[FaceVerdict], selected: str) -> str:
    """Verdicts as a table, one row for each face and template."""
    rows = [
        (each.face, Text(each.verdict, tone=each.verdict), f"{each.held_share:.1%}", f"{each.least_s:.2f} s")
        for each in verdicts
    ]
    return listing_html(Table(_VERDICTS, tuple(rows)), selected, height="30vh", more="better ones")


def verdict_html(verdicts: Sequence[FaceVerdict], face: str) -> str:
    """Cards of the verdicts on one face, one for each template; what to do where there is none."""
    cards = (card_html(cleaned_face_card(each, source_words(each.made_by))) for each in verdicts if each.face == face)
    return "".join(cards) or quiet_html("Choose a face, or click one in the picture.")


def _results(session: Session) -> dict[str, list[FaceResult]]:
    """What each template of the newest run does to each face."""
    found: dict[str, list[FaceResult]] = {}
    for covering in session.coverings:
        for result in face_results(session.workpiece, covering):
            found.setdefault(result.face, []).append(result)
    return found
