"""The parts, worst first."""

import viser

from cleaning.verdicts.cleanliness import rank_parts
from cleaning.verdicts.results import Part
from webui.cards.cleaning_list import parts_html
from webui.cards.table import MOST_ROWS
from webui.forms.cycle import step_around
from webui.forms.dropdown import offer
from webui.page.page import Page
from webui.page.session import Session
from webui.scene.scene import Scene

_NONE = "\N{EN DASH}"
_NOBODY: tuple[str, ...] = (_NONE,)
_WORST, _WORSE, _BETTER = "Worst", "Worse", "Better"


class PartsCard:
    """The parts, worst first."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are seen where there is an analysis."""
        self._page, self._scene = page, scene
        self._parts: tuple[Part, ...] = ()
        gui = page.client.gui
        self._folder = gui.add_folder("Parts", visible=False)
        with self._folder:
            self._choice: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Part", _NOBODY, hint="Flies there, and lights up the strokes that spray it."
            )
            self._steps = gui.add_button_group(
                "Through", (_WORST, _WORSE, _BETTER), hint="The list, from what is selected."
            )
            self._list = gui.add_html("")
        self._choice.on_update(lambda event: self._go(event.target.value, by_hand=event.client is not None))
        self._steps.on_click(lambda event: self._step(event.target.value))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.analysis is not before.analysis:
            analysis = session.analysis
            self._folder.visible = analysis is not None
            self._parts = () if analysis is None else tuple(rank_parts(analysis.report))
            self._show_parts(session)
        elif session.selection != before.selection:
            self._show_parts(session)

    def _show_parts(self, session: Session) -> None:
        selected, analysis = session.selection.component, session.analysis
        if analysis is None:
            return
        self._list.content = parts_html(self._parts, selected)
        names = (_NONE, *(part.component for part in self._parts[:MOST_ROWS]))
        offer(self._choice, names, selected if selected in names else _NONE)

    def _step(self, button: str) -> None:
        names = [part.component for part in self._parts]
        selected = self._page.session.selection.component
        if names:
            steps = {_WORSE: -1, _BETTER: 1}
            self._go(names[0] if button == _WORST else step_around(names, selected, steps[button]), by_hand=True)

    def _go(self, name: str, *, by_hand: bool) -> None:
        """Fly to a part that was chosen here; what is selected elsewhere is only shown."""
        session = self._page.session
        component = next((each for each in session.board.components if each.name == name), None)
        if not by_hand or (component is None and not session.selection.component):
            return
        if component is not None:
            self._scene.look_at(component, session.board)
        self._page.select(component=name if component is not None else "")
