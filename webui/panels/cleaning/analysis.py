"""What the program cleans: the analysis, its headline, and the cards that show it."""

from operator import is_
from typing import TYPE_CHECKING

import viser

from cleaning.verdicts.cleanliness import report_outcome
from webui.cards.boxes import quiet_html
from webui.cards.cleaning_list import headline_html
from webui.page.analysed import Analysed, Asked, analyse_run
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.cleaning.fix import FixCard
from webui.panels.cleaning.gap import GapCard
from webui.panels.cleaning.heat import HeatCard
from webui.panels.cleaning.part import PartCard
from webui.panels.cleaning.parts import PartsCard
from webui.panels.cleaning.tuning import TuneCard
from webui.panels.widgets.job import RunButton
from webui.scene.scene import Scene
from webui.theme.verdict_colours import VERDICT_WORDS

if TYPE_CHECKING:
    from cleaning.analyse import Effort

_EFFORTS: "dict[str, Effort]" = {"Fast": "fast", "Full": "full", "Sketch": "sketch"}
"""The one that comes first is chosen first."""


class CleaningPanel:
    """What the program cleans: the analysis, its headline, and the cards that show it."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        gui = page.client.gui
        self._choice = gui.add_dropdown(
            "Parameters",
            self._names(page.session),
            initial_value=page.session.parameters_name,
            hint="Soil, liquids, film and limits: sets of the library, then those of your folder.",
        )
        self._effort: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Effort", tuple(_EFFORTS), hint="More rays: each spot is known better, and it takes longer."
        )
        self._run: RunButton[Analysed] = RunButton(
            page, "Analyse", self._begin, "Predicts what the spray reaches, above and under the parts."
        )
        self._tune = TuneCard(page)
        self._cards = (PartsCard(page, scene), HeatCard(page, scene), PartCard(page), FixCard(page), GapCard(page))
        self._choice.on_update(lambda event: self._choose(event.target.value, by_hand=event.client is not None))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        for card in (self._tune, *self._cards):
            card.show(session, before)
        self._show_names(session)
        if before is None or not all(map(is_, _subject_of(session), _subject_of(before))):
            self._run.show(state_html(session))

    def _show_names(self, session: Session) -> None:
        if session.parameters_name not in self._choice.options:
            self._choice.options = self._names(session)
        if self._choice.value != session.parameters_name:
            self._choice.value = session.parameters_name

    def _names(self, session: Session) -> tuple[str, ...]:
        return tuple(dict.fromkeys([*self._page.project.parameter_sets(), session.parameters_name]))

    def _choose(self, name: str, *, by_hand: bool) -> None:
        if by_hand and name != self._page.session.parameters_name:
            self._page.remember(lambda session: session.with_parameters(name))

    def _begin(self) -> None:
        session = self._page.session
        run, name, before = session.played, session.parameters_name, session.analysed
        effort = _EFFORTS[self._effort.value]
        if run is None or not session.planned:
            self._page.refuse("The recipe as it is now is not planned yet; wait until it is.")
            return
        project = self._page.project
        self._run.start(
            lambda progress: analyse_run(run, Asked(name, project.open_parameters(name), effort), before, progress),
            self._take,
        )

    def _take(self, analysed: Analysed) -> None:
        self._page.remember(lambda session: session.with_analysis(analysed))


def _subject_of(session: Session) -> tuple[object, ...]:
    """What the line beneath the button is about."""
    return session.run, session.analysed, session.analysis, session.parameters_name


def state_html(session: Session) -> str:
    """Say whether the program as it is now was analysed with these parameters, and what came of it at one glance."""
    analysis, older = session.analysis, session.analysed
    if analysis is not None:
        return headline_html(analysis.report)
    if older is None:
        return quiet_html("Not analysed yet.")
    told = VERDICT_WORDS[report_outcome(older.report)].lower()
    return quiet_html(
        "The program or the parameters changed since it was analysed. "
        f"Before, with the parameter set {older.parameters_name}: {told}."
    )
