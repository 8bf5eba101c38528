"""The parts, worst first; the card of the selected one, or of the bare board; and the gap under it."""

import viser

from cleaning.verdicts.results import Part, rank_parts
from reports.cards.cleaning import cleaned_component_card, stage_names
from reports.pictures.gap_picture import SIDES
from webui.cards.cleaning_card import parts_html
from webui.cards.gap_svg import SHOWN, drawing_of, gap_html
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import PlaceStepper, offer, on_choice
from webui.scene.scene import Scene
from webui.theme.html import card_html, quiet_html

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
            self._shown: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "In the gap", tuple(SHOWN), hint="Meaning of the colours."
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
