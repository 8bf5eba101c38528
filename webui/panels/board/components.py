"""The list of components, and the card of the selected one."""

from webui.cards.component_card import component_html, list_rows, rows_html
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import ComponentStepper
from webui.scene.scene import Scene

_HINTS = (
    "Zooms in and shows the card; a click on a part in the picture does too.",
    "Go through the list, those with findings first.",
)


class ComponentsPanel:
    """The list of components, and the card of the selected one."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui
        self._filter = gui.add_text("Filter", "", hint="Part of a name, package or class, or a pattern such as C1*.")
        self._steps = ComponentStepper(page, scene, ("Go to", "Step"), _HINTS)
        self._list = gui.add_html("")
        with gui.add_folder("Selected part"):
            self._card = gui.add_html("")
        self._filter.on_update(lambda _: self._list_components(page.session))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        same = before is not None and session.board is before.board and session.run is before.run
        if before is None or not same or session.selection != before.selection:
            self._card.content = component_html(session, self._scene.strokes)
            self._list_components(session)

    def _list_components(self, session: Session) -> None:
        rows, selected = list_rows(session, self._filter.value), session.selection.component
        with self._page.client.atomic():
            self._list.content = rows_html(rows, selected)
            self._steps.offer([row.component.name for row in rows], selected)
