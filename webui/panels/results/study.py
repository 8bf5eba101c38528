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
from webui.panels.widgets.choices import NONE, Stepper, button, dropdown, offer, on_choice
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

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        del scene
        self._page = page
        self._chosen = ""
        """Number of the chosen combination."""
        gui = page.client.gui
        button(gui, OPEN, self._choose_study, "A table of runs in the project folder, as the command wrote it.")
        self._job: Job[OpenedStudy] = Job(page, refuse=page.refuse, cancelled=lambda: None)
        self._folder = gui.add_folder("Combinations", visible=False)
        with self._folder:
            self._board = dropdown(gui, "Board", _NO_BOARD, "Of the study.", lambda _: self._choose(""))
            self._order = gui.add_dropdown("Order by", tuple(ORDERS), hint="What comes first in the list.")
            self._front = gui.add_checkbox("Pareto front", False, hint="Only those that no other one is better than.")
            self._picture = gui.add_html("")
            self._list = gui.add_html("")
            self._steps = Stepper(gui, ("Combination", "Through"), _HINTS, self._choose)
            self._card = gui.add_html("")
            self._take = gui.add_button(TAKE, hint="The board, and the recipe with the values as one edit.")
            self._opening: Job[OpenedCombination] = Job(page, refuse=page.refuse, cancelled=lambda: None)
        self._effects_folder = gui.add_folder("Main effects", visible=False)
        with self._effects_folder:
            self._effects = gui.add_html("")
        self._take.on_click(lambda _: self._take_combination())
        on_choice(self._order, lambda _: self._list_combinations(page.session))
        on_choice(self._front, lambda _: self._list_combinations(page.session))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is not None and session.study is before.study:
            return
        study = session.study
        self._chosen = ""
        self._folder.visible = study is not None
        self._effects_folder.visible = study is not None and bool(study.tables.effects)
        if study is None:
            self._job.show(quiet_html(_NOTE))
            return
        self._job.show(card_html(tables_card(study.name, study.tables)))
        boards = study.tables.boards
        offer(self._board, boards, self._board.value if self._board.value in boards else boards[0])
        self._effects.content = card_html(effects_card(study.tables.effects))
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
