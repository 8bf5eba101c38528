"""What was judged: parts or faces, worst first; cards, gap, helpful changes, and measurements of the selected one."""

from dataclasses import replace
from functools import partial
from types import MappingProxyType

import numpy as np
import viser

from cleaning.part_faces import is_held
from cleaning.verdicts.results import Part, rank_parts
from reports.cards.cleaning import cleaned_component_card, stage_names
from reports.cards.measured import measured_card
from reports.pictures.gap_picture import SIDES
from specs.progress import Progress
from washboard.cleaned import FaceReport
from webui.cards.drawings import SHOWN, drawing_of, gap_html
from webui.cards.workpiece_card import parts_html, rank_faces, verdict_html, verdicts_html
from webui.layers.surface.ground import CLEANNESS, cells_glb
from webui.page.evaluations import read_uploaded
from webui.page.page import Page
from webui.page.session import Session, comparison_of
from webui.panels.widgets.choices import (
    Buttons,
    PlaceStepper,
    button,
    checkbox,
    dropdown,
    folder,
    html,
    offer,
    show_while,
    upload,
)
from webui.panels.widgets.job import RunButton
from webui.scene.scene import Scene
from webui.theme.html import SQUARE, card_html, legend_html, quiet_html
from webui.tuning.proposal_html import Fix, apply_fix, fix_html

_WORST_FIRST: Buttons = MappingProxyType({"Worst": 0, "Worse": -1, "Better": 1})
_HINTS = ("Zooms in, and highlights the strokes that spray it.", "The list, from the selected part.")
_STRONGEST = "strongest"
_UNKNOWN: tuple[str, ...] = (_STRONGEST,)
_SIDES: tuple[str, ...] = (_STRONGEST, *SIDES)


class PartsCard:
    """The parts, worst first."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are visible where there is an analysis."""
        with folder(page, "Parts", lambda now: now.analysis is not None):
            self._steps = PlaceStepper(page, scene, ("Part", "Through"), _HINTS, _WORST_FIRST)
            self._list = page.client.gui.add_html("")

        def show(session: Session) -> None:
            if session.analysis is not None:
                parts, selected = rank_parts(session.analysis.report), session.selection.component
                self._list.content = parts_html(parts, selected)
                self._steps.offer([part.component for part in parts], selected)

        page.follow(show, _judged)


def _judged(session: Session) -> object:
    return session.current, session.selection


def add_part_card(page: Page) -> None:
    """Build the card of the selected part, or of the bare board; it is visible where there is an analysis."""
    with folder(page, "Why", lambda now: now.analysis is not None):
        html(page, why_html, _judged)


def why_html(session: Session) -> str:
    """Verdict on the selected part and what decides it; of the bare board where none is selected."""
    if session.analysis is None:
        return ""
    report, part = session.analysis.report, session.analysis.part(session.selection.component)
    hint = "" if part else "Choose a part, or click one in the picture. This is the bare board."
    return quiet_html(hint) + card_html(cleaned_component_card(report, part or report.bare))


class GapCard:
    """The gap under the selected part, from above."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; they are visible where the selected part has a gap."""
        gui = page.client.gui

        def redraw(_: object) -> None:
            self._draw(page.session)

        with folder(page, "Gap from above", lambda now: gap_part(now) is not None):
            self._shown = dropdown(gui, "In the gap", SHOWN, "Meaning of the colours.", redraw)
            hint = "Both bounds, where it is not known; the harder first."
            self._case = dropdown(gui, "Standoff", _UNKNOWN, hint, redraw)
            self._stage = dropdown(gui, "After", _UNKNOWN, "Which stage.", redraw)
            hint = "The side from which the flow is shown, as seen from above."
            self._side = dropdown(gui, "Jet at", _SIDES, hint, redraw)
            self._picture = gui.add_html("")
        page.follow(self._draw, _judged)

    def _draw(self, session: Session) -> None:
        """Draw the gap for the present choices, which are kept where possible."""
        analysis, part = session.analysis, gap_part(session)
        if analysis is None or part is None:
            return
        cases = tuple(f"{1000 * gap.gap_height_mm:.0f} µm" for gap in part.gaps)
        cases = tuple(f"{case} ({number})" if cases.count(case) > 1 else case for number, case in enumerate(cases, 1))
        offer(self._case, cases)
        offer(self._stage, stage_names(analysis.report.stages))
        case, stage = (tuple(each.options).index(each.value) for each in (self._case, self._stage))
        drawing = drawing_of(part, case, stage, self._side.value)
        missing = "This stage does not act on the gap: it blows, or sprays the other side."
        self._picture.content = quiet_html(missing) if drawing is None else gap_html(drawing, SHOWN[self._shown.value])


def gap_part(session: Session) -> Part | None:
    """The selected part, if it has a gap that was analysed."""
    part = None if session.analysis is None else session.analysis.part(session.selection.component)
    return part if part is not None and part.gaps else None


_FACE_HINTS = ("Zooms in on it.", "The list, from the selected face.")
_LAYER = "/cleanness"


class FacesCard:
    """The verdicts on the faces of a part."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are visible where a part was analysed."""
        gui = page.client.gui

        def draw(session: Session) -> None:
            """Colour the cells of the faces, or take the colours away."""
            analysis = session.face_analysis
            shown = analysis is not None and analysis.held and colours.value
            with page.client.atomic():
                scene.draw_over(_LAYER, cleanness_glb(analysis) if analysis is not None and shown else b"")

        def show(session: Session) -> None:
            if session.face_analysis is not None:
                verdicts, selected = rank_faces(session.face_analysis.verdicts), session.selection.component
                listed.content = verdicts_html(verdicts, selected)
                card.content = verdict_html(verdicts, selected)
                steps.offer(tuple(dict.fromkeys(each.face for each in verdicts)), selected)

        with folder(page, "Faces", lambda now: now.face_analysis is not None):
            hint = "As colours on the faces."
            colours = checkbox(gui, "Clean and not clean", True, hint, lambda _: draw(page.session))
            gui.add_html(legend_html(CLEANNESS.items(), SQUARE))
            steps = PlaceStepper(page, scene, ("Face", "Step"), _FACE_HINTS, _WORST_FIRST)
            listed, card = gui.add_html(""), gui.add_html("")
        page.follow(draw, lambda now: now.face_analysis)
        page.follow(show, _judged)


def cleanness_glb(analysis: FaceReport) -> bytes:
    """Cells of the sprayed faces in the colours of what is held; of several templates the worst requirement decides."""
    held = np.all([is_held(each) for each in analysis.held], axis=0)
    states = np.asarray(np.where(analysis.survey.visible, np.where(held, 0, 1), 2), dtype=np.int64)
    return cells_glb(analysis.held[0].cells.triangles, states)


SUGGEST, CANCEL, APPLY = "Suggest changes", "Cancel suggesting", "Apply this change"
_MOST = 3
_NOTE = "Tries single changes of the recipe, each with an analysis of its own."
_NOTHING = "No single change was found that helps this part. Tune changes several."
_TRIED = "Tested one at a time, best first."


class FixCard:
    """Fix this: single changes for the selected part, each with its predicted effect."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; they are visible where the selected part is not clean."""
        self._page = page
        self._found: dict[str, tuple[Fix, ...]] = {}
        """By part; of the analysis that is shown."""
        gui = page.client.gui
        with folder(page, "Fix this", lambda now: failing_part(now) is not None):
            self._run: RunButton[tuple[Fix, ...]] = RunButton(page, SUGGEST, self._begin, _NOTE, CANCEL)
            self._slots = [
                (gui.add_html("", visible=False), button(gui, APPLY, partial(self._apply, number), visible=False))
                for number in range(_MOST)
            ]

        def show(session: Session) -> None:
            self._run.stop()
            self._show_found(failing_part(session))

        page.follow(lambda _: self._found.clear(), lambda now: now.analysis)
        page.follow(show, lambda now: (now.analysis, now.selection.component))

    def _show_found(self, part: Part | None) -> None:
        found = None if part is None else self._found.get(part.component)
        self._run.show(quiet_html(_NOTE if found is None else _TRIED if found else _NOTHING))
        for (text, apply), fix in zip(self._slots, [*(found or ())[:_MOST], *[None] * _MOST], strict=False):
            text.visible = apply.visible = fix is not None
            text.content = fix_html(fix) if fix is not None else ""

    def _begin(self) -> None:
        session, project = self._page.session, self._page.project
        part, analysis = failing_part(session), session.analysis
        if session.run is None or analysis is None or part is None:
            return
        component = part.component

        def work(progress: Progress) -> tuple[Fix, ...]:
            from webui.tuning.background import suggest_fixes

            return suggest_fixes(component, session, project.open_parameters(analysis.parameters_name), progress)

        def take(found: tuple[Fix, ...]) -> None:
            now = self._page.session
            if now.analysis is analysis:
                self._found[component] = found
            with self._page.client.atomic():
                self._show_found(failing_part(now))

        self._run.start(work, take)

    def _apply(self, number: int) -> None:
        part = failing_part(self._page.session)
        fixes = self._found.get(part.component, ()) if part is not None else ()
        if number < len(fixes) and self._page.attempt(apply_fix(fixes[number])):
            what = f"{fixes[number].what}. Analyse again to see the effect; Undo takes it back."
            self._page.notify("Changed", what)


def failing_part(session: Session) -> Part | None:
    """The selected part, or the bare board where none is selected, if it is not clean."""
    if session.analysis is None:
        return None
    part = session.analysis.part(session.selection.component) or session.analysis.report.bare
    return part if any(each.verdict in ("dirty", "marginal") for each in part.judgements) else None


UPLOAD = "Compare with measurements"
_UPLOAD_HINT = "CSV: component, method (sir, ic, rose, tear-off), value, unit, limit. Not kept in the project."
_LATER = "Read; it is compared as soon as the program is analysed."


class MeasuredCard:
    """Measured cleanliness of the board's components, compared with the analysis."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open."""

        def read(session: Session, file: viser.UploadedFile) -> Session:
            if session.board is None:  # uploaded before the browser heard of the part
                return session
            return replace(session, measured=read_uploaded(file.name, file.content, session.board))

        def take(file: viser.UploadedFile) -> None:
            page.attempt(lambda session: read(session, file))

        with folder(page, None, lambda now: now.board is not None):  # viser does not hide upload buttons themselves
            upload(page.client.gui, UPLOAD, take, _UPLOAD_HINT, color="gray")
        self._text = html(page, measured_html, lambda now: (now.analysis, now.measured))
        show_while(page, lambda now: now.measured is not None, self._text)


def measured_html(session: Session) -> str:
    """Hit rate, what was predicted otherwise than measured, and what its errors lead to; nothing without a table."""
    found = comparison_of(session)
    if found is None or session.analysis is None:
        return "" if session.measured is None else quiet_html(_LATER)
    return card_html(measured_card(session.analysis.report, *found))
