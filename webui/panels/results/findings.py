"""The findings, worst first."""

import viser

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
from webui.panels.widgets.choices import FindingStepper, offer, on_choice
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
        self._tally = gui.add_html("")
        self._remedy = RemedyButton(page)
        self._source: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Source",
            (ALL, PLANNING, ROBOT, CLEANING),
            visible=False,
            hint="The plan, the check in a cell, or the prediction.",
        )
        self._severity = gui.add_dropdown("Severity", (ALL, *SEVERITY_WORDS.values()), hint="Errors forbid the export.")
        self._rule: viser.GuiDropdownHandle[str] = gui.add_dropdown("Rule", (ALL,), hint="Name of the check.")
        self._steps = FindingStepper(gui, _HINTS, self._go)
        self._list = gui.add_html("")
        for handle in (self._source, self._severity, self._rule):
            on_choice(handle, lambda _: self._list_findings(page.session))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        same = before is not None and session.run is before.run and session.analysis is before.analysis
        if same and before is not None and session.check is before.check:
            return
        self._remedy.show(session)
        findings = findings_of(session)
        self._tally.content = box_html(tally(findings).capitalize(), "font-size:13px")
        self._source.visible = session.analysis is not None or session.check is not None
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
