"""What is planned, how far planning is, and what comes out: always in sight."""

import threading
import time
from collections import Counter
from html import escape

from reports.tables.wording import amount, clock
from rulesengine.planning.pipeline import Run
from webui.page.page import Page
from webui.page.session import Session
from webui.scene.scene import Scene
from webui.theme.palette import ACCENT, INK, QUIET, to_hex

_CANCEL, _PLAN = "Cancel", "Plan"
_PATIENCE_S = 0.5
"""A plan that is quicker than this offers no button: it would only flicker."""
_PACE_S = 0.1
"""What lasts no longer is not mentioned, and how far the same work is not said more often."""
_STOPPED = ("cancelled", "not planned")
_SEVERITIES = ("error", "warning")


class StatusPanel:
    """What is planned, how far planning is, and what comes out: always in sight."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._what, self._share = "", 0.0
        self._begun_s, self._told_s = 0.0, 0.0
        gui = page.client.gui
        self._html = gui.add_html("")
        self._button = gui.add_button(_CANCEL, visible=False, color="gray", hint="Give up planning, or plan again.")
        self._button.on_click(lambda _: self._press())
        self._patience = self._new_patience()
        page.on_progress(self._show_progress)
        page.on_close(lambda: self._patience.cancel())

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        self._html.content = status_html(session, self._page.planned_s, self._what, self._share)
        stopped = self._what in _STOPPED
        self._button.label = _PLAN if stopped else _CANCEL
        if session.planned or stopped:
            self._button.visible = stopped and not session.planned

    def _show_progress(self, what: str, done: float) -> None:
        begins, same, now_s = what == "planning" and done == 0.0, what == self._what, time.monotonic()
        self._what, self._share = what, done
        if begins:
            self._begun_s = now_s
            self._patience.cancel()
            self._patience = self._new_patience()
            self._patience.start()
        since_s = now_s - (self._told_s if same else self._begun_s)
        # When it is done the run itself is about to be shown.
        if begins or what in _STOPPED or (what != "done" and since_s > _PACE_S):
            self._told_s = now_s
            with self._page.client.atomic():
                self.show(self._page.session, None)

    def _new_patience(self) -> threading.Timer:
        timer = threading.Timer(_PATIENCE_S, self._offer_to_cancel)
        timer.daemon = True
        return timer

    def _offer_to_cancel(self) -> None:
        if not self._page.session.planned:
            self._button.visible = True

    def _press(self) -> None:
        if self._button.label == _CANCEL:
            self._page.cancel()
        else:
            self._page.plan()


def status_html(session: Session, planned_s: float | None, what: str, share: float) -> str:
    """Say how long the program takes, what it needs, and whether it is that of the recipe as it is now."""
    run = session.run
    rows = [_head(session), _totals(run) if run is not None else ""]
    if session.planned:
        took = f"Planned in {planned_s:.2f} s." if planned_s is not None else "Planned."
        rows += [_line(f"{took} {_findings(run)}" if run is not None else took), _bar(None)]
    elif what in _STOPPED:
        older = " The paths are those of the recipe before." if run is not None else ""
        rows += [_line(f"{what.capitalize()}.{older}", ACCENT), _bar(None)]
    elif session.sketch is not None:
        rows += [_line(f"Refining the order\N{HORIZONTAL ELLIPSIS} {share:.0%}", mark="data-sketch"), _bar(share)]
    else:
        rows += [_line(f"{what.capitalize() or 'Planning'}\N{HORIZONTAL ELLIPSIS} {share:.0%}"), _bar(share)]
    return f'<div style="margin:2px 12px 6px;color:{to_hex(INK)};font-size:13px;line-height:1.5">{"".join(rows)}</div>'


def litres_of(run: Run) -> float:
    """Add up the liquid of all functions, l."""
    return sum(litres for _, litres in run.program.totals.liquid_l)


def _head(session: Session) -> str:
    star = " \N{BULLET}" if session.document.dirty else ""
    names = f"{session.board.name} \N{MULTIPLICATION SIGN} {session.document.file.stem}{star}"
    return f'<div style="white-space:nowrap;overflow:hidden;text-overflow:ellipsis">{escape(names)}</div>'


def _totals(run: Run) -> str:
    return (
        '<div style="display:flex;justify-content:space-between;align-items:baseline;'
        'font-variant-numeric:tabular-nums">'
        f'<span data-total style="font-size:22px;font-weight:600">{clock(run.program.totals.duration_s)}</span>'
        f'<span style="font-size:15px">{litres_of(run):.1f} l</span></div>'
    )


def _findings(run: Run) -> str:
    counts = Counter(finding.severity for finding in run.findings)
    told = [amount(counts[severity], severity) for severity in _SEVERITIES if counts[severity]]
    return f"{', '.join(told).capitalize()}." if told else "No errors or warnings."


def _line(text: str, colour: tuple[int, int, int] = QUIET, mark: str = "data-progress") -> str:
    return f'<div {mark} style="font-size:12px;color:{to_hex(colour)}">{escape(text)}</div>'


def _bar(share: float | None) -> str:
    """A thin bar; its room stays when there is nothing to wait for, so that nothing jumps."""
    ground = "transparent" if share is None else "#e6eaed"
    width = 0.0 if share is None else 100 * min(max(share, 0.03), 1.0)
    return (
        f'<div style="height:3px;border-radius:2px;margin-top:4px;background:{ground}">'
        f'<div style="height:3px;border-radius:2px;width:{width:.0f}%;background:{to_hex(ACCENT)}"></div></div>'
    )
