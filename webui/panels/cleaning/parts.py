"""What was judged: parts or faces, worst first; cards, gap, helpful changes, and measurements of the selected one."""

from dataclasses import replace

import numpy as np
import viser

from cleaning.part_faces import FaceVerdict, is_held
from cleaning.verdicts.results import Part, rank_parts
from reports.cards.cleaning import cleaned_component_card, stage_names
from reports.cards.measured import measured_card
from reports.pictures.gap_picture import SIDES
from specs.progress import Progress
from washboard.cleaned import FaceReport
from webui.cards.cleaning_card import parts_html, rank_faces, verdict_html, verdicts_html
from webui.cards.gap_svg import SHOWN, drawing_of, gap_html
from webui.layers.surface.stripes import CLEANNESS, cells_glb
from webui.page.measured import comparison_of, read_uploaded
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import PlaceStepper, dropdown, offer, on_choice
from webui.panels.widgets.job import RunButton
from webui.scene.scene import Scene
from webui.theme.html import SQUARE, card_html, legend_html, quiet_html
from webui.tuning.proposal_html import Fix, apply_fix, fix_html

_HINTS = ("Zooms in, and highlights the strokes that spray it.", "The list, from the selected part.")
_STRONGEST = "strongest"
_UNKNOWN: tuple[str, ...] = (_STRONGEST,)
_SIDES: tuple[str, ...] = (_STRONGEST, *SIDES)


class PartsCard:
    """The parts, worst first."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are visible where there is an analysis."""
        self._parts: tuple[Part, ...] = ()
        self._folder = page.client.gui.add_folder("Parts", visible=False)
        with self._folder:
            buttons = {"Worst": 0, "Worse": -1, "Better": 1}
            self._steps = PlaceStepper(page, scene, ("Part", "Through"), _HINTS, buttons)
            self._list = page.client.gui.add_html("")

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        analysis, selected = session.analysis, session.selection.component
        fresh = before is None or analysis is not before.analysis
        if fresh:
            self._folder.visible = analysis is not None
            self._parts = () if analysis is None else tuple(rank_parts(analysis.report))
        if analysis is not None and (fresh or before is None or session.selection != before.selection):
            self._list.content = parts_html(self._parts, selected)
            self._steps.offer([part.component for part in self._parts], selected)


class PartCard:
    """The card of the selected part; of the bare board where none is selected."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; they are visible where there is an analysis."""
        self._folder = page.client.gui.add_folder("Why", visible=False)
        with self._folder:
            self._card = page.client.gui.add_html("")

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        analysis = session.analysis
        if before is not None and analysis is before.analysis and session.selection == before.selection:
            return
        self._folder.visible = analysis is not None
        if analysis is not None:
            part = analysis.part(session.selection.component)
            hint = "" if part else "Choose a part, or click one in the picture. This is the bare board."
            self._card.content = quiet_html(hint) + card_html(
                cleaned_component_card(analysis.report, part or analysis.report.bare)
            )


class GapCard:
    """The gap under the selected part, from above."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; they are visible where the selected part has a gap."""
        gui = page.client.gui
        self._folder = gui.add_folder("Gap from above", visible=False)
        with self._folder:
            self._shown = dropdown(gui, "In the gap", tuple(SHOWN), "Meaning of the colours.")
            self._case = dropdown(gui, "Standoff", _UNKNOWN, "Both bounds, where it is not known; the harder first.")
            self._stage: viser.GuiDropdownHandle[str] = gui.add_dropdown("After", _UNKNOWN, hint="Which stage.")
            self._side = dropdown(gui, "Jet at", _SIDES, "The side from which the flow is shown, as seen from above.")
            self._picture = gui.add_html("")
        for handle in (self._shown, self._case, self._stage, self._side):
            on_choice(handle, lambda _: self._draw(page.session))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.analysis is not before.analysis or session.selection != before.selection:
            self._draw(session)

    def _draw(self, session: Session) -> None:
        """Draw the gap for the present choices, which are kept where possible."""
        analysis = session.analysis
        part = None if analysis is None else analysis.part(session.selection.component)
        self._folder.visible = part is not None and bool(part.gaps)
        if analysis is None or part is None or not part.gaps:
            return
        cases = tuple(f"{1000 * gap.gap_height_mm:.0f} µm" for gap in part.gaps)
        cases = tuple(f"{case} ({number})" if cases.count(case) > 1 else case for number, case in enumerate(cases, 1))
        offer(self._case, cases)
        offer(self._stage, stage_names(analysis.report.stages))
        case, stage = (tuple(each.options).index(each.value) for each in (self._case, self._stage))
        drawing = drawing_of(part, case, stage, self._side.value)
        missing = "This stage does not act on the gap: it blows, or sprays the other side."
        self._picture.content = quiet_html(missing) if drawing is None else gap_html(drawing, SHOWN[self._shown.value])


_FACE_HINTS = ("Zooms in on it.", "The list, from the selected face.")
_LAYER = "/cleanness"


class FacesCard:
    """The verdicts on the faces of a part."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are visible where a part was analysed."""
        self._page, self._scene = page, scene
        self._verdicts: list[FaceVerdict] = []
        gui = page.client.gui
        self._folder = gui.add_folder("Faces", visible=False)
        with self._folder:
            self._colours = gui.add_checkbox("Clean and not clean", True, hint="As colours on the faces.")
            gui.add_html(legend_html(CLEANNESS.items(), SQUARE))
            buttons = {"Worst": 0, "Worse": -1, "Better": 1}
            self._steps = PlaceStepper(page, scene, ("Face", "Step"), _FACE_HINTS, buttons)
            self._list = gui.add_html("")
            self._card = gui.add_html("")
        self._colours.on_update(lambda _: self._draw(page.session))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        analysis, selected = session.face_analysis, session.selection.component
        fresh = before is None or analysis is not before.face_analysis
        if fresh:
            self._folder.visible = analysis is not None
            self._verdicts = [] if analysis is None else rank_faces(analysis.verdicts)
            self._draw(session)
        if analysis is not None and (fresh or before is None or session.selection != before.selection):
            self._list.content = verdicts_html(self._verdicts, selected)
            self._card.content = verdict_html(self._verdicts, selected)
            self._steps.offer(tuple(dict.fromkeys(each.face for each in self._verdicts)), selected)

    def _draw(self, session: Session) -> None:
        """Colour the cells of the faces, or take the colours away."""
        analysis = session.face_analysis
        shown = analysis is not None and analysis.held and self._colours.value
        with self._page.client.atomic():
            self._scene.draw_over(_LAYER, cleanness_glb(analysis) if analysis is not None and shown else b"")


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
        self._folder = gui.add_folder("Fix this", visible=False)
        with self._folder:
            self._run: RunButton[tuple[Fix, ...]] = RunButton(page, SUGGEST, self._begin, _NOTE, CANCEL)
            self._slots = [
                (gui.add_html("", visible=False), gui.add_button(APPLY, visible=False)) for _ in range(_MOST)
            ]
        for number, (_, button) in enumerate(self._slots):
            button.on_click(lambda _, number=number: self._apply(number))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        same = before is not None and session.analysis is before.analysis
        if same and before is not None and session.selection.component == before.selection.component:
            return
        if not same:
            self._found = {}
        self._run.stop()
        part = failing_part(session)
        self._folder.visible = part is not None
        self._show_found(part)

    def _show_found(self, part: Part | None) -> None:
        found = None if part is None else self._found.get(part.component)
        self._run.show(quiet_html(_NOTE if found is None else _TRIED if found else _NOTHING))
        for (text, button), fix in zip(self._slots, [*(found or ())[:_MOST], *[None] * _MOST], strict=False):
            text.visible = button.visible = fix is not None
            text.content = fix_html(fix) if fix is not None else ""

    def _begin(self) -> None:
        session, project = self._page.session, self._page.project
        part, run, analysis = failing_part(session), session.run, session.analysis
        if run is None or analysis is None or part is None:
            return
        component = part.component

        def work(progress: Progress) -> tuple[Fix, ...]:
            from webui.tuning.background import Failing, suggest_fixes

            parameters = project.open_parameters(analysis.parameters_name)
            return suggest_fixes(Failing(component, session.document, run, parameters, analysis), progress)

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
        self._page = page
        gui = page.client.gui
        self._folder = gui.add_folder(None)  # viser does not hide upload buttons themselves
        with self._folder:
            self._upload = gui.add_upload_button(UPLOAD, color="gray", hint=_UPLOAD_HINT)
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
