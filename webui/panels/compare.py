"""Two recipes on the same board, side by side."""

from webui.page import Page
from webui.scene import Scene
from webui.session import Session


class ComparePanel:
    """Two recipes on the same board, side by side."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
