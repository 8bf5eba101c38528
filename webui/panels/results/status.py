"""Status of the job, progress of planning, and views of the scene: always in sight."""

import threading
import time
from collections.abc import Callable

from webui.cards.status_strip import status_html, totals_words
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import button, buttons
from webui.scene.scene import Scene
from webui.theme.regions import STRIP_STYLE

_CANCEL, _PLAN = "Cancel", "Plan again"
_PATIENCE_S = 0.5
"""A plan that is quicker than this shows no button: it would only flicker."""
_PACE_S = 0.1
"""Shorter work is not shown, and progress not updated more often."""
_STOPPED = ("cancelled", "not planned")
_VIEWS: dict[str, Callable[[Scene], None]] = {
    "Plan": lambda scene: scene.look_at_job("plan"),
    "Iso": lambda scene: scene.look_at_job("iso"),
    "Back": Scene.look_back,
}


class StatusPanel:
    """Status of the job, progress of planning, and views of the scene: always in sight."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        self._what, self._share = "", 0.0
        self._shown: Session | None = None
        """The session that was shown last."""
        self._was = ""
        """Time and liquid of its program before the last edit; empty where there was none, or they are the same."""
        self._begun_s, self._shown_s = 0.0, 0.0
        gui = page.client.gui
        gui.add_html(STRIP_STYLE)
        self._html = gui.add_html("")

        def press() -> None:
            if self._button.label == _CANCEL:
                page.cancel()
            else:
                page.plan()

        hint = "Give up planning, or plan again."
        self._button = button(gui, _CANCEL, press, hint, visible=False, color="gray")
        hint = "Plan: from straight above. Iso: from the front. Back: the view before."
        buttons(gui, "View", _VIEWS, lambda view: _VIEWS[view](scene), hint)
        fit = gui.add_command("Fit", description="Show the board and all paths.", hotkey="F")
        fit.on_trigger(lambda _: scene.look_at_job())
        self._patience = self._new_patience()
        page.follow(self._show, lambda now: now)
        page.on_progress(self._show_progress)
        page.on_close(lambda: self._patience.cancel())

    def _show(self, session: Session) -> None:
        before, self._shown = self._shown, session
        if before is not None and session.run is not before.run:
            self._was = ""
            if session.run is not None and before.run is not None and session.workpiece is before.workpiece:
                was = totals_words(before.run)
                self._was = "" if was == totals_words(session.run) else was
        self._html.content = status_html(session, self._page.planned_s, self._what, self._share, self._was)
        stopped = self._what in _STOPPED
        self._button.label = _PLAN if stopped else _CANCEL
        if session.planned or stopped or session.shown is not None:
            self._button.visible = stopped and not session.planned and session.shown is None

    def _show_progress(self, what: str, done: float) -> None:
        begins, same, now_s = what == "planning" and done == 0.0, what == self._what, time.monotonic()
        self._what, self._share = what, done
        if begins:
            self._begun_s = now_s
            self._patience.cancel()
            self._patience = self._new_patience()
            self._patience.start()
        since_s = now_s - (self._shown_s if same else self._begun_s)
        # When it is done the run itself is about to be shown.
        if begins or what in _STOPPED or (what != "done" and since_s > _PACE_S):
            self._shown_s = now_s
            with self._page.client.atomic():
                self._show(self._page.session)

    def _new_patience(self) -> threading.Timer:
        """Timer after which planning can be cancelled."""

        def offer() -> None:
            if not self._page.session.planned and self._page.session.shown is None:
                self._button.visible = True

        timer = threading.Timer(_PATIENCE_S, offer)
        timer.daemon = True
        return timer
