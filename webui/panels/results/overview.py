"""Status of the job, always in sight; its findings; its downloads."""

import threading
import time
from collections.abc import Callable

from reports.tables.wording import SEVERITY_WORDS, amount, tally
from rulesengine.planning.pipeline import Run
from specs.finding import Finding
from specs.source import NO_SOURCE
from webui.cards.findings import (
    ALL,
    CLEANING,
    PLANNING,
    ROBOT,
    choose_findings,
    findings_html,
    findings_of,
    judged_of,
    place_of,
    status_html,
    totals_words,
)
from webui.downloads.downloads import KINDS, Download, forbidding, make_download
from webui.page.evaluations import Checked
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import (
    AllowedRules,
    FindingStepper,
    button,
    buttons,
    dropdown,
    html,
    offer,
    show_while,
)
from webui.panels.widgets.job import RemedyButton, RunButton
from webui.scene.scene import Scene
from webui.theme.html import box_html, quiet_html
from webui.theme.page_head import STRIP_STYLE

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


_HINTS = ("Zooms in and opens the recipe entry that caused it.", "Through the findings that are listed.")


class FindingsPanel:
    """The findings, worst first."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui
        self._tally = html(
            page, lambda now: box_html(tally(findings_of(now)).capitalize(), "font-size:13px"), _found_in
        )
        RemedyButton(page)

        def choose(_: object) -> None:
            self._list_findings(page.session)

        hint = "The plan, the check in a cell, or the prediction."
        self._source = dropdown(gui, "Source", (ALL, PLANNING, ROBOT, CLEANING), hint, choose, visible=False)
        severities = (ALL, *SEVERITY_WORDS.values())
        self._severity = dropdown(gui, "Severity", severities, "Errors forbid the export.", choose)
        self._rule = dropdown(gui, "Rule", (ALL,), "Name of the check.", choose)
        self._steps = FindingStepper(gui, _HINTS, self._go)
        self._list = gui.add_html("")
        show_while(page, lambda now: now.analysis is not None or now.check is not None, self._source)
        page.follow(self._show, _found_in)

    def _show(self, session: Session) -> None:
        findings = findings_of(session)
        offer(self._rule, (ALL, *dict.fromkeys(finding.rule.id for finding in findings)))
        self._steps.chosen = next((finding for finding in findings if finding == self._steps.chosen), None)
        self._list_findings(session)

    def _list_findings(self, session: Session) -> None:
        source = self._source.value if self._source.visible else ALL
        shown = choose_findings(findings_of(session, source), self._severity.value, self._rule.value)
        with self._page.client.atomic():
            self._list.content = findings_html(shown, session.loaded, self._steps.chosen)
            self._steps.offer_findings(shown)

    def _go(self, finding: Finding | None) -> None:
        """Zoom in on a finding and select its subject; a judged part is shown with all strokes that spray it."""
        session = self._page.session
        self._list_findings(session)
        if finding is None:
            return
        place = session.workpiece.find_place(place_of(finding, session.workpiece))
        if finding.where is not None:
            self._scene.look_at_place(finding.where)
        elif place is not None:
            self._scene.look_at(place)
        name = "" if place is None else place.name
        self._page.select(component=name, made_by=NO_SOURCE if name and judged_of(finding) else finding.made_by)


def _found_in(session: Session) -> object:
    """What of a session has findings."""
    return session.run, session.analysis, session.check


_RATES = ("1", "2", "5", "10", "20", "50")


class OutputPanel:
    """Downloads: program, pictures, reports, a playback that opens without a server, or all of them as a zip."""

    def __init__(self, page: Page, _scene: Scene) -> None:
        """Build the elements in the container that is open."""
        gui = page.client.gui
        html(page, forbidden_html, _blocking_in)

        def choose(kind: str) -> None:
            about.content = quiet_html(KINDS[kind][1])
            rate.visible = kind.startswith("Playback")

        def begin() -> None:
            session, chosen, times, allowed = page.session, kind.value, float(rate.value), rules.rules
            run.start(
                lambda progress: make_download(chosen, session, allowed, times, progress),
                lambda made: page.client.send_file_download(made.name, made.content, save_immediately=True),
            )

        kind = dropdown(gui, "File", KINDS, "What to download.", choose)
        about = gui.add_html(quiet_html(next(iter(KINDS.values()))[1]))
        hint = "How many times faster than the robot."
        rate = dropdown(gui, "Speed (x)", _RATES, hint, initial_value="10", visible=False)
        run: RunButton[Download] = RunButton(page, "Download", begin, "The same bytes as the command line writes.")
        rules = AllowedRules(gui)
        page.follow(lambda now: rules.offer(forbidding(_findings_of(now))), _blocking_in)


def forbidden_html(session: Session) -> str:
    """Rules whose errors forbid the program of a session; nothing where none does."""
    rules = forbidding(_findings_of(session))
    violated = ", ".join(f"{rule} ({count})" for rule, count in rules.items())
    errors = amount(sum(rules.values()), "error").capitalize()
    of_plan = session.run is not None and forbidding(session.run.findings)
    whose = "the program" if of_plan else "the robot's program"
    hint = "Correct them, or tick the rule below to write the program in spite of it."
    return box_html(f"{errors} forbid {whose}: {violated}. {hint}") if rules else ""


def _findings_of(session: Session) -> tuple[Finding, ...]:
    """Findings of the plan, then of the check."""
    return tuple(each for found in _blocking_in(session) if found is not None for each in found.findings)


def _blocking_in(session: Session) -> tuple[Run | None, Checked | None]:
    return session.run, session.check
