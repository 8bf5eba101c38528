"""Components and faces as tables and cards: what they are, and what a program cleans."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from boards.board import Component, Face, Workpiece
from cleaning.part_faces import FaceVerdict
from cleaning.verdicts.results import Part, deciding_judgement, outcome
from cleaning.verdicts.rules import VERDICTS
from programs.plan import Dwell
from recipes.recipe import Recipe
from reports.cards.cleaning import cleaned_face_card
from reports.cards.workpiece import component_card, face_card, kind_of, workpiece_card
from reports.tables.run_report import FaceResult, face_results
from reports.tables.table import Column, Table, Text
from specs.finding import Finding, Severity, worst_first
from specs.source import Source
from webui.cards.findings import source_words
from webui.layers.paths.strokes import StrokeLine
from webui.page.session import Session
from webui.theme.html import box_html, card_html, grey_html, listing_html, quiet_html

_DOT = " \N{MIDDLE DOT} "
_WORD = re.compile(r"[^\s+/,;:()'\"]+")
_COLUMNS = (
    Column("part", width="16%"),
    Column("package", width="38%"),
    Column("class", width="25%"),
    Column("h, mm", "right", width="21%", is_name=True),
)
_FACES = (
    Column("face", width="31%"),
    Column("kind", width="21%"),
    Column("area, mm2", "right", width="25%"),
    Column("stripes", "right", width="23%"),
)
_RANK: dict[Severity | None, int] = {"error": 0, "warning": 1, "info": 2, None: 2}


@dataclass(frozen=True, slots=True)
class Listing:
    """Components of a board, or faces of a part."""

    names: tuple[str, ...]
    html: str


def workpiece_html(workpiece: Workpiece) -> str:
    """Card of a board or part: what was understood of it, and the findings of its import."""
    return card_html(workpiece_card(workpiece, rows=0))


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


@dataclass(frozen=True, slots=True)
class Row:
    """One component in the list."""

    component: Component
    component_class: str
    """Empty before the first run."""
    worst: Severity | None
    """Of the errors and warnings about it."""


def list_rows(session: Session, pattern: str) -> list[Row]:
    """Components whose name, package or class contains a text or matches a shell pattern.

    Components with errors come first, then those with warnings; otherwise they stay in the order of the file.
    """
    run, workpiece, sought = session.run, session.workpiece, pattern.strip().casefold()
    classes = {} if run is None else {each.component: each.component_class for each in run.classified}
    findings = workpiece.findings if run is None else run.findings
    about = findings_about([each for each in findings if each.severity != "info"], workpiece.components)
    kept: list[Row] = []
    for each in workpiece.components:
        texts = [text.casefold() for text in (each.name, each.package, classes.get(each.name, ""))]
        as_shell = any(sign in sought for sign in "*?[")
        if any(fnmatchcase(text, sought) if as_shell else sought in text for text in texts):
            worst = worst_first(about.get(each.name, []))
            kept.append(Row(each, classes.get(each.name, ""), worst[0].severity if worst else None))
    return sorted(kept, key=lambda row: _RANK[row.worst])


def findings_about(findings: Iterable[Finding], components: Iterable[Component]) -> dict[str, list[Finding]]:
    """Findings by the component they are about: a stroke around it caused them, or their message names it."""
    names = {component.name for component in components}
    about: dict[str, list[Finding]] = {}
    for finding in findings:
        words = {word.rstrip(".") for word in _WORD.findall(finding.message)}
        named = {word for word in words if any(sign.isdigit() for sign in word)}  # a part called "side" is no word
        for name in {*(finding.made_by.components or named)} & names:
            about.setdefault(name, []).append(finding)
    return about


def rows_html(rows: Sequence[Row], selected: str) -> str:
    """The list as a table."""
    if not rows:
        return quiet_html("No component fits. Clear the filter to see all.")
    cells = [
        (
            Text(row.component.name, tone=row.worst), row.component.package, row.component_class,
            f"{row.component.height_mm:.2f}",
        )
        for row in rows
    ]  # fmt: skip
    return listing_html(Table(_COLUMNS, tuple(cells)), selected, height="34vh", more="more; filter to see them")


def component_html(session: Session, lines: Sequence[StrokeLine]) -> str:
    """Card of the selected component; what to do where none is selected.

    Args:
        session: With the selection.
        lines: The strokes of its run.
    """
    component, run = session.component, session.run
    if component is None:
        return box_html(grey_html("Click a part in the picture, or choose one above."))
    name = component.name
    known, served = None, dict[str, str]()
    if run is not None:
        known = next((each for each in run.classified if each.component == name), None)
        served["served by"] = "\n".join(_passes(name, lines, run.recipe)) or "no pass of its own"
        dwells = [item for item in run.plan.items if isinstance(item, Dwell)]
        pauses = [item.duration_s for item in dwells if name in item.made_by.components]
        served |= {"pauses": f"{len(pauses)}, together {sum(pauses):.1f} s"} if pauses else {}
    findings = session.workpiece.findings if run is None else run.findings
    about = findings_about(findings, [component]).get(name, [])
    return card_html(component_card(component, known, list(served.items()), tuple(about)))


def _passes(name: str, lines: Sequence[StrokeLine], recipe: Recipe) -> list[str]:
    """Step, template, passes and speed of each stroke around a component, in the order of the program."""
    laps: dict[Source, int] = {}
    speeds: dict[Source, float] = {}
    for line in lines:
        if name in line.made_by.components:
            laps[line.made_by] = max(laps.get(line.made_by, 0), line.laps)
            speeds[line.made_by] = line.speed_mm_s
    passes: list[str] = []
    for made_by, count in laps.items():
        others = [each for each in made_by.components if each != name]
        along = f", with {', '.join(others[:3])}{' and more' if len(others) > 3 else ''}" if others else ""
        times = f"{count} passes" if count > 1 else "1 pass"
        number = made_by.step or 0
        place = f"{number + 1} {recipe.sequence[number].function}{_DOT}{made_by.template}"
        passes.append(f"{place}{_DOT}{times} at {speeds[made_by]:g} mm/s{along}")
    return passes


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


def _results(session: Session) -> dict[str, list[FaceResult]]:
    """What each template of the newest run does to each face."""
    found: dict[str, list[FaceResult]] = {}
    for covering in session.coverings:
        for result in face_results(session.workpiece, covering):
            found.setdefault(result.face, []).append(result)
    return found


_JUDGED = (
    Column("part", width="18%"),
    Column("verdict", width="28%"),
    Column("because", width="34%"),
    Column("residue", "right", width="20%"),
)
_VERDICTS = (
    Column("face", width="30%"),
    Column("verdict", width="26%"),
    Column("held", "right", width="22%"),
    Column("least", "right", width="22%"),
)


def parts_html(parts: Sequence[Part], selected: str) -> str:
    """The parts as a table, the selected one marked."""
    if not parts:
        return quiet_html("The board has no parts.")
    rows = [
        (
            part.component, Text(outcome(part), tone=outcome(part)), deciding_judgement(part).name,
            "" if part.residue is None else f"{100 * part.residue:.1f} %",
        )
        for part in parts
    ]  # fmt: skip
    return listing_html(Table(_JUDGED, tuple(rows)), selected, height="26vh", more="better ones")


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
