"""Two recipes on the same workpiece, side by side."""

from collections.abc import Sequence
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np

from geometry.arrays import Points
from reports.tables.comparison import Row, compare, comparison_tables
from reports.tables.table import lines_of
from rulesengine.planning.pipeline import Run, run
from specs.progress import Progress
from webui.glb.glb import line_width_mm, size_mm
from webui.layers.paths.strokes import StrokeLine, stroke_lines, strokes_glb
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import checkbox, dropdown, offer
from webui.panels.widgets.job import Job
from webui.scene.scene import Scene
from webui.theme.html import quiet_html
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
            return run(document.read().recipe, session.workpiece, progress)

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
