"""The paths: colours, legend, visibility, the selected stroke, and a straight line that is drawn by two clicks."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numpy as np
import viser

from geometry.arrays import Points
from recipes.errors import RecipeError
from recipes.recipe import Recipe
from reports.tables.wording import amount
from specs.source import NO_SOURCE, Source
from specs.yaml.edit import set_value
from specs.yaml.tree import Tree
from webui.cards.findings import recipe_line
from webui.layers.paths.nozzle import COLOURS
from webui.layers.paths.strokes import ColourBy, StrokeLine, clock, spray_spans
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import (
    button,
    buttons,
    checkbox,
    cycle,
    dropdown,
    folder,
    html,
    offer,
    show_while,
)
from webui.scene.scene import Scene, View
from webui.theme.html import DIAMOND, box_html, facts_html, grey_html, legend_html, messages_html, name_html
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

        def start() -> None:
            self._points = []
            scene.click_taker = self._take
            self._show_state("Click where the line begins.", drawing=True)

        with folder(page, "Straight line", lambda now: now.board is not None):
            self._hint = gui.add_html(box_html(_IDLE))
            self._draw = button(gui, "Draw a line", start, "Then click where it begins and where it ends.")
            self._form = gui.add_folder("New line", visible=False)
            self._cancel = button(gui, "Cancel", self._stop, visible=False, color="gray")
        with self._form:
            self._name = gui.add_text("Name", "line1", hint="Of the new template.")
            self._begin = gui.add_vector2("From (mm)", (0.0, 0.0), step=0.1, hint="Board frame.")
            self._end = gui.add_vector2("To (mm)", (0.0, 0.0), step=0.1, hint="Board frame.")
            self._height = gui.add_number("Height (mm)", 50.0, min=1.0, step=1.0, hint="Orifice above the board.")
            self._speed = gui.add_number("Speed (mm/s)", 40.0, min=0.1, step=1.0, hint="Of the orifice.")
            hint = "Step that sprays it, after the other paths."
            self._step = dropdown(gui, "Step", step_names(page.session.recipe), hint)
            button(gui, "Add to the recipe", self._add)
        for end in (self._begin, self._end):
            end.on_update(lambda _: self._preview())
        page.follow(lambda now: offer(self._step, step_names(now.recipe)), lambda now: now.recipe)
        page.follow(lambda _: self._stop(), lambda now: now.workpiece)

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

    def _add(self) -> None:
        ends, step = (self._begin.value, self._end.value), tuple(self._step.options).index(self._step.value)
        line = DrawnLine(self._name.value.strip(), *ends, self._height.value, self._speed.value)
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


_COLOURS: dict[str, ColourBy] = {"Function": "function", "Template": "template", "Speed": "speed", "Time": "time"}
_STEPS = {"Previous": -1, "Next": 1, "None": 0}
_SHOWN = {
    "transfers": ("Jet off", True, "Moves with the jet off, thin."),
    "markers": ("Events", True, "Pauses, switches of the jet, commands."),
    "stripes": ("Stripes", True, "Where the jet meets the faces, in their order."),
    "lances": ("Lance", False, "The lance at moments of its way."),
}
"""Label, first value and hint of what the view shows or leaves out."""


class PathsPanel:
    """The paths: colours, legend, visibility, and the selected stroke."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui

        def look(**changed: Any) -> None:
            self._change(replace(scene.view, **changed))

        def colour(by: str) -> None:
            look(strokes_by=_COLOURS[by])

        dropdown(gui, "Colour by", _COLOURS, "Meaning of the colours of the paths.", colour)
        self._legend = gui.add_html("")
        with gui.add_folder("Stroke"):
            html(page, lambda now: card_html(now, scene.strokes), lambda now: (now.timed, now.selection))
            buttons(gui, "Select", _STEPS, self._select, "In the order of the program.")
        self._shown = gui.add_folder("Shown")
        with self._shown:
            shown = {
                key: checkbox(gui, label, first, hint, lambda ticked, key=key: look(**{key: ticked}))
                for key, (label, first, hint) in _SHOWN.items()
            }
            events = {"pause, larger if longer" if kind == "pause" else kind: tint for kind, tint in COLOURS.items()}
            gui.add_html(legend_html(events.items(), DIAMOND))
        self._boxes: dict[Source, viser.GuiCheckboxHandle] = {}
        page.follow(self._show_boxes, lambda now: now.timed)
        show_while(page, lambda now: now.coverings, shown["stripes"], shown["lances"])
        LineTool(page, scene)

    def _show_boxes(self, session: Session) -> None:
        """One checkbox for each template in its step."""
        labels: dict[Source, str] = {}
        for place, strokes in Counter(source.place for source in self._origins()).items():
            function = session.run.recipe.sequence[place.step or 0].function if session.run is not None else ""
            labels[place] = f"{function} {place.template}" + (f" ({strokes})" if strokes > 1 else "")
        if list(labels) != list(self._boxes):
            for box in self._boxes.values():
                box.remove()
            gui, hidden = self._page.client.gui, self._scene.view.hidden
            with self._shown:
                self._boxes = {
                    place: checkbox(
                        gui, label, place not in hidden, str(place), lambda shown, place=place: self._show(place, shown)
                    )
                    for place, label in labels.items()
                }
        for place, label in labels.items():
            self._boxes[place].label = label
        self._show_legend()

    def _show(self, place: Source, shown: bool) -> None:
        view = self._scene.view
        self._change(replace(view, hidden=view.hidden - {place} if shown else view.hidden | {place}))

    def _change(self, view: View) -> None:
        with self._page.client.atomic():
            self._scene.change_view(view)
            self._show_legend()

    def _show_legend(self) -> None:
        self._legend.content = legend_html(self._scene.legends.get("strokes", {}).items())

    def _origins(self) -> list[Source]:
        """Origins of strokes, each once, in the order of the program."""
        return list(dict.fromkeys(line.made_by for line in self._scene.strokes if line.made_by))

    def _select(self, label: str) -> None:
        current, steps = self._page.session.selection.made_by, _STEPS[label]
        self._page.select(made_by=cycle(self._origins(), current, steps, NO_SOURCE) if steps else NO_SOURCE)


def card_html(session: Session, lines: Sequence[StrokeLine]) -> str:
    """Card of the selected stroke: its recipe line, speed, height, tilt, time and findings."""
    made_by = session.selection.made_by
    chosen = [line for line in lines if made_by and line.made_by.belongs_to(made_by)]
    if session.run is None or not chosen:
        return box_html(grey_html("No stroke is selected. Click one, or go through them in order."))
    facts = _facts(session, chosen)
    spans = [span for span in spray_spans(session.run.program) if span.made_by.belongs_to(made_by)]
    if spans:
        duration_s = sum(span.end_s - span.begin_s for span in spans)
        facts["Time"] = f"{clock(duration_s)}, from {clock(spans[0].begin_s)} on"
    found = messages_html([each for each in session.run.findings if each.made_by.belongs_to(made_by)], 4)
    names = filter(None, [made_by.template, "+".join(made_by.components), made_by.motion])
    title = " \N{MIDDLE DOT} ".join(names) or str(made_by)
    return box_html(name_html(title) + facts_html(facts) + found)


def _facts(session: Session, chosen: Sequence[StrokeLine]) -> dict[str, str]:
    first = chosen[0]
    spec = session.recipe.templates.get(first.template)
    facts = {
        "Recipe": recipe_line(session.loaded, first.made_by),
        "Path": spec.path.replace("_", " ") if spec is not None else first.template,
        "Function": f"{first.function}, nozzle {first.nozzle}",
        "Speed": _range([line.speed_mm_s for line in chosen], " mm/s"),
        **_over_surface(session, chosen),
        "Passes": _range([float(line.laps) for line in chosen], ""),
    }
    pauses = sum(line.pauses for line in chosen)
    if pauses:
        facts["Pauses"] = f"{pauses}, together {sum(line.paused_s for line in chosen):.1f} s"
    strokes = f" in {len(chosen)} strokes" if len(chosen) > 1 else ""
    return facts | {"Length": f"{sum(line.length_mm for line in chosen):.0f} mm{strokes}"}


def _over_surface(session: Session, chosen: Sequence[StrokeLine]) -> dict[str, str]:
    """Side, height and tilt over a board; stripes, their faces and their tilt on a part."""
    if session.board is not None:
        side = chosen[0].side
        surface = session.board.surface_z_mm(side)
        ends = [(line.points[:, 2].min(), line.points[:, 2].max()) for line in chosen]
        heights = [abs(float(z) - surface) for pair in ends for z in pair]
        tilts = [line.tilt_deg for line in chosen]
        return {"Side": side, "Height": _range(heights, " mm"), "Tilt": _range(tilts, "\N{DEGREE SIGN}")}
    made_by, faces = chosen[0].made_by, session.selection.made_by.components
    pieces = [piece for each in session.coverings if each.made_by == made_by.place for piece in each.pieces]
    pieces = [piece for piece in pieces if not faces or piece.face in faces]
    if not pieces:
        return {}
    tilts = [float(tilt) for piece in pieces for tilt in (piece.tilts_deg.min(), piece.tilts_deg.max())]
    on = f"{len(pieces)} on {amount(len({piece.face for piece in pieces}), 'face')}"
    return {"Stripes": on, "Tilt": _range([round(tilt, 1) for tilt in tilts], "\N{DEGREE SIGN}")}


def _range(values: Sequence[float], unit: str) -> str:
    low, high = f"{min(values):.4g}", f"{max(values):.4g}"
    return f"{low}{unit}" if low == high else f"{low} to {high}{unit}"
