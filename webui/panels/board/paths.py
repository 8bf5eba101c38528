"""The paths: colours, legend, visibility, and the selected stroke."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import viser

from reports.tables.wording import amount
from specs.source import NO_SOURCE, Source
from webui.cards.finding_list import recipe_line
from webui.layers.paths.markers import COLOURS
from webui.layers.paths.strokes import ColourBy, StrokeLine
from webui.layers.paths.timeline import clock, spray_spans
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.board.line_tool import LineTool
from webui.panels.widgets.choices import cycle
from webui.scene.scene import Scene, View
from webui.theme.html import DIAMOND, box_html, facts_html, grey_html, legend_html, messages_html, name_html

_COLOURS: dict[str, ColourBy] = {"Function": "function", "Template": "template", "Speed": "speed", "Time": "time"}
_STEPS = {"Previous": -1, "Next": 1, "None": 0}


class PathsPanel:
    """The paths: colours, legend, visibility, and the selected stroke."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui
        self._by = gui.add_dropdown("Colour by", tuple(_COLOURS), hint="Meaning of the colours of the paths.")
        self._legend = gui.add_html("")
        with gui.add_folder("Stroke"):
            self._card = gui.add_html("")
            self._go = gui.add_button_group("Select", tuple(_STEPS), hint="In the order of the program.")
        self._shown = gui.add_folder("Shown")
        with self._shown:
            self._transfers = gui.add_checkbox("Jet off", True, hint="Moves with the jet off, thin.")
            self._markers = gui.add_checkbox("Events", True, hint="Pauses, switches of the jet, commands.")
            self._stripes = gui.add_checkbox("Stripes", True, hint="Where the jet meets the faces, in their order.")
            self._lances = gui.add_checkbox("Lance", False, hint="The lance at moments of its way.")
            events = {"pause, larger if longer" if kind == "pause" else kind: tint for kind, tint in COLOURS.items()}
            gui.add_html(legend_html(events.items(), DIAMOND))
        self._boxes: dict[Source, viser.GuiCheckboxHandle] = {}
        self._line = LineTool(page, scene)
        self._by.on_update(lambda event: self._change(replace(scene.view, strokes_by=_COLOURS[event.target.value])))
        self._go.on_click(lambda event: self._select(event.target.value))
        self._transfers.on_update(lambda event: self._change(replace(scene.view, transfers=event.target.value)))
        self._stripes.on_update(lambda event: self._change(replace(scene.view, stripes=event.target.value)))
        self._lances.on_update(lambda event: self._change(replace(scene.view, lances=event.target.value)))
        self._markers.on_update(lambda event: self._change(replace(scene.view, markers=event.target.value)))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.timed is not before.timed:
            self._show_boxes(session)
            self._legend.content = legend_html(self._scene.legends.get("strokes", {}).items())
        if before is None or session.coverings is not before.coverings:
            self._stripes.visible = self._lances.visible = bool(session.coverings)
        if before is None or session.timed is not before.timed or session.selection != before.selection:
            self._card.content = card_html(session, self._scene.strokes)
        self._line.show(session, before)

    def _show_boxes(self, session: Session) -> None:
        """One checkbox for each template in its step."""
        labels: dict[Source, str] = {}
        for place, count in Counter(source.place for source in self._origins()).items():
            function = session.run.recipe.sequence[place.step or 0].function if session.run is not None else ""
            labels[place] = f"{function} {place.template}" + (f" ({count})" if count > 1 else "")
        if list(labels) != list(self._boxes):
            for box in self._boxes.values():
                box.remove()
            with self._shown:
                self._boxes = {place: self._add_box(place, label) for place, label in labels.items()}
        for place, label in labels.items():
            if self._boxes[place].label != label:
                self._boxes[place].label = label

    def _add_box(self, place: Source, label: str) -> viser.GuiCheckboxHandle:
        box = self._page.client.gui.add_checkbox(label, place not in self._scene.view.hidden, hint=str(place))

        def update(_: object) -> None:
            view = self._scene.view
            self._change(replace(view, hidden=view.hidden - {place} if box.value else view.hidden | {place}))

        box.on_update(update)
        return box

    def _change(self, view: View) -> None:
        with self._page.client.atomic():
            self._scene.change_view(view)
            self._legend.content = legend_html(self._scene.legends.get("strokes", {}).items())

    def _origins(self) -> list[Source]:
        """Origins of strokes, each once, in the order of the program."""
        return list(dict.fromkeys(line.made_by for line in self._scene.strokes if line.made_by))

    def _select(self, button: str) -> None:
        steps = _STEPS[button]
        current = self._page.session.selection.made_by
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
