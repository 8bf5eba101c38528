"""The job as a tree: steps of the sequence and their paths, with their times; chosen, reordered, switched, added."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import viser

from recipes.recipe import Recipe
from reports.tables.wording import clock
from rulesengine.planning.pipeline import Run
from specs.source import NO_SOURCE, Source
from webui.forms.entries import Entry, removed
from webui.layers.paths.strokes import times_by_place
from webui.page.page import Page
from webui.page.session import Selection, Session
from webui.panels.widgets.choices import button, buttons, dropdown, offer, show_while
from webui.scene.scene import Scene
from webui.theme.html import quiet_html
from webui.theme.page_head import JOB_STYLE

_UP, _DOWN, _SWITCH, _REMOVE = "Up", "Down", "On/off", "Remove"
_TURNED = "\N{UPWARDS ARROW LEFTWARDS OF DOWNWARDS ARROW}"
_HINT = (
    "Choose a step or a path: its strokes are highlighted, and its values open in the tab Recipe. "
    f"{_TURNED}: the board is turned over before this step."
)


@dataclass(frozen=True, slots=True)
class Row:
    """A step, or one of its paths."""

    step: int
    path: int | None = None
    """Place among the paths of the step; ``None`` for the step itself."""


def rows_of(recipe: Recipe) -> list[Row]:
    """Rows of the tree, in the order of the program."""
    return [
        row
        for index, step in enumerate(recipe.sequence)
        for row in (Row(index), *(Row(index, place) for place in range(len(step.paths))))
    ]


def source_of(recipe: Recipe, row: Row) -> Source:
    """The step, or the template in the step, that a row stands for."""
    return Source(row.step) if row.path is None else Source(row.step, recipe.sequence[row.step].paths[row.path])


def label_of(session: Session, row: Row, times: dict[Source, float]) -> str:
    """Name of a row, and its time in the program."""
    step, source = session.recipe.sequence[row.step], source_of(session.recipe, row)
    if row.path is None:
        before = [each.side for each in session.recipe.sequence[: row.step] if each.enabled]
        gap = f" {_TURNED} " if step.enabled and before and before[-1] != step.side else "  "
        name = f"{row.step + 1}{gap}{step.function}, {step.nozzle}, {step.side}"
    else:
        name = f"\N{EM SPACE}\N{EM SPACE}{step.paths[row.path]}"
    if not step.enabled or (times and Source(row.step) not in times):
        reason = "off" if not step.enabled else "unused"
        return f"{name}  ({reason})" if row.path is None else name
    repeated = row.path is not None and step.paths.count(step.paths[row.path]) > 1
    time_s = times.get(source, 0.0) / (step.paths.count(source.template) if repeated else 1)
    return f"{name}  \N{MIDDLE DOT}  {clock(time_s)}" if time_s else name


class JobPanel:
    """The job as a tree of steps and paths."""

    def __init__(self, page: Page, _scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        self._row: Row | None = None
        """What is chosen."""
        self._times: dict[Source, float] = {}
        """Seconds of each step and path in the newest run."""
        self._timed: Run | None = None
        self._rows: list[viser.GuiButtonHandle] = []
        gui = page.client.gui
        gui.add_html(JOB_STYLE)
        gui.add_html(quiet_html(_HINT))
        actions = buttons(gui, "Chosen", (_UP, _DOWN, _SWITCH, _REMOVE), self._do)
        hint = "Template that Add path adds to the chosen step."
        self._path = dropdown(gui, "Path", page.session.recipe.templates, hint)
        add = buttons(gui, "Add", ("Add path", "Add step"), self._append, "After what is chosen.")
        self._tree = gui.add_folder(None)  # last, so that a long sequence leaves the actions in sight
        show_while(page, lambda now: now.shown is None, actions, self._path, add)
        page.follow(lambda now: offer(self._path, tuple(now.recipe.templates)), lambda now: now.recipe)

        def choose_selected(session: Session) -> None:
            """Choose the row of the stroke that is selected; the chosen one may stand for it too."""
            made_by, recipe = session.selection.made_by, session.recipe
            fitting = [row for row in rows_of(recipe) if made_by and source_of(recipe, row) in (made_by, made_by.place)]
            self._row = self._row if self._row in fitting else next(iter(fitting), None)

        page.follow(choose_selected, lambda now: now.selection)
        page.follow(self._show, lambda now: now)

    def _show(self, session: Session) -> None:
        rows = [] if session.shown is not None else rows_of(session.recipe)
        if self._row not in rows:
            self._row = None
        if session.run is not self._timed:
            self._timed, self._times = session.run, {} if session.run is None else times_by_place(session.run.program)
        labels = [label_of(session, row, self._times) for row in rows]
        for index, row in enumerate(self._rows):  # rows that are not needed now are kept: others may come again
            row.visible = index < len(labels)
        for index, label in enumerate(labels):
            marked = f"\N{BLACK RIGHT-POINTING SMALL TRIANGLE} {label}" if rows[index] == self._row else label
            if index == len(self._rows):
                with self._tree:
                    self._rows.append(button(self._page.client.gui, marked, partial(self._choose, index)))
            self._rows[index].label = marked

    def _choose(self, index: int) -> None:
        recipe = self._page.session.recipe
        rows = rows_of(recipe)
        if index >= len(rows):  # clicked before the browser heard that the row went
            return
        row = rows[index]
        again = row == self._row
        self._row = None if again else row
        self._page.select(made_by=NO_SOURCE if again else source_of(recipe, row))

    def _do(self, what: str) -> None:
        row = self._row
        if row is None:
            self._page.refuse("Choose a step or a path of the tree first.")
            return
        by = {_UP: -1, _DOWN: 1}.get(what)
        if by is not None:
            self._attempt(lambda session: moved(session, row, by))
        elif what == _SWITCH:
            path = ("sequence", row.step, "enabled")
            self._attempt(lambda session: (session.set_value(path, not session.recipe.sequence[row.step].enabled), row))
        elif row.path is None:
            self._attempt(lambda session: (removed(session, Entry(("sequence", row.step), "")), None))
        else:
            path = ("sequence", row.step, "paths", row.path)
            self._attempt(lambda session: (session.remove(path), Row(row.step)))

    def _append(self, what: str) -> None:
        recipe, row = self._page.session.recipe, self._row or Row(len(self._page.session.recipe.sequence) - 1)
        step = recipe.sequence[row.step]
        if what == "Add path":
            place = len(step.paths) if row.path is None else row.path + 1
            at = ("sequence", row.step, "paths", place)
            self._attempt(lambda session: (session.insert(at, self._path.value), Row(row.step, place)))
            return
        value = step.model_dump(mode="json", exclude_defaults=True)
        self._attempt(lambda session: (session.insert(("sequence", row.step + 1), value), Row(row.step + 1)))

    def _attempt(self, change: Callable[[Session], tuple[Session, Row | None]]) -> None:
        """Make an edit, and choose the row that it gives."""

        def edit(session: Session) -> Session:
            after, self._row = change(session)
            made_by = NO_SOURCE if self._row is None else source_of(after.recipe, self._row)
            return replace(after, selection=Selection(made_by=made_by))

        self._page.attempt(edit)


def moved(session: Session, row: Row, by: int) -> tuple[Session, Row]:
    """Move a step among the steps, or a path among those of its step; the ends stay where they are."""
    step = session.recipe.sequence[row.step]
    if row.path is None:
        to = min(max(row.step + by, 0), len(session.recipe.sequence) - 1)
        return session.move(("sequence", row.step), to), Row(to)
    to = min(max(row.path + by, 0), len(step.paths) - 1)
    return session.move(("sequence", row.step, "paths", row.path), to), Row(row.step, to)
