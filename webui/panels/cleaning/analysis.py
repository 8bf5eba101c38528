"""The cleaning prediction of the program: the analysis, its headline, and the cards that show it."""

from dataclasses import replace
from typing import TYPE_CHECKING

import viser

from cleaning.verdicts.results import report_cleanliness, report_outcome
from reports.cards.cleaning import faces_card, headline_card
from reports.tables.cleaning_tables import OUTCOME_WORDS
from specs.finding_rules import CUT_BY_MASK
from specs.progress import Progress
from washboard.cleaned import FaceReport, judge_part
from webui.page.evaluations import Analysed, AnalysisSettings, analyse_run
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.cleaning.faces import FacesCard
from webui.panels.cleaning.fix import FixCard
from webui.panels.cleaning.heat import HeatCard
from webui.panels.cleaning.measured import MeasuredCard
from webui.panels.cleaning.parts import GapCard, PartCard, PartsCard
from webui.panels.cleaning.tuning import TuneCard
from webui.panels.widgets.choices import offer, on_choice
from webui.panels.widgets.job import RunButton
from webui.scene.scene import Scene
from webui.theme.html import card_html, messages_html, quiet_html

if TYPE_CHECKING:
    from cleaning.analyse import Effort

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
        self._choice = gui.add_dropdown(
            "Parameters",
            self._names(page.session),
            initial_value=page.session.parameters_name,
            hint="Soil, liquids, film and limits: sets of the library, then those of your folder.",
        )
        self._effort: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Effort", tuple(_EFFORTS), hint="More rays are more exact, and take longer."
        )
        self._sure = gui.add_checkbox(
            "How sure",
            initial_value=False,
            hint="How often each part comes out clean within the ranges of the parameter set's values; takes longer.",
        )
        self._run: RunButton[Analysed | FaceReport] = RunButton(
            page, "Analyse", self._begin, "Predicts what the spray reaches, above and under the parts."
        )
        self._tune = TuneCard(page)
        self._heat = HeatCard(page, scene)
        parts = (PartsCard(page, scene), self._heat, PartCard(page), FixCard(page), GapCard(page))
        self._cards = (*parts, MeasuredCard(page), FacesCard(page, scene))
        on_choice(self._choice, lambda name: page.remember(lambda session: replace(session, parameters_name=name)))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        for card in (self._tune, *self._cards):
            card.show(session, before)
        if before is None or session.board is not before.board:  # only exposure is judged on the faces of a part
            for handle in (self._choice, self._effort, self._sure):
                handle.visible = session.board is not None
        known = session.parameters_name in self._choice.options
        offer(self._choice, self._choice.options if known else self._names(session), session.parameters_name)
        subject = session.run, session.analysed, session.analysis, session.face_analysis, session.parameters_name
        self._run.show(state_html(session), subject)

    def _names(self, session: Session) -> tuple[str, ...]:
        return tuple(dict.fromkeys([*self._page.project.parameter_sets(), session.parameters_name]))

    def _begin(self) -> None:
        session, project = self._page.session, self._page.project
        name, before = session.parameters_name, session.analysed
        run = session.planned_run
        run = session.played or run
        effort, sure = _EFFORTS[self._effort.value], self._sure.value

        def work(progress: Progress) -> Analysed | FaceReport:
            if run.workpiece.faces:
                return judge_part(run.program, run.workpiece, run.recipe, progress)
            settings = AnalysisSettings(name, project.open_parameters(name), effort, sure)
            return analyse_run(run, settings, before, progress)

        def take(analysed: Analysed | FaceReport) -> None:
            if isinstance(analysed, FaceReport):
                self._page.remember(lambda session: replace(session, analysed_faces=analysed))
            else:
                first = self._page.session.analysed is None
                self._page.remember(lambda session: replace(session, analysed=analysed))
                if first:  # later ones leave map and view as they were chosen
                    self._heat.show_verdicts()
                    self._scene.look_at_job()

        self._run.start(work, take)


def state_html(session: Session) -> str:
    """Headline of the analysis of the program as it is now, else whether an older program was analysed."""
    if session.face_analysis is not None:
        return card_html(faces_card(session.workpiece.name, session.face_analysis.verdicts))
    if session.analysed_faces is not None:
        return quiet_html("The program changed since it was analysed.")
    analysis, older = session.analysis, session.analysed
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
