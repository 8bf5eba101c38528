"""The findings, worst first."""

from reports.tables.wording import SEVERITY_WORDS, tally
from specs.finding import Finding
from specs.source import NO_SOURCE
from webui.cards.finding_list import (
    ALL,
    CLEANING,
    PLANNING,
    ROBOT,
    choose_findings,
    findings_html,
    findings_of,
    judged_of,
    place_of,
)
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import FindingStepper, dropdown, html, offer, show_while
from webui.panels.widgets.remedy import RemedyButton
from webui.scene.scene import Scene
from webui.theme.html import box_html

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
