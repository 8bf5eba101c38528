"""The heat map: measure, limit and legend; the volume can follow the playback."""

import threading
from dataclasses import dataclass, replace

import numpy as np
import viser

from cleaning.verdicts.results import CleaningReport
from geometry.arrays import Scalars
from reports.cards.cleaning import stage_names
from webui.layers.surface.ground import outline_glb
from webui.layers.surface.heat import Accumulation, gap_patches_glb
from webui.layers.surface.heat_scale import (
    COLOURINGS,
    MEASURES,
    LimitError,
    Measure,
    Scale,
    cell_values,
    check_limit,
    make_scale,
    scale_html,
    tint_cells,
)
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import offer, on_choice
from webui.scene.heat_view import HeatView
from webui.scene.scene import Scene
from webui.threads.throttle import Throttle

_OFF = "Nothing"
_ANY: tuple[str, ...] = ("\N{EN DASH}",)
_EVERY_S = 0.2
"""Shortest time between changes of colours during the playback."""
_OUTLINE, _GAPS = "/heat_selected", "/heat_gaps"


@dataclass(frozen=True, slots=True, eq=False)
class _Shown:
    """The map that is drawn."""

    report: CleaningReport
    stage: int
    values: Scalars
    scale: Scale


class HeatCard:
    """The heat map: measure, limit and legend; the volume can follow the playback."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are visible where there is an analysis."""
        self._page, self._scene = page, scene
        self._view = HeatView(page.client.scene)
        self._limits: dict[tuple[str, str], float] = {}
        """Limits that were typed, by measure and stage."""
        self._drawn: _Shown | None = None
        self._growing: tuple[_Shown, Accumulation] | None = None
        self._now_s = 0.0
        self._lock = threading.RLock()
        """The playback draws from another thread."""
        self._throttle: Throttle[float] = Throttle(self._grow, _EVERY_S)
        page.on_close(self._throttle.close)
        self._build(page.client.gui)
        scene.on_moment(self._follow)

    def _build(self, gui: viser.GuiApi) -> None:
        self._folder = gui.add_folder("Heat map", visible=False)
        with self._folder:
            self._measure: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Show", (_OFF, *MEASURES), hint="On the surface of board and parts."
            )
            self._stage: viser.GuiDropdownHandle[str] = gui.add_dropdown("Stage", _ANY, hint="Of the process.")
            self._colouring: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Colours", tuple(COLOURINGS), hint="How much, or on which side of the limit."
            )
            self._limit = gui.add_number(
                "Limit", 0.0, step=0.01, hint="For the picture alone; verdicts keep those of the parameter set."
            )
            self._live = gui.add_checkbox(
                "As it grows", False, hint="Shows what has landed up to the moment that is played."
            )
            self._paths = gui.add_checkbox(
                "Paths too", True, hint="In all modes: without them only those of the selected part."
            )
            self._legend = gui.add_html("")
        for handle in (self._measure, self._stage, self._colouring):
            on_choice(handle, lambda _: self._redraw(self._page.session))
        on_choice(self._live, lambda _: self._redraw(self._page.session))
        self._paths.on_update(lambda event: self._show_paths(shown=event.target.value))
        on_choice(self._limit, self._set_limit)

    def show_verdicts(self) -> None:
        """Show the map of the verdicts, unless another one is shown."""
        if self._measure.value == _OFF:
            self._measure.value = next(iter(MEASURES))
            self._redraw(self._page.session)

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.analysis is not before.analysis:
            self._folder.visible = session.analysis is not None
            if session.analysis is None and not self._paths.value:
                self._paths.value = True  # the checkbox is hidden
                self._show_paths(shown=True)
            if session.analysis is not None:
                offer(self._stage, stage_names(session.analysis.report.stages))
            self._redraw(session)
        elif session.selection != before.selection:
            self._draw_outline(session)

    def _redraw(self, session: Session) -> None:
        """Draw the chosen map, or remove it; show the inputs that apply to its measure."""
        self._throttle.clear()
        analysis, measure = session.analysis, MEASURES.get(self._measure.value)
        rated = measure is not None and measure.name != "verdict"
        with self._lock, self._page.client.atomic():
            self._stage.visible = self._colouring.visible = rated
            self._limit.visible = rated and COLOURINGS[self._colouring.value] == "limit"
            self._live.visible = measure is not None and measure.name == "volume"
            if analysis is None or measure is None:
                self._drawn = self._growing = None
                self._view.hide()
                self._scene.draw_over(_GAPS, b"")
                self._legend.content = ""
            else:
                self._draw(analysis.report, measure)
            self._draw_outline(session)

    def _draw(self, report: CleaningReport, measure: Measure) -> None:
        stage = stage_names(report.stages).index(self._stage.value)
        values = cell_values(report, measure, stage)
        limit = self._limits.get(
            (measure.name, self._stage.value), measure.limit(report.parameters.limits, report.stages[stage])
        )
        self._limit.label = f"Limit ({measure.unit})" if measure.unit else "Limit"
        if self._limit.value != limit:
            self._limit.value = limit
        scale = make_scale(report, measure, values, COLOURINGS[self._colouring.value], limit)
        self._drawn = _Shown(report, stage, values, scale)
        in_gaps = measure.name in ("shear", "residue")
        self._scene.draw_over(_GAPS, gap_patches_glb(report, stage, scale) if in_gaps else b"")
        if self._live.visible and self._live.value:
            growth = report.exposures[stage].growth
            self._growing = self._drawn, Accumulation(growth, len(values))
            self._throttle.request(self._now_s)
        else:
            self._growing = None
            self._paint(self._drawn, values)

    def _paint(self, shown: _Shown, values: Scalars) -> None:
        self._view.show(shown.report.facets, tint_cells(shown.report.facets, values, shown.scale))
        self._legend.content = scale_html(shown.report, values, shown.scale)

    def _set_limit(self, value: float) -> None:
        shown = self._drawn
        if shown is None:
            return
        measure = shown.scale.measure
        try:
            limit = check_limit(measure, value)
        except LimitError as error:
            self._page.refuse(str(error))
            self._limit.value = shown.scale.limit
            return
        self._limits[measure.name, self._stage.value] = limit
        self._redraw(self._page.session)

    def _show_paths(self, *, shown: bool) -> None:
        with self._page.client.atomic():
            self._scene.change_view(replace(self._scene.view, paths=shown))

    def _follow(self, now_s: float) -> None:
        self._now_s = now_s
        if self._growing is not None:
            self._throttle.request(now_s)

    def _grow(self, now_s: float) -> None:
        """Draw the volume up to a time of the program."""
        with self._lock, self._page.client.atomic():
            if self._growing is not None:
                shown, volume = self._growing
                self._paint(shown, np.where(np.isfinite(shown.values), volume.until(now_s), np.nan))

    def _draw_outline(self, session: Session) -> None:
        """Draw the selected part's edges over the map, which hides its colour."""
        selected = session.component if self._drawn is not None else None
        outlined = b"" if session.board is None or selected is None else outline_glb(session.board, selected.name)
        self._scene.draw_over(_OUTLINE, outlined)
