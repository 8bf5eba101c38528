"""Playback of the program: nozzle, cone and wave front over time."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from html import escape

from geometry.arrays import Scalars
from programs.errors import ProgramError
from programs.native import render_line
from programs.playback import Timeline, build_timeline
from recipes.load import LoadedRecipe
from rulesengine.planning.pipeline import Run
from specs.progress import no_progress
from webui.cards.findings import recipe_line, source_words
from webui.layers.paths.nozzle import Moment, moment
from webui.layers.paths.strokes import (
    SEEK_STYLE,
    STRIP_PX,
    clock_html,
    cursor_html,
    event_times,
    step_event,
    strip_html,
    tint_functions,
)
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import buttons, dropdown, on_choice
from webui.scene.moving import NozzleView
from webui.scene.scene import Scene
from webui.theme.html import box_html
from webui.theme.page_head import FOOT_STYLE
from webui.theme.palette import PAPER, QUIET, css_colour
from webui.threads.threads import Player, Worker, start_timer

_QUIET_S = 1.0
"""A run is prepared once it was the newest one for so long, so that edits in a row cost nothing here."""
_RATES = ("0.1", "0.2", "0.5", "1", "2", "5", "10", "20", "50")
_WAITING = box_html(
    "<span data-now>The program is not planned yet.</span>", f"font-size:13px;color:{css_colour(QUIET)}"
)
_PLAY, _PAUSE, _BACK, _ON = "Play", "Pause", "Previous event", "Next event"


@dataclass(frozen=True, slots=True, eq=False)
class Playable:
    """A run prepared for the playback."""

    run: Run
    loaded: LoadedRecipe
    timeline: Timeline
    end_s: float
    events: Scalars
    strip: str


def lay_out_run(run: Run, loaded: LoadedRecipe) -> Playable:
    """Prepare a run for the playback.

    Raises:
        ProgramError: there is nothing to play.
    """
    timeline, end_s = build_timeline(run.program), run.program.totals.duration_s
    if end_s <= 0:
        raise ProgramError("the program takes no time; there is nothing to play.")
    strip = strip_html(timeline, end_s, tint_functions(run.recipe))
    return Playable(run, loaded, timeline, end_s, event_times(run.program), strip)


def now_html(playable: Playable, shown: Moment, now_s: float) -> str:
    """Time, function, speed, instruction and recipe line at a time of the program."""
    line = render_line(playable.run.program, shown.instruction).partition(";")[0].rstrip()
    place = f"{source_words(shown.made_by)} {recipe_line(playable.loaded, shown.made_by)}"
    step, sequence = shown.made_by.step, playable.run.recipe.sequence
    side = f" {sequence[step].side}" if step is not None and step < len(sequence) else ""
    function = f"{shown.function}{side}, " if shown.function else ""
    doing = f"{function}{shown.speed_mm_s:.0f} mm/s, jet {'on' if len(shown.rim) else 'off'}"
    cut = "flex:1 1 0;min-width:0;overflow:hidden;text-overflow:ellipsis;text-align:right"
    return box_html(
        f'<div data-now title="{escape(line)}" style="display:flex;gap:18px;white-space:nowrap">'
        f"<span>{clock_html(now_s, playable.end_s)}</span><span>{escape(doing)}</span>"
        f'<span style="{cut};color:{css_colour(QUIET)}">{escape(place)}</span></div>',
        "font-size:13px;line-height:1.5;margin:0 12px",
    )


class PlaybackPanel:
    """Playback of the program: nozzle, cone and wave front over time."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._playable: Playable | None = None
        """The newest run, as soon as it is prepared."""
        self._newest: Session | None = None
        """Session of the newest run."""
        self._begun: Session | None = None
        """Session of the run that is being prepared, or was last."""
        self._pending: Callable[[], None] | None = None
        """Action as soon as it is prepared."""
        self._lock = threading.RLock()
        self._quiet = threading.Timer(_QUIET_S, self._lay_out)
        self._tool = NozzleView(page.client.scene, {})
        gui = page.client.gui
        gui.add_html(FOOT_STYLE)
        self._now = gui.add_html(_WAITING)
        self._strip = gui.add_html("")
        self._cursor = gui.add_html("")
        gui.add_html(SEEK_STYLE)
        self._slider = gui.add_slider("Time (s)", min=0.0, max=1.0, step=0.1, initial_value=0.0, disabled=True)
        self._buttons = buttons(gui, "Go", (_BACK, _PLAY, _ON), self._press)
        self._player = Player(self._draw)
        self._player.rate = 5.0

        def run_at(rate: str) -> None:
            self._player.rate = float(rate)

        dropdown(gui, "Speed (x)", _RATES, "How many times faster than the robot.", run_at, initial_value="5")
        self._worker: Worker[Playable] = Worker(no_progress)
        for close in (self._worker.close, self._player.pause, lambda: self._quiet.cancel()):
            page.on_close(close)
        on_choice(self._slider, self._seek)
        scene.seek = self._seek
        page.follow(self._show, lambda now: (now.timed, now.check))

    def _show(self, session: Session) -> None:
        """Take a new run; it is prepared when it is to be played, or nothing changes for a while."""
        self._player.pause()
        if session.timed is None:
            self._forget()
            return
        with self._lock:
            self._worker.cancel()
            self._playable, self._newest, self._pending = None, replace(session, run=session.played), None
            self._quiet.cancel()
            self._quiet = start_timer(_QUIET_S, self._lay_out)
        self._cursor.content = veil_html() if self._strip.content else ""
        self._name_button()

    def _lay_out(self) -> None:
        """Prepare the newest run in the background."""
        with self._lock:
            self._quiet.cancel()
            session = self._newest
            if session is None or session.run is None or session is self._begun:
                return
            self._begun, run, loaded = session, session.run, session.loaded

            def fail(error: Exception) -> None:
                self._forget()
                self._page.refuse(str(error))

            self._worker.start(lambda _progress: lay_out_run(run, loaded), self._take, fail)

    def _take(self, playable: Playable) -> None:
        with self._lock, self._page.client.atomic():
            if self._newest is None or playable.run is not self._newest.run:
                return
            self._playable = playable
            self._tool.recolour(tint_functions(playable.run.recipe))
            self._slider.max = round(playable.end_s, 1)
            self._slider.disabled = False
            self._strip.content = playable.strip
            self._player.load(playable.end_s)
            pending, self._pending = self._pending, None
            if pending is not None:
                pending()
            self._name_button()

    def _when_ready(self, do: Callable[[], None]) -> None:
        """Act on the newest program: now, or as soon as it is prepared, which then begins at once."""
        with self._lock:
            if self._playable is not None:
                do()
                return
            self._pending = do
        self._lay_out()

    def _forget(self) -> None:
        with self._lock:
            self._quiet.cancel()
            self._worker.cancel()
            self._playable = self._newest = self._pending = None
        self._player.load(0.0)
        self._tool.hide()
        self._slider.disabled = True
        self._now.content, self._strip.content, self._cursor.content = _WAITING, "", ""

    def _press(self, button: str) -> None:
        if button == _PAUSE:
            self._player.pause()
            self._name_button()
            return

        def act() -> None:
            if button == _PLAY:
                self._player.play()
            elif self._playable is not None:
                self._player.pause()
                now_s, steps = self._player.now_s, 1 if button == _ON else -1
                self._player.seek(step_event(self._playable.events, now_s, steps))
            self._name_button()

        self._when_ready(act)

    def _seek(self, time_s: float) -> None:
        self._when_ready(lambda: self._player.seek(time_s))

    def _name_button(self) -> None:
        self._buttons.options = (_BACK, _PAUSE if self._player.playing else _PLAY, _ON)

    def _draw(self, now_s: float) -> None:
        playable = self._playable
        if playable is None:
            return
        shown = moment(playable.timeline, playable.run.recipe, playable.run.workpiece, now_s)
        with self._page.client.atomic():
            if now_s > 0.0 or self._player.playing:
                self._tool.show(shown)
            else:  # at rest over the middle of the first view, it would hide a small board
                self._tool.hide()
            self._scene.show_moment(now_s)
            self._now.content = now_html(playable, shown, now_s)
            self._cursor.content = cursor_html(now_s, playable.end_s)
            self._slider.value = round(min(now_s, playable.end_s), 1)
            if now_s >= playable.end_s:
                self._name_button()


def veil_html() -> str:
    """Veil over the strip above, which is that of an older program."""
    return (
        '<div style="position:relative;height:0;margin:0 12px"><div style="position:absolute;left:0;right:0;'
        f'top:-{STRIP_PX}px;height:{STRIP_PX}px;background:{PAPER};opacity:0.72"></div></div>'
    )
