"""Controls made together with what they do: buttons, dropdowns that follow the session, steppers, allowed rules."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, TypeVar

import viser

from specs.finding import Finding
from webui.cards.finding_list import name_findings
from webui.page.page import Page
from webui.scene.scene import Scene

T = TypeVar("T")
NONE: str = "\N{EN DASH}"
_NOTHING: tuple[str, ...] = (NONE,)
_MOST_NAMED = 500
"""Names in a dropdown; the buttons step through all."""
_PICK = '<div class="wb-pick"></div>'
"""The text that follows is not seen: the page writes the row of a listing there that is clicked."""
Buttons = Mapping[str, int | Callable[[], None]]
"""Steps by the label of their button, 0 for the first of the list; or another action."""
BACK_AND_ON: Buttons = MappingProxyType({"Previous": -1, "Next": 1})


def button(
    gui: viser.GuiApi, label: str, press: Callable[[], None], hint: str | None = None, **looks: Any
) -> viser.GuiButtonHandle:
    """A button that calls a function without arguments; its looks are those of ``add_button``."""
    handle = gui.add_button(label, hint=hint, **looks)
    handle.on_click(lambda _: press())
    return handle


def buttons(
    gui: viser.GuiApi,
    label: str,
    options: Sequence[str],
    press: Callable[[str], None],
    hint: str | None = None,
    **looks: Any,
) -> viser.GuiButtonGroupHandle:
    """Buttons in a row; one that is pressed calls a function with its label."""
    handle = gui.add_button_group(label, tuple(options), hint=hint, **looks)
    handle.on_click(lambda event: press(event.target.value))
    return handle


def dropdown(
    gui: viser.GuiApi,
    label: str,
    options: Sequence[str],
    hint: str,
    choose: Callable[[str], object] = lambda _: None,
    **looks: Any,
) -> viser.GuiDropdownHandle[str]:
    """A dropdown; an option that the browser chooses calls a function with it."""
    handle: viser.GuiDropdownHandle[str] = gui.add_dropdown(label, tuple(options), hint=hint, **looks)
    on_choice(handle, choose)
    return handle


def on_choice(handle: viser.GuiInputHandle[T], choose: Callable[[T], object]) -> None:
    """Call a function with each value that the browser sets; values that the server sets are left out."""

    def update(event: viser.GuiEvent[viser.GuiInputHandle[T]]) -> None:
        if event.client is not None:
            choose(handle.value)

    handle.on_update(update)


def offer(choice: viser.GuiDropdownHandle[str], names: Sequence[str], chosen: str | None = None) -> None:
    """Offer names in a dropdown; what is set already is not sent again.

    Args:
        choice: The dropdown.
        names: Its options.
        chosen: One of them; ``None`` keeps the present one where possible.
    """
    if tuple(choice.options) != tuple(names):
        choice.options = tuple(names)
    if chosen is not None and choice.value != chosen:
        choice.value = chosen


def cycle(entries: Sequence[T], current: T, steps: int, default: T) -> T:
    """Entry ``steps`` after the current one, cyclically; the first or last where that is not in the list.

    An empty list gives the default.
    """
    if not entries:
        return default
    if current not in entries:
        return entries[0 if steps > 0 else -1]
    return entries[(entries.index(current) + steps) % len(entries)]


class Stepper:
    """A dropdown of names, and buttons that step through them."""

    def __init__(
        self,
        gui: viser.GuiApi,
        labels: tuple[str, str],
        hints: tuple[str, str],
        go: Callable[[str], None],
        buttons: Buttons = BACK_AND_ON,
    ) -> None:
        """Build the elements in the container that is open.

        Args:
            gui: Where.
            labels: Of the dropdown and of the buttons.
            hints: The same.
            go: Is called with the name that the browser chose; empty for none.
            buttons: The buttons.
        """
        self._names: tuple[str, ...] = ()
        self._chosen = ""
        self._go, self._buttons = go, buttons
        gui.add_html(_PICK)
        self._picked = gui.add_text("Row", "")
        self._picked.on_update(lambda event: self._pick(event.target.value))
        self._choice: viser.GuiDropdownHandle[str] = gui.add_dropdown(labels[0], _NOTHING, hint=hints[0])
        self._group = gui.add_button_group(labels[1], tuple(buttons), hint=hints[1])
        on_choice(self._choice, lambda name: self._choose("" if name == NONE else name))
        self._group.on_click(lambda event: self._press(event.target.value))

    def show(self, *, visible: bool) -> None:
        """Show or hide the elements."""
        self._choice.visible = self._group.visible = visible

    def offer(self, names: Sequence[str], chosen: str) -> None:
        """Offer names in their order; a chosen one that is not among them is kept for stepping alone."""
        self._names, self._chosen = tuple(names), chosen
        options = (NONE, *self._names[:_MOST_NAMED])
        offer(self._choice, options, chosen if chosen in options else NONE)

    def _pick(self, clicked: str) -> None:
        """Choose the row that was clicked: its name follows the number of the click, so that no two are the same."""
        name = clicked.partition(" ")[2]
        if name in self._names:
            self._choose(name)

    def _press(self, button: str) -> None:
        step = self._buttons[button]
        if not isinstance(step, int):
            step()
        elif self._names:
            self._choose(cycle(self._names, self._chosen, step, "") if step else self._names[0])

    def _choose(self, name: str) -> None:
        self._chosen = name
        self._go(name)


class PlaceStepper(Stepper):
    """A stepper through components or faces that zooms in on the chosen one and selects it."""

    def __init__(
        self, page: Page, scene: Scene, labels: tuple[str, str], hints: tuple[str, str], buttons: Buttons = BACK_AND_ON
    ) -> None:
        """Build the elements in the container that is open."""

        def go(name: str) -> None:
            session = page.session
            place = session.workpiece.find_place(name)
            if place is not None:
                scene.look_at(place)
            if place is not None or session.selection.component:
                page.select(component="" if place is None else name)

        super().__init__(page.client.gui, labels, hints, go, buttons)


class FindingStepper(Stepper):
    """A stepper through findings."""

    def __init__(
        self,
        gui: viser.GuiApi,
        hints: tuple[str, str],
        go: Callable[[Finding | None], None],
        others: Buttons = MappingProxyType({}),
    ) -> None:
        """Build the elements in the container that is open.

        Args:
            gui: Where.
            hints: Of the dropdown and of the buttons.
            go: Is called with the finding that the browser chose.
            others: More buttons.
        """
        self.chosen: Finding | None = None
        self._findings: dict[str, Finding] = {}

        def choose(name: str) -> None:
            self.chosen = self._findings.get(name)
            go(self.chosen)

        super().__init__(gui, ("Go to", "Step"), hints, choose, {**BACK_AND_ON, **others})

    def offer_findings(self, findings: Sequence[Finding]) -> None:
        """Offer findings in their order; the chosen one stays chosen where it is among them."""
        self._findings = name_findings(findings)
        chosen = next((name for name, each in self._findings.items() if each is self.chosen), "")
        self.offer(tuple(self._findings), chosen)


class AllowedRules:
    """A box for each violated rule; a ticked one allows the program in spite of its errors."""

    def __init__(self, gui: viser.GuiApi) -> None:
        """Build the folder in the container that is open; it is hidden while no rule is violated."""
        self._gui = gui
        self._folder = gui.add_folder("In spite of errors", visible=False)
        self._boxes: dict[str, viser.GuiCheckboxHandle] = {}

    @property
    def rules(self) -> tuple[str, ...]:
        """Rules whose errors are allowed."""
        return tuple(rule for rule, box in self._boxes.items() if box.value)

    def offer(self, rules: Iterable[str]) -> None:
        """Offer rules; the boxes stay as they are while the rules are the same."""
        offered = list(dict.fromkeys(rules))
        if offered == list(self._boxes):
            return
        for box in self._boxes.values():
            box.remove()
        with self._folder:
            self._boxes = {rule: self._gui.add_checkbox(rule, False) for rule in offered}
        self._folder.visible = bool(offered)
