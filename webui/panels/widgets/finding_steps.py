"""Going from finding to finding: by name, or by buttons through those that are listed."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import viser

from specs.finding import Finding
from webui.cards.finding_list import name_findings
from webui.forms.cycle import step_around
from webui.forms.dropdown import offer

_NONE: str = "none"
_NOTHING: tuple[str, ...] = (_NONE,)
_BACK, _ON = "Previous", "Next"
_MOST_NAMED = 500
"""Findings to choose from by name; the buttons go through all."""


class FindingSteps:
    """Going from finding to finding: by name, or by buttons through those that are listed."""

    def __init__(
        self,
        gui: viser.GuiApi,
        hints: tuple[str, str],
        go: Callable[[Finding | None], None],
        others: Mapping[str, Callable[[], None]] = MappingProxyType({}),
    ) -> None:
        """Build the elements in the container that is open.

        Args:
            gui: Where.
            hints: Of the names and of the buttons.
            go: Is called with what was chosen by hand.
            others: More buttons, and what they do.
        """
        self.chosen: Finding | None = None
        self._names: dict[str, Finding] = {}
        self._go, self._others = go, others
        self._choice: viser.GuiDropdownHandle[str] = gui.add_dropdown("Go to", _NOTHING, hint=hints[0])
        self._buttons = gui.add_button_group("Step", (_BACK, _ON, *others), hint=hints[1])
        self._choice.on_update(lambda event: self._choose(event.target.value) if event.client is not None else None)
        self._buttons.on_click(lambda event: self._press(event.target.value))

    def show(self, *, visible: bool) -> None:
        """Show the elements, or hide them."""
        self._choice.visible = self._buttons.visible = visible

    def offer(self, findings: Sequence[Finding]) -> None:
        """Offer findings in their order; the chosen one stays chosen where it is among them."""
        self._names = name_findings(findings)
        options = (_NONE, *list(self._names)[:_MOST_NAMED])
        offer(self._choice, options, self._name if self._name in options else _NONE)

    @property
    def _name(self) -> str:
        return next((name for name, each in self._names.items() if each is self.chosen), _NONE)

    def _press(self, button: str) -> None:
        if button in self._others:
            self._others[button]()
        elif self._names:
            self._choose(step_around(list(self._names), self._name, 1 if button == _ON else -1))

    def _choose(self, name: str) -> None:
        self.chosen = self._names.get(name)
        self._go(self.chosen)
