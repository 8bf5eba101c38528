"""What an engineer should look at, worst first."""

import viser

from reports.tables.comparison import SEVERITY_WORDS
from specs.finding import Finding
from webui.cards.finding_list import (
    ALL,
    CLEANING,
    PLANNING,
    choose_findings,
    component_of,
    findings_html,
    findings_of,
    judged_of,
    tally,
)
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.finding_steps import FindingSteps
from webui.scene.scene import Scene
from webui.theme.palette import INK, to_hex

_HINTS = ("Flies there, and opens what asked for it in the recipe.", "Through the findings that are listed.")


class FindingsPanel:
    """What an engineer should look at, worst first."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui
        self._tally = gui.add_html("")
        self._source: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Source", (ALL, PLANNING, CLEANING), visible=False, hint="Of the plan, or of what it is predicted to clean."
        )
        self._severity = gui.add_dropdown("Severity", (ALL, *SEVERITY_WORDS.values()), hint="Errors forbid the export.")
        self._rule: viser.GuiDropdownHandle[str] = gui.add_dropdown("Rule", (ALL,), hint="Name of the check.")
        self._steps = FindingSteps(gui, _HINTS, self._go)
        self._list = gui.add_html("")
        for filtering in (self._source, self._severity, self._rule):
            filtering.on_update(lambda event: self._filter(by_hand=event.client is not None))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is not None and session.run is before.run and session.analysis is before.analysis:
            return
        findings = findings_of(session)
        self._tally.content = f'<div style="{_TALLY}">{tally(findings).capitalize()}</div>'
        self._source.visible = session.analysis is not None
        rules = (ALL, *dict.fromkeys(finding.rule.id for finding in findings))
        if tuple(self._rule.options) != rules:
            self._rule.options = rules
        self._steps.chosen = next((finding for finding in findings if finding == self._steps.chosen), None)
        self._list_findings(session)

    def _list_findings(self, session: Session) -> None:
        source = self._source.value if self._source.visible else ALL
        shown = choose_findings(findings_of(session, source), self._severity.value, self._rule.value)
        self._list.content = findings_html(shown, session.loaded, self._steps.chosen)
        self._steps.offer(shown)

    def _filter(self, *, by_hand: bool) -> None:
        if by_hand:
            with self._page.client.atomic():
                self._list_findings(self._page.session)

    def _go(self, finding: Finding | None) -> None:
        """Fly to where a finding is and select what it is about."""
        session = self._page.session
        with self._page.client.atomic():
            self._list_findings(session)
            if finding is not None:
                self._look_at(finding, session)

    def _look_at(self, finding: Finding, session: Session) -> None:
        component = component_of(finding, session.board)
        if finding.where is not None:
            self._scene.look_at_place(finding.where)
        elif component:
            part = next(each for each in session.board.components if each.name == component)
            self._scene.look_at(part, session.board)
        # A part that is judged is shown with all strokes that spray it.
        judged = component if judged_of(finding) else ""
        self._page.select(component=component, made_by="" if judged else finding.made_by)


_TALLY = f"margin:0 12px;font-size:13px;color:{to_hex(INK)}"
