"""State and progress of planning, and totals of the program: always in sight."""

import threading
import time
from collections import Counter
from html import escape

from reports.tables.wording import amount, clock
from webui.page.page import Page
from webui.page.session import Session
from webui.scene.scene import Scene
from webui.theme.html import bar_html, box_html
from webui.theme.palette import ACCENT, QUIET, Tint, to_hex

_CANCEL, _PLAN = "Cancel", "Plan"
_PATIENCE_S = 0.5
"""A plan that is quicker than this shows no button: it would only flicker."""
_PACE_S = 0.1
"""Shorter work is not shown, and progress not updated more often."""
_STOPPED = ("cancelled", "not planned")
_SEVERITIES = ("error", "warning")


class StatusPanel:
    """State and progress of planning, and totals of the program: always in sight."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._what, self._share = "", 0.0
        self._begun_s, self._shown_s = 0.0, 0.0
        gui = page.client.gui
        self._html = gui.add_html("")
        self._button = gui.add_button(_CANCEL, visible=False, color="gray", hint="Give up planning, or plan again.")
        self._button.on_click(lambda _: page.cancel() if self._button.label == _CANCEL else page.plan())
        self._patience = self._new_patience()
        page.on_progress(self._show_progress)
        page.on_close(lambda: self._patience.cancel())

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        self._html.content = status_html(session, self._page.planned_s, self._what, self._share)
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
                self.show(self._page.session, None)

    def _new_patience(self) -> threading.Timer:
        """Timer after which planning can be cancelled."""

        def offer() -> None:
            if not self._page.session.planned and self._page.session.shown is None:
                self._button.visible = True

        timer = threading.Timer(_PATIENCE_S, offer)
        timer.daemon = True
        return timer


def status_html(session: Session, planned_s: float | None, what: str, share: float) -> str:
    """Duration and liquid of the program, and whether it is of the recipe as it is now."""
    run, shown = session.timed, session.shown
    star = " \N{BULLET}" if session.document.dirty else ""
    names = f"{session.board.name} \N{MULTIPLICATION SIGN} {session.document.file.stem}{star}"
    if shown is not None:
        names = f"{session.board.name} \N{MULTIPLICATION SIGN} {shown.name}"
    rows = [f'<div style="white-space:nowrap;overflow:hidden;text-overflow:ellipsis">{escape(names)}</div>']
    if run is not None:
        litres = sum(litres for _, litres in run.program.totals.liquid_l)
        rows.append(
            '<div style="display:flex;justify-content:space-between;align-items:baseline;'
            'font-variant-numeric:tabular-nums">'
            f'<span data-total style="font-size:22px;font-weight:600">{clock(run.program.totals.duration_s)}</span>'
            f'<span style="font-size:15px">{f"{litres:.1f} l" if shown is None else ""}</span></div>'
        )
    if shown is not None:
        rows.append(_line(f"Read from {shown.language}. Nothing can be edited."))
    elif run is not None and session.planned:
        took = f"Planned in {planned_s:.2f} s." if planned_s is not None else "Planned."
        counts = Counter(finding.severity for finding in run.findings)
        found = ", ".join(amount(counts[severity], severity) for severity in _SEVERITIES if counts[severity])
        rows += [_line(f"{took} {found.capitalize() or 'No errors or warnings'}."), bar_html(None)]
    elif what in _STOPPED:
        older = " The paths are those of the recipe before." if run is not None else ""
        rows += [_line(f"{what.capitalize()}.{older}", ACCENT), bar_html(None)]
    elif session.sketch is not None:
        rows += [_line(f"Refining the order\N{HORIZONTAL ELLIPSIS} {share:.0%}", mark="data-sketch"), bar_html(share)]
    else:
        rows += [_line(f"{what.capitalize() or 'Planning'}\N{HORIZONTAL ELLIPSIS} {share:.0%}"), bar_html(share)]
    return box_html("".join(rows), "font-size:13px;line-height:1.5")


def _line(text: str, colour: Tint = QUIET, mark: str = "data-progress") -> str:
    return f'<div {mark} style="font-size:12px;color:{to_hex(colour)}">{escape(text)}</div>'
