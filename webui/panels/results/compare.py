"""Two recipes on the same board, side by side."""

from dataclasses import replace
from pathlib import Path

import viser

from recipes.load import recipe_library
from reports.tables.comparison import compare
from rulesengine.planning.pipeline import Run, run
from specs.progress import Progress
from webui.glb.ribbons import board_size_mm, line_width_mm
from webui.layers.paths.strokes import strokes_glb
from webui.page.document import open_document
from webui.page.page import Page
from webui.page.run_comparison import comparison_html, unlike_strokes
from webui.page.session import Session
from webui.scene.scene import Scene
from webui.theme.palette import INK, QUIET, to_hex
from webui.threads.worker import Worker

_NONE: str = "nothing"
_SAVED: str = "as it is saved"
_SCALE = 0.001


class ComparePanel:
    """Two recipes on the same board, side by side."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._worker: Worker[Run] = Worker(self._show_progress)
        self._drawn: viser.GlbHandle | None = None
        page.on_close(self._worker.close)
        gui = page.client.gui
        self._choice = gui.add_dropdown(
            "With", (_NONE, _SAVED, *page.project.recipes()), hint="A recipe to compare with, on the same board."
        )
        self._paths = gui.add_checkbox("Its other paths", True, hint="Draws those that are not the same, in grey.")
        self._table = gui.add_html("")
        self._choice.on_update(lambda event: self._choose(by_hand=event.client is not None))
        self._paths.on_update(lambda _: self._draw(page.session))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is not None and session.board is not before.board:
            self._worker.cancel()
            self._choice.value = _NONE
        if before is None or session.document.file != before.document.file:
            self._list_recipes(session.compared)
        if before is None or session.run is not before.run or session.compared is not before.compared:
            self._table.content = _table_html(session)
            self._draw(session)

    def _list_recipes(self, compared: Run | None) -> None:
        """Offer the recipes that there are now; what is compared after a reload stays chosen."""
        chosen = self._choice.value
        names = (_NONE, _SAVED, *self._page.project.recipes())
        self._choice.options = names
        if compared is not None:
            stems = {Path(name).stem: name for name in names}
            self._choice.value = chosen if chosen not in (_NONE, "") else stems.get(compared.recipe.recipe, _SAVED)

    def _choose(self, *, by_hand: bool) -> None:
        if not by_hand:
            return
        name, session = self._choice.value, self._page.session
        self._worker.cancel()
        self._page.show(replace(session, compared=None))
        if name != _NONE:
            self._worker.start(lambda progress: self._plan(name, session, progress), self._take, self._fail)

    def _plan(self, name: str, session: Session, progress: Progress) -> Run:
        """Plan the other recipe on the board of the session.

        Raises:
            JobError: it cannot be read or planned.
        """
        document = session.document
        if name == _SAVED:
            document = replace(document, text=document.saved)
        else:
            document = open_document(name if name in recipe_library() else str(self._page.project.locate(name)))
        return run(document.read().recipe, session.board, progress)

    def _take(self, other: Run) -> None:
        self._page.attempt(
            lambda session: replace(session, compared=other) if other.board is session.board else session
        )

    def _fail(self, error: Exception) -> None:
        self._choice.value = _NONE
        self._table.content = _table_html(self._page.session)
        self._page.report(error)

    def _show_progress(self, what: str, done: float) -> None:
        self._table.content = _note_html(f"{what.capitalize()}\N{HORIZONTAL ELLIPSIS} {done:.0%}")

    def _draw(self, session: Session) -> None:
        """Draw the paths of the other recipe that are not those of this one."""
        drawn, self._drawn = self._drawn, None
        if drawn is not None:
            drawn.remove()
        if session.run is not None and session.compared is not None and self._paths.value:
            lines = unlike_strokes(session.run, session.compared)
            glb = strokes_glb(lines, [QUIET] * len(lines), line_width_mm(board_size_mm(session.board)))
            if glb:
                self._drawn = self._page.client.scene.add_glb("/compared", glb, scale=_SCALE)


def _table_html(session: Session) -> str:
    if session.compared is None:
        return _note_html("Choose a recipe: it is planned on this board, and what differs is shown.")
    if session.run is None:
        return _note_html("The recipe is not planned yet.")
    here, there = session.run.recipe.recipe, session.compared.recipe.recipe
    rows = compare(session.run, session.compared)
    return comparison_html(rows, "this", "the other" if here == there else there)


def _note_html(text: str) -> str:
    return f'<div style="margin:4px 12px;font-size:12px;color:{to_hex(INK)}">{text}</div>'
