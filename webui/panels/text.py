"""The recipe as it would be saved; undo, redo, save."""

from webui.page import Page
from webui.scene import Scene
from webui.session import Session


class TextPanel:
    """The recipe as it would be saved; undo, redo, save."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
