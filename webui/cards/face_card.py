"""Faces of a part: the list, the card of one, and the verdicts on all."""

from collections.abc import Sequence
from html import escape

from boards.board import Face, Workpiece
from cleaning.part_faces import FaceVerdict, worst_verdict
from cleaning.verdicts.rules import VERDICTS
from reports.tables.part_tables import FACES_CAVEAT, FaceResult, face_results
from reports.tables.table import Column, Table, Text
from webui.cards.finding_list import messages_html, source_words
from webui.page.evaluations import AnalysedFaces
from webui.page.session import Session
from webui.theme.html import box_html, facts_html, grey_html, listing_html, name_html, quiet_html, small_html
from webui.theme.palette import VERDICT_COLOURS, VERDICT_WORDS, css_colour

_MOST_FINDINGS = 5
_FACES = (
    Column("Face", width="31%"),
    Column("Kind", width="21%"),
    Column("Area, mm2", "right", width="25%"),
    Column("Stripes", "right", width="23%"),
)
_VERDICTS = (
    Column("Face", width="30%"),
    Column("Verdict", width="26%"),
    Column("Held", "right", width="22%"),
    Column("Least", "right", width="22%"),
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
            face.name,
            "plane" if face.flat else "curved",
            f"{face.area_mm2:,.0f}",
            str(stripes.get(face.name, "")) if face.serve else "left out",
        )
        for face in faces
    ]
    return listing_html(Table(_FACES, tuple(rows)), selected, height="34vh", more="more; filter to see them")


def face_html(session: Session, name: str) -> str:
    """Card of a face: what it is, and what the plan and the program do to it; what to do where there is none."""
    face = next((each for each in session.workpiece.faces if each.name == name), None)
    if face is None:
        return box_html(grey_html("Click a face in the picture, or choose one above."))
    facts = {
        "Kind": "plane" if face.flat else "curved",
        "Normal": ", ".join(f"{each + 0.0:.2f}" for each in face.normal),
        "Area": f"{face.area_mm2:,.0f} mm2",
        "Sprayed": "yes" if face.serve else "no, the part file leaves it out",
    }
    for number, result in enumerate(_results(session).get(name, ()), start=1):
        facts[f"Plan {number}" if number > 1 else "Plan"] = "\n".join(_planned_words(result))
    run = session.run
    about = [] if run is None else [each for each in run.findings if name in each.made_by.components]
    return box_html(name_html(name) + facts_html(facts) + messages_html(about, _MOST_FINDINGS))


def face_headline_html(analysis: AnalysedFaces) -> str:
    """The worst verdict, the number of faces of each, and what they rest on."""
    worst = worst_verdict(analysis.verdicts)
    counts = [f"{count} {verdict}" for verdict in VERDICTS if (count := _count(analysis.verdicts, verdict))]
    colour = css_colour(VERDICT_COLOURS[worst])
    head = f'<div style="font-weight:600;font-size:14px;color:{colour}">{VERDICT_WORDS[worst]}</div>'
    return box_html(f"{head}{facts_html({'Faces': ', '.join(counts)})}{small_html(escape(FACES_CAVEAT))}")


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
    """Card of the verdicts on one face: required and measured times, what is not seen, and what hides it."""
    own = [each for each in verdicts if each.face == face]
    if not own:
        return quiet_html("Choose a face, or click one in the picture.")
    cards = ""
    for each in own:
        facts = {
            "Template": source_words(each.made_by),
            "Required": f"{each.required_s:g} s in the cone",
            "Held": f"{each.held_share:.1%} of what can be seen",
            "In the cone": f"least {each.least_s:.2f} s, mean {each.mean_s:.2f} s",
            "Visible": f"{each.visible_share:.1%} of {each.area_mm2:,.0f} mm2",
        }
        if each.hidden_by:
            facts["Hidden"] = f"{each.unseen_mm2:,.0f} mm2, by {', '.join(each.hidden_by)}"
        colour = css_colour(VERDICT_COLOURS[each.verdict])
        words = f'<span style="color:{colour};font-weight:600">{VERDICT_WORDS[each.verdict]}</span>'
        cards += name_html(each.face) + words + facts_html(facts)
    return box_html(cards)


def _count(verdicts: Sequence[FaceVerdict], verdict: str) -> int:
    return sum(each.verdict == verdict for each in verdicts)


def _results(session: Session) -> dict[str, list[FaceResult]]:
    """What each template of the newest run does to each face."""
    found: dict[str, list[FaceResult]] = {}
    for covering in session.coverings:
        for result in face_results(session.workpiece, covering):
            found.setdefault(result.face, []).append(result)
    return found


def _planned_words(result: FaceResult) -> list[str]:
    words = [
        f"{result.pieces} stripes and pauses, {result.spray_s:.1f} s",
        f"tilted by at most {result.most_tilt_deg:.1f}\N{DEGREE SIGN}",
        f"{result.held_share:.1%} of what can be seen is held",
    ]
    if result.hidden_by:
        words.append(f"{1 - result.visible_share:.1%} is hidden by {', '.join(result.hidden_by)}")
    return words
