"""Boxes by which somebody lets a program be written in spite of errors, one for each rule that is broken."""

from collections.abc import Iterable

import viser


class Allowance:
    """Boxes by which somebody lets a program be written in spite of errors, one for each rule that is broken."""

    def __init__(self, gui: viser.GuiApi) -> None:
        """Build the folder in the container that is open; it is not seen while no rule is broken."""
        self._gui = gui
        self._folder = gui.add_folder("In spite of errors", visible=False)
        self._boxes: dict[str, viser.GuiCheckboxHandle] = {}

    @property
    def rules(self) -> tuple[str, ...]:
        """Rules whose errors are allowed."""
        return tuple(rule for rule, box in self._boxes.items() if box.value)

    def offer(self, rules: Iterable[str]) -> None:
        """Offer these rules; boxes of rules that were offered before stay as they are if all are the same."""
        offered = list(dict.fromkeys(rules))
        if offered == list(self._boxes):
            return
        for box in self._boxes.values():
            box.remove()
        with self._folder:
            self._boxes = {rule: self._gui.add_checkbox(rule, False) for rule in offered}
        self._folder.visible = bool(offered)
