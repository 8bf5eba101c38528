"""The verdicts on the faces of a part: a table worst first, the card of one, and what is clean as colours."""

import numpy as np

from cleaning.part_faces import FaceVerdict, is_held
from washboard.cleaned import FaceReport
from webui.cards.face_card import rank_faces, verdict_html, verdicts_html
from webui.layers.surface.stripes import CLEANNESS, cells_glb
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import PlaceStepper
from webui.scene.scene import Scene
from webui.theme.html import SQUARE, legend_html

_HINTS = ("Zooms in on it.", "The list, from the selected face.")
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
            self._steps = PlaceStepper(page, scene, ("Face", "Step"), _HINTS, buttons)
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
