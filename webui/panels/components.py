"""The list of components, and the card of the one that is selected."""

import viser

from webui.component_card import component_html, list_rows, rows_html
from webui.page import Page
from webui.scene import Scene
from webui.session import Session

_NONE = "none"
_NOBODY: tuple[str, ...] = (_NONE,)
_MOST_CHOICES = 400


class ComponentsPanel:
    """The list of components, and the card of the one that is selected."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui
        self._filter = gui.add_text("Filter", "", hint="Part of a name, package or class, or a pattern such as C1*.")
        self._choice: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Go to", _NOBODY, hint="Flies there and shows the card."
        )
        self._list = gui.add_html("")
        with gui.add_folder("Selected"):
            self._card = gui.add_html("")
        self._filter.on_update(lambda _: self._list_components(page.session))
        self._choice.on_update(lambda event: self._go(event.target.value, by_hand=event.client is not None))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.board is not before.board or session.run is not before.run:
            self._list_components(session)
        if before is None or session.selection != before.selection or session.run is not before.run:
            chosen = session.selection.component
            self._card.content = component_html(session, chosen)
            wanted = chosen if chosen in self._choice.options else _NONE
            if self._choice.value != wanted:
                self._choice.value = wanted

    def _list_components(self, session: Session) -> None:
        rows = list_rows(session, self._filter.value)
        self._list.content = rows_html(rows)
        names = (_NONE, *(row.component.name for row in rows[:_MOST_CHOICES]))
        if tuple(self._choice.options) != names:
            self._choice.options = names

    def _go(self, name: str, *, by_hand: bool) -> None:
        """Fly to a component that was chosen here; what is selected elsewhere is only shown."""
        session = self._page.session
        component = next((each for each in session.board.components if each.name == name), None)
        if not by_hand or name == session.selection.component:
            return
        if component is not None:
            self._scene.look_at(component, session.board)
        self._page.select(component=name if component is not None else "")
