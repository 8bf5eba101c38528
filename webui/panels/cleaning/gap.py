"""The gap under the selected part, from above."""

import viser

from cleaning.verdicts.results import Part
from reports.pictures.gap_picture import SIDES
from webui.cards.boxes import quiet_html
from webui.cards.cleaning_card import stage_names
from webui.cards.gap_svg import SHOWN, drawing_of, gap_html
from webui.page.page import Page
from webui.page.session import Session

_STRONGEST = "strongest"
_UNKNOWN: tuple[str, ...] = (_STRONGEST,)
_SIDES: tuple[str, ...] = (_STRONGEST, *SIDES)


class GapCard:
    """The gap under the selected part, from above."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; they are seen where the selected part has a gap."""
        self._page = page
        gui = page.client.gui
        self._folder = gui.add_folder("Gap from above", visible=False)
        with self._folder:
            self._shown: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "In the gap", tuple(SHOWN), hint="What the colours mean."
            )
            self._case: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Standoff", _UNKNOWN, hint="Both bounds, where it is not known; the harder first."
            )
            self._stage: viser.GuiDropdownHandle[str] = gui.add_dropdown("After", _UNKNOWN, hint="Which stage.")
            self._side: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Jet at", _SIDES, hint="The side from which the flow is shown, as seen from above."
            )
            self._picture = gui.add_html("")
        for handle in (self._shown, self._case, self._stage, self._side):
            handle.on_update(lambda event: self._draw(page.session) if event.client is not None else None)

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.analysis is not before.analysis or session.selection != before.selection:
            self._offer(session)
            self._draw(session)

    def _offer(self, session: Session) -> None:
        """Offer the cases and stages that there are; what was chosen stays where it can."""
        part, analysis = _part(session), session.analysis
        self._folder.visible = part is not None
        if part is None or analysis is None:
            return
        cases = tuple(f"{1000 * gap.gap_height_mm:.0f} µm" for gap in part.gaps)
        cases = tuple(f"{case} ({number})" if cases.count(case) > 1 else case for number, case in enumerate(cases, 1))
        for handle, options in ((self._case, cases), (self._stage, stage_names(analysis.report.stages))):
            if tuple(handle.options) != options:
                handle.options = options

    def _draw(self, session: Session) -> None:
        part = _part(session)
        if part is None:
            return
        case, stage = (tuple(each.options).index(each.value) for each in (self._case, self._stage))
        drawing = drawing_of(part, case, stage, self._side.value)
        missing = "This stage does not act on the gap: it blows, or sprays the other side."
        self._picture.content = quiet_html(missing) if drawing is None else gap_html(drawing, SHOWN[self._shown.value])


def _part(session: Session) -> Part | None:
    """Give the selected part, where it was analysed and has a gap."""
    if session.analysis is None:
        return None
    parts = session.analysis.report.parts
    return next((each for each in parts if each.component == session.selection.component and each.gaps), None)
