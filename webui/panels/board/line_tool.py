"""Draw a straight line by two clicks on the board, and make it a template."""

import numpy as np

from geometry.arrays import Points
from webui.forms.draw_line import DrawnLine, add_line, free_name, step_names
from webui.page.page import Page
from webui.page.session import Session
from webui.scene.scene import Scene
from webui.theme.palette import ACCENT, INK, to_hex

_M = 0.001
_IDLE = "Two clicks on the board make a straight path."


class LineTool:
    """Takes two clicks, shows the line, asks for its name and step."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._points: list[tuple[float, float]] = []
        gui = page.client.gui
        self._hint = gui.add_html(_hint_html(_IDLE))
        self._draw = gui.add_button("Draw a line", hint="Then click where it begins and where it ends.")
        self._form = gui.add_folder("New line", visible=False)
        with self._form:
            self._name = gui.add_text("Name", "line1", hint="Of the new template.")
            self._begin = gui.add_vector2("From (mm)", (0.0, 0.0), step=0.1, hint="Board frame.")
            self._end = gui.add_vector2("To (mm)", (0.0, 0.0), step=0.1, hint="Board frame.")
            self._height = gui.add_number("Height (mm)", 50.0, min=1.0, step=1.0, hint="Orifice above the board.")
            self._speed = gui.add_number("Speed (mm/s)", 40.0, min=0.1, step=1.0, hint="Of the orifice.")
            self._step = gui.add_dropdown(
                "Step", step_names(page.session.recipe), hint="Where it is sprayed, after the other paths."
            )
            self._add = gui.add_button("Add to the recipe")
        self._cancel = gui.add_button("Cancel", visible=False, color="gray")
        self._draw.on_click(lambda _: self._start())
        self._add.on_click(lambda _: self._finish())
        self._cancel.on_click(lambda _: self._stop())
        self._begin.on_update(lambda _: self._preview())
        self._end.on_update(lambda _: self._preview())

    def show(self, session: Session, before: Session | None) -> None:
        """Offer the steps of a session; another board ends the drawing."""
        names = step_names(session.recipe)
        if tuple(self._step.options) != names:
            self._step.options = names
        if before is not None and session.board is not before.board:
            self._stop()

    def _start(self) -> None:
        self._points = []
        self._scene.click_taker = self._take
        self._hint.content = _hint_html("Click where the line begins.")
        self._draw.visible, self._cancel.visible, self._form.visible = False, True, False

    def _take(self, origin: Points, direction: Points) -> None:
        place = self._scene.point_on_board(origin, direction)
        if place is None:
            self._hint.content = _hint_html("That is beside the board's plane; click on the board.")
            return
        self._points.append(place)
        if len(self._points) == 1:
            self._begin.value = self._end.value = place
            self._hint.content = _hint_html("Click where it ends.")
            return
        self._scene.click_taker = None
        self._end.value = place
        self._name.value = free_name(self._page.session.recipe)
        self._hint.content = _hint_html("Give it a name and a step.")
        self._form.visible = True
        self._preview()

    def _finish(self) -> None:
        line = DrawnLine(
            self._name.value.strip(), self._begin.value, self._end.value, self._height.value, self._speed.value
        )
        step = tuple(self._step.options).index(self._step.value)
        if self._page.attempt(lambda session: add_line(session, line, step)):
            self._stop()
            self._page.select(made_by=f"sequence[{step}]/{line.name}")

    def _stop(self) -> None:
        self._scene.click_taker = None
        self._points = []
        self._hint.content = _hint_html(_IDLE)
        self._draw.visible, self._cancel.visible, self._form.visible = True, False, False
        self._preview()

    def _preview(self) -> None:
        z = self._page.session.board.top_z_mm + 0.5
        ends = np.array([[(*self._begin.value, z), (*self._end.value, z)]]) * _M
        self._page.client.scene.add_line_segments(
            "/drawn", ends, ACCENT, thickness=4.0, thickness_units="screen", visible=bool(self._points)
        )


def _hint_html(text: str) -> str:
    return f'<div style="margin:0 12px;font-size:12px;color:{to_hex(INK)}">{text}</div>'
