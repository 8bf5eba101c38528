"""One browser's page: its identity, its session, which is planned when it changes, and what follows it."""

import gc
import logging
import secrets
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import viser

from boards.board import Workpiece
from programs.errors import ProgramError
from programs.plan import Plan
from recipes.recipe import Recipe
from rulesengine.levelling.film_run import run_levelled
from rulesengine.planning.pipeline import Run
from specs.errors import JobError
from specs.progress import Progress
from specs.source import NO_SOURCE, Source
from webui.page.project import Project
from webui.page.session import READ_ONLY, Change, ReadBack, Selection, Session
from webui.threads.threads import Worker

_log = logging.getLogger(__name__)


class Page:
    """State and actions of one browser; callbacks of several threads are served one at a time."""

    def __init__(self, client: viser.ClientHandle, project: Project, session: Session) -> None:
        """Set up the state that panels share; nothing is shown before ``open``."""
        self.client = client
        self.project = project
        self.session = session
        self.planned_s: float | None = None
        """Duration of the newest planning, s; ``None`` where there was none on this page."""
        self.check: Callable[[], None] = lambda: None
        """Begins a check of the program in its cell; set by the panel of the robot."""
        self._followers: list[Callable[[Session], None]] = []
        self._lock = threading.RLock()
        self._planner: Worker[Run] = Worker(self._report_progress)
        self._planning: tuple[Recipe, Workpiece] | None = None
        """Recipe and workpiece that are being planned."""
        self._progress: list[Progress] = []
        self._closers: list[Callable[[], object]] = []
        self._pollers: list[Callable[[], None]] = []
        self._opened = self._closed = False

    def follow(self, show: Callable[[Session], object], of: Callable[[Session], object]) -> None:
        """Show the session by a function once the page is open, and whenever what is taken of it is another.

        Args:
            show: Shows a session; functions are called in the order in which they were added.
            of: What of a session it shows.
        """
        shown: list[object] = []

        def update(session: Session) -> None:
            if shown != (now := [of(session)]):
                shown[:] = now
                show(session)

        self._followers.append(update)

    def open(self) -> None:
        """Show the session, and plan it."""
        with self._lock:
            if self._closed:  # the browser left while its panels were built
                return
            self._opened = True
            self.show(self.session)
            if not self.session.planned and self.session.shown is None:
                self.plan()

    def close(self) -> None:
        """Cancel what is under way; the browser has disconnected."""
        with self._lock:
            self._closed = True
        self._planner.close()
        for close in self._closers:
            close()

    def on_close(self, close: Callable[[], object]) -> None:
        """Call a function when the browser disconnects."""
        self._closers.append(close)

    def on_poll(self, poll: Callable[[], None]) -> None:
        """Call a function now and then, which checks for changes outside the page."""
        self._pollers.append(poll)

    def poll(self) -> None:
        """Check for changes outside the page."""
        with self._lock:
            for poll in [] if self._closed else self._pollers:
                poll()

    def on_progress(self, progress: Progress) -> None:
        """Call a function with the progress of planning."""
        self._progress.append(progress)

    def attempt(self, change: Change, refused: Callable[[JobError], None] | None = None) -> bool:
        """Make an edit and show the result; a refused one changes nothing.

        Args:
            change: The edit.
            refused: Shows the reason in place of a notification.

        Returns:
            Whether it was made.
        """
        with self._lock:
            try:
                if self.session.shown is not None:
                    raise ProgramError(READ_ONLY)
                session = change(self.session)
            except Exception as error:
                if refused is not None and isinstance(error, JobError):
                    with self.client.atomic():
                        refused(error)
                    return False
                self.report(error)
                return False
            if session.planned:
                self._cancel_planning()  # of an edit that was undone
                session = replace(session, sketch=None)
            self.show(session)
            planning = self._planning
            same = planning is not None and planning[0] == session.recipe and planning[1] is session.workpiece
            if not (session.planned or same):
                self.plan()
            return True

    def open_program(self, shown: ReadBack) -> None:
        """Show a program that was read; the job goes on when it is closed."""
        with self._lock:
            self._cancel_planning()
            self.show(replace(self.session.showing(shown), sketch=None))

    def close_program(self) -> None:
        """Show the job again, and plan it if that was not done."""
        with self._lock:
            self.show(replace(self.session.resumed(), sketch=None))
            if not self.session.planned:
                self.plan()

    def remember(self, change: Change) -> None:
        """Change the session apart from workpiece and recipe: nothing is planned again."""
        with self._lock:
            self.show(change(self.session))

    def show(self, session: Session) -> None:
        """Show a session as it is."""
        with self._lock:
            self.session = session
            with self.client.atomic():
                for update in self._followers if self._opened else []:
                    update(self.session)

    def select(self, *, component: str = "", made_by: Source = NO_SOURCE) -> None:
        """Select a component, a face, a stroke, or nothing."""
        with self._lock:
            self.show(replace(self.session, selection=Selection(component, made_by)))

    def plan(self) -> None:
        """Plan the session's recipe in the background, in place of an older planning."""
        if self.session.shown is not None:
            return
        recipe, workpiece, before = self.session.recipe, self.session.workpiece, self.session.run
        begun, self._planning = time.perf_counter(), (recipe, workpiece)
        self._report_progress("planning", 0.0)

        def sketched(plan: Plan) -> None:
            with self._lock:
                if self._planning is not None and self._planning[0] is recipe:  # else it was cancelled meanwhile
                    self.show(replace(self.session, sketch=plan))

        def planned(done: Run) -> None:
            with self._lock:
                if done.recipe == self.session.recipe and done.workpiece is self.session.workpiece:
                    self.planned_s = time.perf_counter() - begun
                    fresh = self.session.run is None
                    self.show(replace(self.session, run=done, sketch=None))
                    if fresh:  # edits follow
                        freeze_gc()

        def failed(error: Exception) -> None:
            with self._lock:
                self._planning = None
                self._report_progress("not planned", 1.0)
                self.show(replace(self.session, sketch=None))
            self.report(error)

        self._planner.start(
            lambda progress: run_levelled(recipe, workpiece, progress, sketched, before), planned, failed
        )

    def cancel(self) -> None:
        """Cancel planning; the last run stays visible."""
        with self._lock:
            self._cancel_planning()
            self._report_progress("cancelled", 1.0)
            self.show(replace(self.session, sketch=None))

    def _cancel_planning(self) -> None:
        self._planner.cancel()
        self._planning = None

    def refuse(self, message: str) -> None:
        """Notify the user why something was not done."""
        self.client.add_notification("Not done", message, color="red", auto_close_seconds=12.0)

    def notify(self, title: str, message: str) -> None:
        """Notify the user that something was done."""
        self.client.add_notification(title, message, auto_close_seconds=5.0)

    def report(self, error: Exception) -> None:
        """Notify the user of an error; a defect of ours goes to the log too."""
        if isinstance(error, JobError):
            self.refuse(str(error))
            return
        _log.exception("a defect of washboard", exc_info=error)
        self.refuse(f"A defect of washboard ({type(error).__name__}); see the server's log, and please report it.")

    def _report_progress(self, what: str, done: float) -> None:
        for progress in self._progress:
            progress(what, done)


def freeze_gc() -> None:
    """Exclude all living objects from garbage collection, after a last full one.

    A board, its plan and the libraries are hundreds of thousands of objects that stay; scanning them takes as long as
    an edit. Frozen objects are still freed by reference count; cycles among them at the next call.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()


_BROWSER = "browser"
_TAB_S = 2.0
_POLL_S = 0.03
_TAB_HTML = (
    '<img alt="" style="display:none" src="data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAA=" data-tab="{name}">'
)
"""Has the script of the page copy the name of the tab to where viser reads it, once it is loaded."""


@dataclass(frozen=True, slots=True)
class BrowserIdentity:
    """A browser and its tab; empty names where the browser stores nothing."""

    browser: str
    tab: str


def identify(client: viser.ClientHandle) -> BrowserIdentity:
    """Identity of a browser and its tab by the names that were stored in them the first time.

    A tab in the background responds once it is in the foreground: that is waited for, unless it disconnects.
    """
    try:
        browser = client.local_storage.get_item(_BROWSER)
    except RuntimeError:  # storage is blocked, or the browser has disconnected
        return BrowserIdentity("", "")
    if browser is None:
        browser = secrets.token_urlsafe(12)
        client.local_storage.set_item(_BROWSER, browser)
    return BrowserIdentity(browser, _tab_of(client) if browser else "")


def _tab_of(client: viser.ClientHandle) -> str:
    new = secrets.token_hex(8)
    probe = client.gui.add_html(_TAB_HTML.format(name=new))
    name, end = None, time.monotonic() + _TAB_S
    try:
        while name is None and time.monotonic() < end:
            time.sleep(_POLL_S)
            name = client.local_storage.get_item(f"tab-{new}")
        client.local_storage.remove_item(f"tab-{new}")
    except RuntimeError:
        return ""
    finally:
        probe.remove()
    return name or ""
