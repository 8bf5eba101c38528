"""Live operation: a running one is offered, its robot moves in the scene, and the browser reads and stops it by itself.

What the page shows of it, and its STOP, go from the browser to the operating process (``webui/theme/live.js``), so that
neither waits for this server. Only the scene is drawn from here: joints are taken in a thread, and every picture has
the time of what it shows, by which the browser knows how old it is.
"""

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from html import escape
from http.client import HTTPConnection
from typing import cast

import numpy as np

from geometry.arrays import Scalars
from robotcell.cell.load import LoadedCell, cell_sha256
from specs.json import Json
from webui.live.live import HOST, Running, look_over, running_in
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import button, dropdown, html, offer
from webui.scene.scene import Scene
from webui.theme.html import box_html, facts_html, quiet_html

WATCH, LEAVE = "Watch", "Stop watching"
_NONE_RUNS = (
    "No operation runs that was begun in the project folder. Begin one there with "
    "washboard operate PROGRAM --cell CELL --live 0"
)
_OTHER_CELL = "The operated cell is another one than the page's, so the robot in the scene stands still: choose {cell}."
_TABLES = '<div data-live-tables=""></div>'
_NOTHING: tuple[str, ...] = ("",)
_EVERY_S, _PATIENCE_S, _LOST_EVERY_S = 0.05, 0.5, 0.5
_known_sha256 = lru_cache(maxsize=4)(cell_sha256)  # of cells by identity: it is compared with every state


class LivePanel:
    """Offers running operations, and shows what one reports; made of marks that the browser fills."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        self._running: tuple[Running, ...] = ()
        gui = page.client.gui
        self._note = gui.add_html("")
        hint = "Those that were begun in the project folder, with --live."
        self._choice = dropdown(gui, "Operation", _NOTHING, hint, visible=False)
        self._watch = button(gui, WATCH, self._press, "Shows joints, node and sensors as they are, with a stop.")
        html(page, lambda now: "" if now.watched is None else _TABLES, lambda now: now.watched)
        self._follower = Follower(page, scene)
        page.on_poll(self._poll)
        page.on_close(self._follower.close)

        def begin(_: Session) -> None:
            self._running = tuple(running_in(page.project.folder))

        page.follow(begin, lambda _: None)
        page.follow(self._follower.show, lambda now: now.watched)
        page.follow(self._draw, lambda now: (now.watched, now.cell))

    def _press(self) -> None:
        if self._page.session.watched is not None:
            self._page.remember(lambda now: replace(now, watched=None))
            return
        self._poll()
        if not self._running:
            self._page.refuse(_NONE_RUNS)
            return
        chosen = next((each for each in self._running if each.described == self._choice.value), self._running[0])
        self._page.remember(lambda now: replace(now, watched=chosen))

    def _poll(self) -> None:
        """Find operations that began or ended; one that ended is left, one that only does not answer is not."""
        before, self._running = self._running, tuple(running_in(self._page.project.folder))
        watched = self._page.session.watched
        for fresh in self._running:
            if fresh not in before and fresh != watched:
                self._page.notify("An operation runs", f"{fresh.described}. The tab Live in mode Robot shows it.")
        if watched is not None and watched not in self._running and (end := self._follower.end):
            self._page.remember(lambda now: replace(now, watched=None))
            self._page.notify("The operation is over", end)
        elif self._running != before:
            with self._page.client.atomic():
                self._draw(self._page.session)

    def _draw(self, session: Session) -> None:
        watched, running = session.watched, self._running
        offer(self._choice, tuple(each.described for each in running) or _NOTHING)
        self._choice.visible = watched is None and len(running) > 1
        self._watch.label = WATCH if watched is None else LEAVE
        self._note.content = note_html(watched, running, session.cell)


def add_live_mark(page: Page, scene: Scene) -> None:
    """Mark a page that watches an operation, where it is always in sight: the browser looks at it from then on.

    The mark is built in the container that is open, and takes no room.
    """
    html(page, lambda now: mark_html(now.watched), lambda now: now.watched)
    stamp = html(page, lambda _: "", lambda now: now.watched)

    def set_stamp(seconds: float) -> None:
        stamp.content = f'<span data-live-scene="{seconds:.3f}" hidden></span>'

    scene.stamp = set_stamp


@dataclass(slots=True)
class _Following:
    """An operation that is followed by a thread."""

    running: Running
    over: threading.Event
    end: str = ""
    """How it ended; empty before."""


class Follower:
    """Moves the robot in the scene as an operation reports it, in a thread, until another one is watched."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Follow nothing yet."""
        self._page, self._scene = page, scene
        self._now: _Following | None = None

    @property
    def end(self) -> str:
        """How the operation ended that is followed; empty before."""
        return "" if self._now is None else self._now.end

    def show(self, session: Session) -> None:
        """Follow what a session watches."""
        self.close()
        self._scene.is_live = session.watched is not None
        if session.watched is not None:
            self._now = following = _Following(session.watched, threading.Event())
            threading.Thread(target=self._follow, args=(following,), name="washboard-live", daemon=True).start()

    def close(self) -> None:
        """Follow nothing more."""
        if self._now is not None:
            self._now.over.set()
        self._now = None

    def _follow(self, following: _Following) -> None:
        connection = HTTPConnection(HOST, following.running.port, timeout=_PATIENCE_S)
        begun = time.monotonic()
        while not following.over.wait(max(_EVERY_S - (time.monotonic() - begun), 0.0)):
            begun = time.monotonic()
            state = look_over(connection, following.running.token)
            if state is None:
                following.over.wait(_LOST_EVERY_S)
                continue
            following.end = end_of(state)
            self._draw(state, following)
        connection.close()

    def _draw(self, state: Mapping[str, Json], following: _Following) -> None:
        cell = self._page.session.cell
        if cell is None or _known_sha256(cell) != following.running.cell_sha256:
            return
        moment = moment_of(state, cell)
        if moment is not None and not following.over.is_set():
            joints, tool, seconds = moment
            with self._page.client.atomic():
                self._scene.show_live(joints, tool, seconds)


def moment_of(state: Mapping[str, Json], cell: LoadedCell) -> tuple[Scalars, int, float] | None:
    """Joints (dof,) in rad or m, number of the tool, and the operation's time, s, at which they were known.

    ``None`` where a state has none for the robot of this cell, as before the first node.
    """
    joints, tool = state.get("joints"), state.get("tool")
    seconds, age_ms = state.get("seconds"), state.get("age_ms")
    stated = cast("Mapping[str, object]", joints) if isinstance(joints, dict) else {}
    robot = cell.cell.robot
    values = [value for value in stated.values() if isinstance(value, int | float)]
    if len(values) != robot.dof or not isinstance(seconds, int | float) or not isinstance(age_ms, int | float):
        return None
    scale = np.array([1e-3 if joint.kind == "prismatic" else np.pi / 180.0 for joint in robot.joints])
    tools = [each.number for each in cell.cell.tools]
    known = tool if isinstance(tool, int) and tool in tools else min(tools, default=0)
    return scale * np.array(values, dtype=np.float64), known, float(seconds) - 1e-3 * float(age_ms)


def end_of(state: Mapping[str, Json]) -> str:
    """How an operation ended, by its last state; empty where it is not over."""
    name, reason = state.get("state"), state.get("reason")
    if name not in ("end", "faulted", "idle"):
        return ""
    why = f": {reason}" if reason else ""
    return f"{name}, after node {state.get('node')} of {state.get('nodes')}{why}."


def mark_html(watched: Running | None) -> str:
    """Mark from which the browser knows what it watches; nothing where it watches nothing."""
    if watched is None:
        return ""
    names = {"of": watched.address, "token": watched.token, "what": watched.described}
    marks = " ".join(f'data-live-{name}="{escape(value)}"' for name, value in names.items())
    return f"<span {marks} hidden></span>"


def note_html(watched: Running | None, running: tuple[Running, ...], cell: LoadedCell | None) -> str:
    """What is watched, or can be."""
    if watched is None:
        return box_html(
            facts_html({"Running": "\n".join(each.described for each in running)}) if running else _NONE_RUNS
        )
    same = cell is not None and cell_sha256(cell) == watched.cell_sha256
    other = "" if same else quiet_html(_OTHER_CELL.format(cell=watched.cell))
    return box_html(facts_html({"Program": watched.program, "Cell": watched.cell, "At": watched.address})) + other
