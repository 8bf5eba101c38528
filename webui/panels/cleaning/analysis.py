"""The cleaning prediction of the program: the analysis, its headline, the cards that show it, and the heat map."""

import threading
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import viser

from cleaning.verdicts.results import CleaningReport, report_cleanliness, report_outcome
from geometry.arrays import Scalars
from reports.cards.cleaning import faces_card, headline_card, stage_names
from reports.tables.cleaning_tables import OUTCOME_WORDS
from specs.finding_rules import CUT_BY_MASK
from specs.progress import Progress
from washboard.cleaned import FaceReport, judge_part
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
from webui.page.evaluations import Analysed, AnalysisSettings, analyse_run
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.cleaning.parts import FacesCard, FixCard, GapCard, MeasuredCard, PartsCard, add_part_card
from webui.panels.cleaning.tuning import TuneCard
from webui.panels.widgets.choices import checkbox, dropdown, folder, offer, on_choice, show_while
from webui.panels.widgets.job import RunButton
from webui.scene.moving import HeatView
from webui.scene.scene import Scene
from webui.theme.html import card_html, messages_html, quiet_html
from webui.threads.threads import Throttle

if TYPE_CHECKING:
    from cleaning.analyse import Effort


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
        self._throttle: Throttle[float] = Throttle(self._draw_growth, _EVERY_S)
        page.on_close(self._throttle.close)
        self._build(page.client.gui)

        def show(session: Session) -> None:
            if session.analysis is None and not self._paths.value:
                self._paths.value = True  # the checkbox is hidden
                self._show_paths(shown=True)
            if session.analysis is not None:
                offer(self._stage, stage_names(session.analysis.report.stages))
            self._redraw(session)

        def grow(now_s: float) -> None:
            self._now_s = now_s
            if self._growing is not None:
                self._throttle.request(now_s)

        page.follow(show, lambda now: now.analysis)
        page.follow(self._draw_outline, lambda now: now.selection)
        scene.on_moment(grow)

    def _build(self, gui: viser.GuiApi) -> None:
        def redraw(_: object) -> None:
            self._redraw(self._page.session)

        def show_paths(shown: bool) -> None:
            self._show_paths(shown=shown)

        with folder(self._page, "Heat map", lambda now: now.analysis is not None):
            self._measure = dropdown(gui, "Show", (_OFF, *MEASURES), "On the surface of board and parts.", redraw)
            self._stage = dropdown(gui, "Stage", _ANY, "Of the process.", redraw)
            hint = "How much, or on which side of the limit."
            self._colouring = dropdown(gui, "Colours", COLOURINGS, hint, redraw)
            hint = "For the picture alone; verdicts keep those of the parameter set."
            self._limit = on_choice(gui.add_number("Limit", 0.0, step=0.01, hint=hint), self._set_limit)
            hint = "Shows what has landed up to the moment that is played."
            self._live = checkbox(gui, "As it grows", False, hint, redraw)
            hint = "In all modes: without them only those of the selected part."
            self._paths = checkbox(gui, "Paths too", True, hint, show_paths)
            self._legend = gui.add_html("")

    def show_verdicts(self) -> None:
        """Show the map of the verdicts, unless another one is shown."""
        if self._measure.value == _OFF:
            self._measure.value = next(iter(MEASURES))
            self._redraw(self._page.session)

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

    def _draw_growth(self, now_s: float) -> None:
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


_EFFORTS: "dict[str, Effort]" = {"Fast": "fast", "Full": "full", "Sketch": "sketch"}
"""The first is the default."""
_MOST_CUT = 3
"""Paths that masks cut, named where parts are not clean."""


class CleaningPanel:
    """The cleaning prediction of the program: the analysis, its headline, and the cards that show it."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui
        names, chosen = self._names(page.session), page.session.parameters_name

        def choose(name: str) -> None:
            page.remember(lambda session: replace(session, parameters_name=name))

        hint = "Soil, liquids, film and limits: sets of the library, then those of your folder."
        self._choice = dropdown(gui, "Parameters", names, hint, choose, initial_value=chosen)
        self._effort = dropdown(gui, "Effort", _EFFORTS, "More rays are more exact, and take longer.")
        hint = "How often each part comes out clean within the ranges of the parameter set's values; takes longer."
        self._sure = checkbox(gui, "How sure", False, hint)
        hint = "Predicts what the spray reaches, above and under the parts."
        self._run: RunButton[Analysed | FaceReport] = RunButton(page, "Analyse", self._begin, hint)
        # only exposure is judged on the faces of a part
        show_while(page, lambda now: now.board is not None, self._choice, self._effort, self._sure)
        TuneCard(page)
        self._heat = HeatCard(page, scene)
        PartsCard(page, scene)
        add_part_card(page)
        FixCard(page)
        GapCard(page)
        MeasuredCard(page)
        FacesCard(page, scene)

        def show(session: Session) -> None:
            known = session.parameters_name in self._choice.options
            offer(self._choice, self._choice.options if known else self._names(session), session.parameters_name)
            driven = "" if session.judged_now is None else card_html(session.judged_now.verdict.card())
            self._run.show(state_html(session) + driven)

        page.follow(show, lambda now: (now.run, now.analysed, now.current, now.judged_now, now.parameters_name))

    def _names(self, session: Session) -> tuple[str, ...]:
        return tuple(dict.fromkeys([*self._page.project.parameter_sets(), session.parameters_name]))

    def _begin(self) -> None:
        session, project = self._page.session, self._page.project
        name, before = session.parameters_name, session.analysed_board
        run = session.planned_run
        run = session.played or run
        effort, sure = _EFFORTS[self._effort.value], self._sure.value

        def work(progress: Progress) -> Analysed | FaceReport:
            if run.workpiece.faces:
                return judge_part(run.program, run.workpiece, run.recipe, progress)
            settings = AnalysisSettings(name, project.open_parameters(name), effort, sure)
            return analyse_run(run, settings, before, progress)

        def take(analysed: Analysed | FaceReport) -> None:
            first = self._page.session.analysed is None
            self._page.remember(lambda session: replace(session, analysed=analysed))
            if first and isinstance(analysed, Analysed):  # later ones leave map and view as they were chosen
                self._heat.show_verdicts()
                self._scene.look_at_job()

        self._run.start(work, take)


def state_html(session: Session) -> str:
    """Headline of the analysis of the program as it is now, else whether an older program was analysed."""
    if session.face_analysis is not None:
        return card_html(faces_card(session.workpiece.name, session.face_analysis.verdicts))
    analysis, older = session.analysis, session.analysed
    if isinstance(older, FaceReport):
        return quiet_html("The program changed since it was analysed.")
    if analysis is not None:
        of_robot = session.played is not session.run
        headline = card_html(headline_card(analysis.report, "as the robot moves" if of_robot else "as planned"))
        run = session.run
        if run is None or report_cleanliness(analysis.report) == "clean":
            return headline
        cut = [each for each in run.findings if each.rule == CUT_BY_MASK and each.severity == "warning"]
        return headline + messages_html(cut, _MOST_CUT)
    if older is None:
        return quiet_html("Not analysed yet.")
    verdict = OUTCOME_WORDS[report_outcome(older.report)].lower()
    what = "The program or the parameters changed since it was analysed."
    check, run = session.check, session.run
    if check is not None and run is not None and older.program is run.program:
        what = "Since the check the program has the times of the robot: analyse it again."
    return quiet_html(f"{what} Before, with the parameter set {older.parameters_name}: {verdict}.")
