"""What an engineer should look at, worst first."""

from webui.page import Page
from webui.scene import Scene
from webui.session import Session


class FindingsPanel:
    """What an engineer should look at, worst first."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
