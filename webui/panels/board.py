"""What is loaded, where it came from, how it is coloured."""

from webui.page import Page
from webui.scene import Scene
from webui.session import Session


class BoardPanel:
    """What is loaded, where it came from, how it is coloured."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
