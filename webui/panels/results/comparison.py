"""Other recipes: one beside this on the same workpiece, and the combinations of a study."""

from collections.abc import Sequence
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np

from geometry.arrays import Points
from reports.tables.comparison import Row, compare, comparison_tables
from reports.tables.table import lines_of
from rulesengine.levelling.film_run import run_levelled
from rulesengine.planning.pipeline import Run
from specs.progress import Progress
from studies.results.card import combination_card, effects_card, tables_card
from studies.results.read_tables import Combination
from webui.cards.study_card import ORDERS, choose_combinations, combinations_html, pareto_svg
from webui.glb.glb import line_width_mm, size_mm
from webui.layers.paths.strokes import StrokeLine, stroke_lines, strokes_glb
from webui.page.evaluations import OpenedCombination, OpenedStudy, open_combination, open_study
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import NONE, Stepper, button, checkbox, dropdown, folder, html, offer
from webui.panels.widgets.job import Dialog, Job
from webui.scene.scene import Scene
from webui.theme.html import card_html, quiet_html
from webui.theme.palette import ACCENT, INK, QUIET, css_colour

_NONE: str = "nothing"
_SAVED: str = "as it is saved"
_LAYER = "/compared"
_SAME_MM = 0.01
"""Paths that are nearer to each other than this all along are the same."""
_RIGHT = "text-align:right;white-space:nowrap;padding:0 0 0 6px;"


class ComparePanel:
    """Two recipes on the same workpiece, side by side."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui, hint = page.client.gui, "A recipe to compare with, on the same workpiece."
        self._choice = dropdown(gui, "With", self._names(), hint, self._choose)
        hint = "Draws those that are not the same, in grey."
        self._paths = checkbox(gui, "Its other paths", True, hint, lambda _: self._draw(page.session))
        self._job: Job[Run] = Job(page, refuse=page.refuse, cancelled=self._reset)
        self._table = gui.add_html("")

        def forget(_: Session) -> None:
            self._job.stop()
            self._reset()

        def offer_names(session: Session) -> None:
            names, chosen = self._names(), self._choice.value
            if session.compared is not None and chosen in (_NONE, ""):  # after a reload
                chosen = next((name for name in names if Path(name).stem == session.compared.recipe.recipe), _SAVED)
            offer(self._choice, names, chosen if chosen in names else _NONE)

        page.follow(forget, lambda now: now.workpiece)
        page.follow(offer_names, lambda now: now.document.file)
        page.follow(self._draw, lambda now: (now.run, now.compared))

    def _names(self) -> tuple[str, ...]:
        return (_NONE, _SAVED, *self._page.project.recipes())

    def _choose(self, name: str) -> None:
        session = self._page.session
        self._job.stop()
        self._page.show(replace(session, compared=None))
        if name == _NONE:
            return

        def plan(progress: Progress) -> Run:
            document = session.document
            if name == _SAVED:
                document = replace(document, text=document.saved)
            else:
                document = self._page.project.open_recipe(name)
            return run_levelled(document.read().recipe, session.workpiece, progress)

        def take(other: Run) -> None:
            self._page.attempt(lambda now: replace(now, compared=other) if other.workpiece is now.workpiece else now)

        self._job.start(plan, take, lambda _: self._reset())

    def _reset(self) -> None:
        offer(self._choice, self._choice.options, _NONE)

    def _draw(self, session: Session) -> None:
        """Show the table, and the paths of the other recipe that this one does not have."""
        table, note, glb = "", "Choose a recipe: it is planned on this workpiece, and the differences are shown.", b""
        if session.compared is not None:
            note = "" if session.run is not None else "The recipe is not planned yet."
        if session.run is not None and session.compared is not None:
            here, there = session.run.recipe.recipe, session.compared.recipe.recipe
            rows = compare(session.run, session.compared)
            table = comparison_html(rows, "this", "the other" if here == there else there)
            lines = unlike_strokes(session.run, session.compared) if self._paths.value else []
            glb = strokes_glb(lines, [QUIET] * len(lines), line_width_mm(size_mm(session.workpiece)))
        with self._page.client.atomic():
            self._job.show(quiet_html(note))
            self._table.content = table
            self._scene.draw_over(_LAYER, glb)


def unlike_strokes(here: Run, there: Run) -> list[StrokeLine]:
    """Strokes of the second run that the first does not have: another path, or none of that name."""

    def name(line: StrokeLine) -> str:
        """Function, template and components, which identify a stroke in both recipes."""
        return f"{line.function}/{replace(line.made_by, step=0)}"

    def same(one: Points, other: Points) -> bool:
        return one.shape == other.shape and bool(np.abs(one - other).max(initial=0.0) <= _SAME_MM)

    paths: dict[str, list[Points]] = {}
    for line in stroke_lines(here.plan):
        paths.setdefault(name(line), []).append(line.points)
    return [
        line
        for line in stroke_lines(there.plan)
        if not any(same(line.points, path) for path in paths.get(name(line), []))
    ]


def comparison_html(rows: Sequence[Row], here: str, there: str) -> str:
    """Table of two runs: differences in ink with their change, equal values in grey."""
    lines = ""
    for table in comparison_tables(rows, (here, there), ""):
        lines += f'<tr><td colspan="4" style="padding-top:8px;font-weight:600">{escape(table.title)}</td></tr>'
        for row in table.rows:
            (name,), *values, (change,) = (lines_of(cell)[0] for cell in row)
            lines += f'<tr style="vertical-align:top"><td style="overflow-wrap:anywhere">{escape(name.text)}</td>'
            for (text,) in values:
                ink = css_colour(QUIET if text.emphasis else INK)
                lines += f'<td style="{_RIGHT}color:{ink}">{escape(text.text)}</td>'
            lines += f'<td style="{_RIGHT}color:{css_colour(ACCENT)}">{escape(change.text)}</td></tr>'
    heads = "".join(
        f'<th style="{_RIGHT}white-space:normal;overflow-wrap:anywhere;font-weight:600">{escape(text)}</th>'
        for text in (here, there)
    )
    return (
        f'<table style="margin:4px 12px;width:calc(100% - 24px);border-collapse:collapse;table-layout:fixed;'
        f'font-size:12px;line-height:1.6;color:{css_colour(INK)};font-variant-numeric:tabular-nums">'
        '<colgroup><col style="width:25%"><col style="width:28%"><col style="width:28%"><col style="width:19%">'
        f"</colgroup><tr><th></th>{heads}<th></th></tr>{lines}</table>"
    )


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
