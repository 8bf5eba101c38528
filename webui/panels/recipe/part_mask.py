"""Masks of the selected part: one click keeps the spray off it, leaves it out, or requires that it is cleaned."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from recipes.recipe import Recipe
from webui.page.page import Page
from webui.page.session import Session

Treatment: TypeAlias = Literal["avoid", "ignore", "clean"]
_MASK: dict[str, Treatment] = {"Avoid": "avoid", "Ignore": "ignore", "Must clean": "clean"}
_UNMASK: dict[Treatment, str] = {"avoid": "Do not avoid", "ignore": "Do not ignore", "clean": "Need not clean"}
_HINT = (
    "Mask of the selected part. Avoid: the wave front keeps out, the jet closes. Ignore: no pass of its own. "
    "Must clean: a finding if no pass serves it."
)


@dataclass(frozen=True, slots=True)
class OwnMask:
    """A mask of the recipe for one part alone."""

    place: int
    """Among the masks of the recipe."""
    treatment: Treatment


def own_mask(recipe: Recipe, part: str) -> OwnMask | None:
    """The first mask that names this part and nothing else, if there is one."""
    for place, mask in enumerate(recipe.masks):
        for treatment in _MASK.values():
            if getattr(mask, treatment) == [part]:
                return OwnMask(place, treatment)
    return None


def mask_part(session: Session, part: str, treatment: Treatment) -> Session:
    """Session with a mask for one part, after the others.

    Raises:
        RecipeError: the recipe would not be one.
    """
    return session.insert(("masks", len(session.recipe.masks)), {treatment: [part]})


class PartMask:
    """Buttons that mask the selected part, or take its own mask out; hidden while no part is selected."""

    def __init__(self, page: Page) -> None:
        """Build the buttons in the container that is open."""
        self._page = page
        self._buttons = page.client.gui.add_button_group("Mask", tuple(_MASK), visible=False, hint=_HINT)
        self._buttons.on_click(lambda event: self._press(event.target.value))

    def show(self, session: Session) -> None:
        """Show a session."""
        part = session.component if session.shown is None else None
        if self._buttons.visible != (part is not None):
            self._buttons.visible = part is not None
        if part is None:
            return
        own = own_mask(session.recipe, part.name)
        options = tuple(_MASK) if own is None else (_UNMASK[own.treatment],)
        if tuple(self._buttons.options) != options:
            self._buttons.options = options
        label = f"Mask {part.name}"
        if self._buttons.label != label:
            self._buttons.label = label

    def _press(self, button: str) -> None:
        def change(session: Session) -> Session:
            part = session.component
            own = None if part is None else own_mask(session.recipe, part.name)
            if part is None or (own is None) != (button in _MASK):  # clicked before the browser heard of the last edit
                return session
            if own is not None:
                return session.remove(("masks", own.place))
            return mask_part(session, part.name, _MASK[button])

        self._page.attempt(change)
