"""The list of components, and the card of the one that is selected."""

from webui.page import Page
from webui.scene import Scene
from webui.session import Session


class ComponentsPanel:
    """The list of components, and the card of the one that is selected."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
