"""The paths: colours, legend, what is hidden, the stroke that is selected."""

from webui.page import Page
from webui.scene import Scene
from webui.session import Session


class PathsPanel:
    """The paths: colours, legend, what is hidden, the stroke that is selected."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
