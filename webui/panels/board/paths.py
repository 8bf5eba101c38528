"""The paths: colours, legend, what is hidden, the stroke that is selected."""

from dataclasses import replace

import viser

from webui.cards.stroke_card import card_html, legend_html, makers_in_order, marker_legend_html, step_stroke
from webui.layers.paths.strokes import ColourBy, place_of
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.board.line_tool import LineTool
from webui.scene.scene import Scene, View

_COLOURS: dict[str, ColourBy] = {"Function": "function", "Template": "template", "Speed": "speed", "Time": "time"}
_BACK, _ON, _NONE = "Previous", "Next", "None"


class PathsPanel:
    """The paths: colours, legend, what is hidden, the stroke that is selected."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui
        self._by = gui.add_dropdown("Colour by", tuple(_COLOURS), hint="What the colours of the paths tell apart.")
        self._legend = gui.add_html("")
        with gui.add_folder("Stroke"):
            self._card = gui.add_html("")
            self._go = gui.add_button_group("Select", (_BACK, _ON, _NONE), hint="In the order of the program.")
        self._shown = gui.add_folder("Shown")
        with self._shown:
            self._transfers = gui.add_checkbox("Jet off", True, hint="Moves with the jet off, thin.")
            self._markers = gui.add_checkbox("Events", True, hint="Pauses, switches of the jet, commands.")
            self._marker_legend = gui.add_html(marker_legend_html())
        self._boxes: dict[str, viser.GuiCheckboxHandle] = {}
        with gui.add_folder("Straight line"):
            self._line = LineTool(page, scene)
        self._by.on_update(lambda event: self._colour_by(event.target.value))
        self._go.on_click(lambda event: self._select(event.target.value))
        self._transfers.on_update(lambda event: self._change(replace(scene.view, transfers=event.target.value)))
        self._markers.on_update(lambda event: self._change(replace(scene.view, markers=event.target.value)))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.run is not before.run:
            self._list_places(session)
            self._legend.content = legend_html(self._scene.legends.get("strokes", {}))
        if before is None or session.run is not before.run or session.selection != before.selection:
            self._card.content = card_html(session, self._scene.strokes)
        self._line.show(session, before)

    def _list_places(self, session: Session) -> None:
        """Have one checkbox for each template in its step."""
        counts: dict[str, int] = {}
        for maker in makers_in_order(self._scene.strokes):
            counts[place_of(maker)] = counts.get(place_of(maker), 0) + 1
        labels = {place: _label(session, place, count) for place, count in counts.items()}
        if list(labels) != list(self._boxes):
            for box in self._boxes.values():
                box.remove()
            with self._shown:
                self._boxes = {place: self._box(place, label) for place, label in labels.items()}
        for place, label in labels.items():
            if self._boxes[place].label != label:
                self._boxes[place].label = label

    def _box(self, place: str, label: str) -> viser.GuiCheckboxHandle:
        box = self._page.client.gui.add_checkbox(label, place not in self._scene.view.hidden, hint=place)
        box.on_update(lambda event: self._hide(place, hidden=not event.target.value))
        return box

    def _hide(self, place: str, *, hidden: bool) -> None:
        view = self._scene.view
        self._change(replace(view, hidden=view.hidden | {place} if hidden else view.hidden - {place}))

    def _colour_by(self, name: str) -> None:
        self._change(replace(self._scene.view, strokes_by=_COLOURS[name]))
        self._legend.content = legend_html(self._scene.legends.get("strokes", {}))

    def _change(self, view: View) -> None:
        with self._page.client.atomic():
            self._scene.change_view(view)

    def _select(self, button: str) -> None:
        selected = self._page.session.selection.made_by
        steps = 1 if button == _ON else -1
        self._page.select(made_by="" if button == _NONE else step_stroke(self._scene.strokes, selected, steps))


def _label(session: Session, place: str, count: int) -> str:
    """Name a template in its step by what the engineer calls it."""
    step, _, template = place.partition("/")
    number = int(step.removeprefix("sequence[").removesuffix("]"))
    run = session.run
    function = run.recipe.sequence[number].function if run is not None else step
    return f"{function} {template}" + (f" ({count})" if count > 1 else "")
