"""A study of the project folder: its combinations as a table and a picture, one of them in full, main effects."""

from dataclasses import replace

from specs.progress import Progress
from studies.results.card import combination_card, effects_card, tables_card
from studies.results.read_tables import Combination
from webui.cards.study_card import (
    ORDERS,
    choose_combinations,
    combinations_html,
    pareto_svg,
)
from webui.page.page import Page
from webui.page.session import Session
from webui.page.study import OpenedCombination, OpenedStudy, open_combination, open_study
from webui.panels.widgets.choices import NONE, Stepper, button, checkbox, dropdown, folder, html, offer
from webui.panels.widgets.dialog import Dialog
from webui.panels.widgets.job import Job
from webui.scene.scene import Scene
from webui.theme.html import card_html, quiet_html

OPEN, TAKE = "Open a study\N{HORIZONTAL ELLIPSIS}", "Open board and recipe"
_NOTE = "Shows what `washboard study` wrote into a folder of the project: runs.csv, and the tables beside it."
_NO_BOARD: tuple[str, ...] = (NONE,)
_HINTS = ("Shows it in full, and where it is in the picture.", "Through the combinations that are listed.")


class StudyPanel:
    """A study of the project folder."""

    def __init__(self, page: Page, _scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        self._chosen = ""
        """Number of the chosen combination."""
        gui = page.client.gui

        def relist(_: object) -> None:
            self._list_combinations(page.session)

        button(gui, OPEN, self._choose_study, "A table of runs in the project folder, as the command wrote it.")
        self._job: Job[OpenedStudy] = Job(page, refuse=page.refuse, cancelled=lambda: None)
        with folder(page, "Combinations", lambda now: now.study is not None):
            self._board = dropdown(gui, "Board", _NO_BOARD, "Of the study.", lambda _: self._choose(""))
            self._order = dropdown(gui, "Order by", ORDERS, "What comes first in the list.", relist)
            self._front = checkbox(gui, "Pareto front", False, "Only those that no other one is better than.", relist)
            self._picture = gui.add_html("")
            self._list = gui.add_html("")
            self._steps = Stepper(gui, ("Combination", "Through"), _HINTS, self._choose)
            self._card = gui.add_html("")
            hint = "The board, and the recipe with the values as one edit."
            self._take = button(gui, TAKE, self._take_combination, hint)
            self._opening: Job[OpenedCombination] = Job(page, refuse=page.refuse, cancelled=lambda: None)
        with folder(page, "Main effects", lambda now: now.study is not None and now.study.tables.effects):
            html(
                page,
                lambda now: "" if now.study is None else card_html(effects_card(now.study.tables.effects)),
                lambda now: now.study,
            )
        page.follow(self._show, lambda now: now.study)

    def _show(self, session: Session) -> None:
        study = session.study
        self._chosen = ""
        if study is None:
            self._job.show(quiet_html(_NOTE))
            return
        self._job.show(card_html(tables_card(study.name, study.tables)))
        boards = study.tables.boards
        offer(self._board, boards, self._board.value if self._board.value in boards else boards[0])
        self._list_combinations(session)

    def _choose_study(self) -> None:
        project = self._page.project
        names = project.studies()
        if not names:
            self._page.refuse(f"There is no study in {project.folder}; `washboard study` writes one into its folder.")
            return
        dialog = Dialog(self._page, "Open a study", "Board and recipe stay as they are.")
        dialog.choice("Study", names, "The table of its runs.")

        def show(study: OpenedStudy) -> None:
            self._page.remember(lambda session: replace(session, study=study))

        dialog.button("Open", lambda name: self._job.start(lambda progress: open_study(project, name, progress), show))

    def _choose(self, number: str) -> None:
        self._chosen = number
        self._list_combinations(self._page.session)

    def _list_combinations(self, session: Session) -> None:
        study = session.study
        if study is None:
            return
        shown = choose_combinations(study.tables, self._board.value, self._order.value, front=self._front.value)
        chosen = self._combination(study)
        with self._page.client.atomic():
            self._picture.content = pareto_svg(shown, self._chosen)
            self._list.content = combinations_html(study.tables, shown, self._chosen)
            self._steps.offer([str(each.number) for each in shown], self._chosen)
            self._card.content = "" if chosen is None else card_html(combination_card(study.tables, chosen))
            self._take.visible = chosen is not None

    def _combination(self, study: OpenedStudy) -> Combination | None:
        return next((each for each in study.tables.combinations if str(each.number) == self._chosen), None)

    def _take_combination(self) -> None:
        """Open the board and the recipe of the chosen combination; not silently in place of what is not saved."""
        if not self._page.session.document.dirty:
            self._begin_opening()
            return
        dialog = Dialog(self._page, TAKE, "Changes of the recipe that were not saved are lost.")

        dialog.button("Open", lambda _: self._begin_opening())

    def _begin_opening(self) -> None:
        study, project = self._page.session.study, self._page.project
        combination = None if study is None else self._combination(study)
        if study is None or combination is None:
            return

        def work(progress: Progress) -> OpenedCombination:
            return open_combination(project, study, combination, progress)

        def take(opened: OpenedCombination) -> None:
            def change(session: Session) -> Session:
                session = session.with_document(opened.document)
                session = replace(session, parameters_name=opened.parameters_name)
                return session.with_workpiece(opened.board_name, opened.board)

            self._page.attempt(change)

        self._opening.start(work, take)
