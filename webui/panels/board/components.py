"""The list of components, and the card of the one that is selected."""

import viser

from webui.cards.component_card import component_html
from webui.cards.component_list import Row, list_rows, rows_html
from webui.cards.table import MOST_ROWS
from webui.forms.dropdown import offer
from webui.page.page import Page
from webui.page.session import Session
from webui.scene.scene import Scene

_NONE = "\N{EN DASH}"
_NOBODY: tuple[str, ...] = (_NONE,)
_BACK, _ON = "Previous", "Next"


class ComponentsPanel:
    """The list of components, and the card of the one that is selected."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._rows: list[Row] = []
        gui = page.client.gui
        self._filter = gui.add_text("Filter", "", hint="Part of a name, package or class, or a pattern such as C1*.")
        self._choice: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Go to", _NOBODY, hint="Flies there and shows the card; a click on a part in the picture does too."
        )
        self._step = gui.add_button_group("Step", (_BACK, _ON), hint="Go through the list, those with findings first.")
        self._list = gui.add_html("")
        with gui.add_folder("Selected part"):
            self._card = gui.add_html("")
        self._filter.on_update(lambda _: self._filter_rows())
        self._choice.on_update(lambda event: self._go(event.target.value, by_hand=event.client is not None))
        self._step.on_click(lambda event: self._go_on(1 if event.target.value == _ON else -1))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        fresh = before is None or session.board is not before.board or session.run is not before.run
        if fresh:
            self._rows = list_rows(session, self._filter.value)
        if fresh or before is None or session.selection != before.selection:
            self._card.content = component_html(session, self._scene.strokes)
            self._show_rows(session)

    def _filter_rows(self) -> None:
        with self._page.client.atomic():
            self._rows = list_rows(self._page.session, self._filter.value)
            self._show_rows(self._page.session)

    def _show_rows(self, session: Session) -> None:
        selected = session.selection.component
        self._list.content = rows_html(self._rows, selected)
        names = (_NONE, *(row.component.name for row in self._rows[:MOST_ROWS]))
        offer(self._choice, names, selected if selected in names else _NONE)

    def _go_on(self, steps: int) -> None:
        """Go to the next part of the list, or the one before; around its end."""
        names = [row.component.name for row in self._rows]
        selected = self._page.session.selection.component
        if names:
            here = names.index(selected) if selected in names else (-1 if steps > 0 else 0)
            self._go(names[(here + steps) % len(names)], by_hand=True)

    def _go(self, name: str, *, by_hand: bool) -> None:
        """Fly to a component that was chosen here; what is selected elsewhere is only shown."""
        session = self._page.session
        component = next((each for each in session.board.components if each.name == name), None)
        if not by_hand or name == session.selection.component:
            return
        if component is not None:
            self._scene.look_at(component, session.board)
        self._page.select(component=name if component is not None else "")
