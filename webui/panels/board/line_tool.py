"""A straight line drawn by two clicks on the board, which becomes a template of the recipe."""

from dataclasses import dataclass
from itertools import count

import numpy as np

from geometry.arrays import Points
from recipes.errors import RecipeError
from recipes.recipe import Recipe
from specs.source import Source
from specs.yaml.edit import set_value
from specs.yaml.tree import Tree
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import offer
from webui.scene.scene import Scene
from webui.theme.html import box_html
from webui.theme.palette import SELECTED

_M = 0.001
_IDLE = "Two clicks on the board make a straight path."


@dataclass(frozen=True, slots=True)
class DrawnLine:
    """Values of a template of path class straight_line. Board frame, mm."""

    name: str
    begin: tuple[float, float]
    end: tuple[float, float]
    height_mm: float
    speed_mm_s: float


def add_line(session: Session, line: DrawnLine, step: int) -> Session:
    """Add a line as a template and as the last path of a step: one edit.

    Raises:
        RecipeError: the recipe would be invalid, or the name is taken or is none.
    """
    if line.name in session.recipe.templates:
        raise RecipeError(f"{line.name!r} is there already; choose another name", path="templates")
    if line.begin == line.end:
        raise RecipeError("the line has no length; click two different points", path=f"templates.{line.name}")
    template: Tree = {
        "path": "straight_line",
        "from": [round(value, 2) for value in line.begin],
        "to": [round(value, 2) for value in line.end],
        "height_mm": line.height_mm,
        "speed_mm_s": line.speed_mm_s,
    }
    sequence: Tree = session.loaded.root.at(("sequence",)).plain()
    sequence[step]["paths"].append(line.name)
    text = set_value(session.document.text, ("templates", line.name), template)
    return session.edited(set_value(text, ("sequence",), sequence))


def free_name(recipe: Recipe) -> str:
    """A name that no template has."""
    return next(name for number in count(1) if (name := f"line{number}") not in recipe.templates)


def step_names(recipe: Recipe) -> tuple[str, ...]:
    """Names of the steps, such as ``1 clean, ring60``; those on the bottom name it."""
    return tuple(
        f"{place + 1} {step.function}, {step.nozzle}{', bottom' if step.side == 'bottom' else ''}"
        for place, step in enumerate(recipe.sequence)
    )


class LineTool:
    """Takes two clicks, shows the line, and adds it to the recipe under a name."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the folder in the container that is open; it is visible where there is a board."""
        self._page, self._scene = page, scene
        self._points: list[tuple[float, float]] = []
        gui = page.client.gui
        self._folder = gui.add_folder("Straight line")
        with self._folder:
            self._hint = gui.add_html(box_html(_IDLE))
            self._draw = gui.add_button("Draw a line", hint="Then click where it begins and where it ends.")
            self._form = gui.add_folder("New line", visible=False)
            self._cancel = gui.add_button("Cancel", visible=False, color="gray")
        with self._form:
            self._name = gui.add_text("Name", "line1", hint="Of the new template.")
            self._begin = gui.add_vector2("From (mm)", (0.0, 0.0), step=0.1, hint="Board frame.")
            self._end = gui.add_vector2("To (mm)", (0.0, 0.0), step=0.1, hint="Board frame.")
            self._height = gui.add_number("Height (mm)", 50.0, min=1.0, step=1.0, hint="Orifice above the board.")
            self._speed = gui.add_number("Speed (mm/s)", 40.0, min=0.1, step=1.0, hint="Of the orifice.")
            self._step = gui.add_dropdown(
                "Step", step_names(page.session.recipe), hint="Step that sprays it, after the other paths."
            )
            self._add = gui.add_button("Add to the recipe")
        self._draw.on_click(lambda _: self._start())
        self._add.on_click(lambda _: self._finish())
        self._cancel.on_click(lambda _: self._stop())
        self._begin.on_update(lambda _: self._preview())
        self._end.on_update(lambda _: self._preview())

    def show(self, session: Session, before: Session | None) -> None:
        """Offer the steps of a session; another board ends the drawing."""
        offer(self._step, step_names(session.recipe))
        if before is None or session.board is not before.board:
            self._folder.visible = session.board is not None
        if before is not None and session.workpiece is not before.workpiece:
            self._stop()

    def _start(self) -> None:
        self._points = []
        self._scene.click_taker = self._take
        self._show_state("Click where the line begins.", drawing=True)

    def _take(self, origin: Points, direction: Points) -> None:
        place = self._scene.point_on_board(origin, direction)
        if place is None:
            self._show_state("That is beside the board's plane; click on the board.", drawing=True)
            return
        self._points.append(place)
        if len(self._points) == 1:
            self._begin.value = self._end.value = place
            self._show_state("Click where it ends.", drawing=True)
            return
        self._scene.click_taker = None
        self._end.value = place
        self._name.value = free_name(self._page.session.recipe)
        self._show_state("Give it a name and a step.", drawing=True, form=True)
        self._preview()

    def _finish(self) -> None:
        line = DrawnLine(
            self._name.value.strip(), self._begin.value, self._end.value, self._height.value, self._speed.value
        )
        step = tuple(self._step.options).index(self._step.value)
        if self._page.attempt(lambda session: add_line(session, line, step)):
            self._stop()
            self._page.select(made_by=Source(step, line.name))

    def _stop(self) -> None:
        self._scene.click_taker = None
        self._points = []
        self._show_state(_IDLE, drawing=False)
        self._preview()

    def _show_state(self, hint: str, *, drawing: bool, form: bool = False) -> None:
        self._hint.content = box_html(hint)
        self._draw.visible, self._cancel.visible, self._form.visible = not drawing, drawing, form

    def _preview(self) -> None:
        z = float(self._page.session.workpiece.box[1][2]) + 0.5
        ends = np.array([[(*self._begin.value, z), (*self._end.value, z)]]) * _M
        self._page.client.scene.add_line_segments(
            "/drawn", ends, SELECTED, thickness=4.0, thickness_units="screen", visible=bool(self._points)
        )
