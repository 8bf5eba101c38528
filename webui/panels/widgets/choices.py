"""Controls made together with what they do and when they are shown: buttons, inputs, lists, allowed rules."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, TypeVar

import viser

from specs.finding import Finding
from webui.cards.findings import name_findings
from webui.page.page import Page
from webui.page.session import Session
from webui.scene.scene import Scene

T = TypeVar("T")
Input = TypeVar("Input", bound=viser.GuiInputHandle[Any])
NONE: str = "\N{EN DASH}"
_NOTHING: tuple[str, ...] = (NONE,)
_MOST_NAMED = 500
"""Names in a dropdown; the buttons step through all."""
_PICK = '<div class="wb-pick"></div>'
"""The text that follows is not seen: the page writes the row of a listing there that is clicked."""
Buttons = Mapping[str, int | Callable[[], None]]
"""Steps by the label of their button, 0 for the first of the list; or another action."""
BACK_AND_ON: Buttons = MappingProxyType({"Previous": -1, "Next": 1})


def show_while(page: Page, holds: Callable[[Session], object], *handles: Any) -> None:
    """Show elements while something holds of the session, and hide them otherwise."""

    def show(session: Session) -> None:
        for each in handles:
            each.visible = bool(holds(session))

    page.follow(show, lambda session: bool(holds(session)))


def folder(
    page: Page, label: str | None, holds: Callable[[Session], object], *, expanded: bool = True
) -> viser.GuiFolderHandle:
    """A folder that is shown while something holds of the session."""
    handle = page.client.gui.add_folder(label, visible=False, expand_by_default=expanded)
    show_while(page, holds, handle)
    return handle


def html(page: Page, write: Callable[[Session], str], of: Callable[[Session], object]) -> viser.GuiHtmlHandle:
    """HTML about the session, written anew whenever what is taken of it is another."""
    handle = page.client.gui.add_html("")
    page.follow(lambda session: setattr(handle, "content", write(session)), of)
    return handle


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
    options: Iterable[str],
    press: Callable[[str], None],
    hint: str | None = None,
    **looks: Any,
) -> viser.GuiButtonGroupHandle:
    """Buttons in a row; one that is pressed calls a function with its label."""
    handle = gui.add_button_group(label, tuple(options), hint=hint, **looks)
    handle.on_click(lambda event: press(event.target.value))
    return handle


def upload(gui: viser.GuiApi, label: str, take: Callable[[viser.UploadedFile], None], hint: str, **looks: Any) -> None:
    """A button that takes a file of the browser; its looks are those of ``add_upload_button``."""
    gui.add_upload_button(label, hint=hint, **looks).on_upload(lambda event: take(event.target.value))


def dropdown(
    gui: viser.GuiApi,
    label: str,
    options: Iterable[str],
    hint: str,
    choose: Callable[[str], object] = lambda _: None,
    **looks: Any,
) -> viser.GuiDropdownHandle[str]:
    """A dropdown; an option that the browser chooses calls a function with it."""
    handle: viser.GuiDropdownHandle[str] = gui.add_dropdown(label, tuple(options), hint=hint, **looks)
    return on_choice(handle, choose)


def checkbox(
    gui: viser.GuiApi, label: str, value: bool, hint: str, tick: Callable[[bool], object] = lambda _: None
) -> viser.GuiCheckboxHandle:
    """A checkbox; one that is ticked or cleared in the browser calls a function with its value."""
    return on_choice(gui.add_checkbox(label, value, hint=hint), tick)


def on_choice(handle: Input, choose: Callable[[Any], object]) -> Input:
    """Call a function with each value that the browser sets; values that the server sets are left out."""

    def update(event: viser.GuiEvent[Any]) -> None:
        if event.client is not None:
            choose(handle.value)

    handle.on_update(update)
    return handle


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
        steps: Buttons = BACK_AND_ON,
    ) -> None:
        """Build the elements in the container that is open.

        Args:
            gui: Where.
            labels: Of the dropdown and of the buttons.
            hints: The same.
            go: Is called with the name that the browser chose; empty for none.
            steps: The buttons.
        """
        self._names: tuple[str, ...] = ()
        self._chosen = ""
        self._go = go
        gui.add_html(_PICK)

        def pick(clicked: str) -> None:
            """Choose the row that was clicked; the number of the click, before its name, makes each of them another."""
            if (name := clicked.partition(" ")[2]) in self._names:
                self._choose(name)

        def press(label: str) -> None:
            step = steps[label]
            if not isinstance(step, int):
                step()
            elif self._names:
                self._choose(cycle(self._names, self._chosen, step, "") if step else self._names[0])

        gui.add_text("Row", "").on_update(lambda event: pick(event.target.value))
        self._choice = dropdown(
            gui, labels[0], _NOTHING, hints[0], lambda name: self._choose("" if name == NONE else name)
        )
        self._group = buttons(gui, labels[1], tuple(steps), press, hints[1])

    def show(self, *, visible: bool) -> None:
        """Show or hide the elements."""
        self._choice.visible = self._group.visible = visible

    def offer(self, names: Sequence[str], chosen: str) -> None:
        """Offer names in their order; a chosen one that is not among them is kept for stepping alone."""
        self._names, self._chosen = tuple(names), chosen
        options = (NONE, *self._names[:_MOST_NAMED])
        offer(self._choice, options, chosen if chosen in options else NONE)

    def _choose(self, name: str) -> None:
        self._chosen = name
        self._go(name)


class PlaceStepper(Stepper):
    """A stepper through components or faces that zooms in on the chosen one and selects it."""

    def __init__(
        self, page: Page, scene: Scene, labels: tuple[str, str], hints: tuple[str, str], steps: Buttons = BACK_AND_ON
    ) -> None:
        """Build the elements in the container that is open."""

        def go(name: str) -> None:
            session = page.session
            place = session.workpiece.find_place(name)
            if place is not None:
                scene.look_at(place)
            if place is not None or session.selection.component:
                page.select(component="" if place is None else name)

        super().__init__(page.client.gui, labels, hints, go, steps)


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
