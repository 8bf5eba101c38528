"""One browser's page: holds its session, plans when it changes, and has panels and scene show it."""

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import viser

from boards.board import Board
from programs.plan import Plan
from recipes.recipe import Recipe
from rulesengine.planning.pipeline import Run, run
from specs.errors import JobError
from specs.progress import Progress
from webui.page.project import Project
from webui.page.session import Change, Selection, Session
from webui.threads.freeze_gc import set_aside
from webui.threads.worker import Worker

_log = logging.getLogger(__name__)


class Panel(Protocol):
    """Something that shows a session; it builds its elements when it is made."""

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session; ``before`` is what was shown last, ``None`` at first."""
        ...


class Page:
    """What one browser sees and does; its callbacks come from several threads, one at a time is served."""

    def __init__(self, client: viser.ClientHandle, project: Project, session: Session) -> None:
        """Keep what the panels share; nothing is shown before ``open``."""
        self.client = client
        self.project = project
        self.session = session
        self.planned_s: float | None = None
        """How long the newest plan took, s; ``None`` where none was made on this page."""
        self._shown: Session | None = None
        self._panels: list[Panel] = []
        self._lock = threading.RLock()
        self._planner: Worker[Run] = Worker(self._report_progress)
        self._planning: tuple[Recipe, Board] | None = None
        """What is being planned."""
        self._progress: list[Progress] = []
        self._endings: list[Callable[[], None]] = []
        self._looks: list[Callable[[], None]] = []
        self._closed = False

    def open(self, panels: list[Panel]) -> None:
        """Show the session in its panels, and plan it."""
        with self._lock:
            if self._closed:  # the browser left while its panels were built
                return
            self._panels = panels
            self._show()
            if not self.session.planned:
                self.plan()

    def close(self) -> None:
        """Give up what is under way; the browser is gone."""
        with self._lock:
            self._closed = True
        self._planner.close()
        for end in self._endings:
            end()

    def on_close(self, end: Callable[[], None]) -> None:
        """Have somebody told that the browser is gone."""
        self._endings.append(end)

    def on_look(self, look: Callable[[], None]) -> None:
        """Have somebody look, now and then, at what may have changed outside the page."""
        self._looks.append(look)

    def look(self) -> None:
        """See what changed outside the page."""
        with self._lock:
            for look in [] if self._closed else self._looks:
                look()

    def on_progress(self, progress: Progress) -> None:
        """Have somebody told how far planning is."""
        self._progress.append(progress)

    def attempt(self, change: Change, refused: Callable[[JobError], None] | None = None) -> bool:
        """Do an edit and show what comes of it; a refused one changes nothing and says why.

        Args:
            change: The edit.
            refused: Says why in place of a notification.

        Returns:
            Whether it was done.
        """
        with self._lock:
            try:
                session = change(self.session)
            except Exception as error:
                if refused is not None and isinstance(error, JobError):
                    with self.client.atomic():
                        refused(error)
                    return False
                self.report(error)
                return False
            if session.planned:
                self._give_up()  # what an undone edit asked for is no longer wanted
                session = replace(session, sketch=None)
            self.show(session)
            if not (session.planned or self._is_planning(session)):
                self.plan()
            return True

    def remember(self, change: Change) -> None:
        """Change what the session knows besides board and recipe: nothing is planned anew."""
        with self._lock:
            self.show(change(self.session))

    def show(self, session: Session) -> None:
        """Show a session as it is."""
        with self._lock:
            self.session = session
            self._show()

    def refresh(self) -> None:
        """Have the panels show the session once more, because one of them shows another part of it."""
        with self._lock:
            self._show()

    def select(self, *, component: str = "", made_by: str = "") -> None:
        """Point at a component, a stroke, or nothing."""
        with self._lock:
            self.show(replace(self.session, selection=Selection(component, made_by)))

    def plan(self) -> None:
        """Plan the session's recipe beside the page; what comes later replaces it."""
        recipe, board, before = self.session.recipe, self.session.board, self.session.run
        begun, self._planning = time.perf_counter(), (recipe, board)
        self._report_progress("planning", 0.0)
        self._planner.start(
            lambda progress: run(recipe, board, progress, lambda plan: self._sketched(plan, recipe), before),
            lambda done: self._planned(done, begun),
            self._not_planned,
        )

    def cancel(self) -> None:
        """Give up planning; the last run stays in sight."""
        with self._lock:
            self._give_up()
            self._report_progress("cancelled", 1.0)
            self.show(replace(self.session, sketch=None))

    def _is_planning(self, session: Session) -> bool:
        if self._planning is None:
            return False
        recipe, board = self._planning
        return recipe == session.recipe and board is session.board

    def _give_up(self) -> None:
        self._planner.cancel()
        self._planning = None

    def refuse(self, message: str) -> None:
        """Say why something was not done."""
        self.client.add_notification("Not done", message, color="red", auto_close_seconds=12.0)

    def say(self, title: str, message: str) -> None:
        """Say that something was done."""
        self.client.add_notification(title, message, auto_close_seconds=5.0)

    def _show(self) -> None:
        with self.client.atomic():
            for panel in self._panels:
                panel.show(self.session, self._shown)
        self._shown = self.session

    def _sketched(self, plan: Plan, recipe: Recipe) -> None:
        """Show a first plan, unless planning was given up meanwhile."""
        with self._lock:
            if self._planning is not None and self._planning[0] is recipe:
                self.show(replace(self.session, sketch=plan))

    def _planned(self, done: Run, begun: float) -> None:
        with self._lock:
            if done.recipe == self.session.recipe and done.board is self.session.board:
                self.planned_s = time.perf_counter() - begun
                fresh = self.session.run is None
                self.show(replace(self.session, run=done, sketch=None))
                if fresh:  # edits follow
                    set_aside()

    def _not_planned(self, error: Exception) -> None:
        with self._lock:
            self._planning = None
            self._report_progress("not planned", 1.0)
            self.show(replace(self.session, sketch=None))
        self.report(error)

    def report(self, error: Exception) -> None:
        """Say what stopped something; a defect of ours goes to the log."""
        if isinstance(error, JobError):
            self.refuse(str(error))
            return
        _log.exception("a defect of washboard", exc_info=error)
        self.refuse(f"A defect of washboard ({type(error).__name__}); the server's log says more. Please report it.")

    def _report_progress(self, what: str, done: float) -> None:
        for progress in self._progress:
            progress(what, done)
