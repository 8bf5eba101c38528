"""Forms for everything a recipe says."""

from webui.page import Page
from webui.scene import Scene
from webui.session import Session


class RecipePanel:
    """Forms for everything a recipe says."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
