"""Controls of viser, each made together with what it does."""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import viser

T = TypeVar("T")
NOTHING: tuple[str, ...] = ("",)
"""Options of a dropdown that has none yet."""


def button(
    gui: viser.GuiApi, label: str, press: Callable[[], object], hint: str | None = None, **looks: Any
) -> viser.GuiButtonHandle:
    """A button that calls a function without arguments; its looks are those of ``add_button``."""
    handle = gui.add_button(label, hint=hint, **looks)
    handle.on_click(lambda _: press())
    return handle


def buttons(
    gui: viser.GuiApi, label: str, options: Sequence[str], press: Callable[[str], object], hint: str | None = None,
    *, visible: bool = True,
) -> viser.GuiButtonGroupHandle:  # fmt: skip
    """Buttons in a row; one that is pressed calls a function with its label."""
    handle = gui.add_button_group(label, tuple(options), hint=hint, visible=visible)
    handle.on_click(lambda event: press(event.target.value))
    return handle


def dropdown(
    gui: viser.GuiApi, label: str, options: Sequence[str], hint: str, choose: Callable[[str], object] | None = None,
    *, initial_value: str | None = None, visible: bool = True,
) -> viser.GuiDropdownHandle[str]:  # fmt: skip
    """A dropdown; an option that the browser chooses calls a function with it."""
    handle: viser.GuiDropdownHandle[str] = gui.add_dropdown(
        label, tuple(options), initial_value=initial_value, hint=hint, visible=visible
    )
    if choose is not None:
        on_choice(handle, choose)
    return handle


def on_choice(handle: viser.GuiInputHandle[T], choose: Callable[[T], object]) -> None:
    """Call a function with each value that the browser sets; values that the server sets are left out."""

    def update(event: viser.GuiEvent[viser.GuiInputHandle[T]]) -> None:
        if event.client is not None:
            choose(handle.value)

    handle.on_update(update)
