"""What an engineer should look at, worst first."""

import viser

from geometry.finding import Finding
from rulesengine.comparison import SEVERITY_WORDS
from webui.around import step_around
from webui.choices import offer
from webui.finding_list import (
    ALL,
    CLEANING,
    PLANNING,
    choose_findings,
    component_of,
    findings_html,
    findings_of,
    judged_of,
    name_findings,
    tally,
)
from webui.page import Page
from webui.palette import INK, to_hex
from webui.scene import Scene
from webui.session import Session

_NONE: str = "none"
_BACK, _ON = "Previous", "Next"
_MOST_NAMED = 500
"""Findings to choose from by name; the buttons go through all."""


class FindingsPanel:
    """What an engineer should look at, worst first."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._names: dict[str, Finding] = {}
        self._chosen: Finding | None = None
        gui = page.client.gui
        self._tally = gui.add_html("")
        self._source: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Source", (ALL, PLANNING, CLEANING), visible=False, hint="Of the plan, or of what it is predicted to clean."
        )
        self._severity = gui.add_dropdown("Severity", (ALL, *SEVERITY_WORDS.values()), hint="Errors forbid the export.")
        self._rule: viser.GuiDropdownHandle[str] = gui.add_dropdown("Rule", (ALL,), hint="Name of the check.")
        self._choice: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Go to", (_NONE,), hint="Flies there, and opens what asked for it in the recipe."
        )
        self._steps = gui.add_button_group("Step", (_BACK, _ON), hint="Through the findings that are listed.")
        self._list = gui.add_html("")
        for filtering in (self._source, self._severity, self._rule):
            filtering.on_update(lambda event: self._filter(by_hand=event.client is not None))
        self._choice.on_update(lambda event: self._go(event.target.value, by_hand=event.client is not None))
        self._steps.on_click(lambda event: self._step(event.target.value))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is not None and session.run is before.run and session.analysis is before.analysis:
            return
        findings = findings_of(session)
        self._tally.content = f'<div style="{_TALLY}">{tally(findings).capitalize()}</div>'
        self._source.visible = session.analysis is not None
        rules = (ALL, *dict.fromkeys(finding.rule for finding in findings))
        if tuple(self._rule.options) != rules:
            self._rule.options = rules
        self._chosen = next((finding for finding in findings if finding == self._chosen), None)
        self._list_findings(session)

    def _list_findings(self, session: Session) -> None:
        source = self._source.value if self._source.visible else ALL
        shown = choose_findings(findings_of(session, source), self._severity.value, self._rule.value)
        self._names = name_findings(shown)
        self._list.content = findings_html(shown, session.loaded, self._chosen)
        options = (_NONE, *list(self._names)[:_MOST_NAMED])
        offer(self._choice, options, self._name if self._name in options else _NONE)

    @property
    def _name(self) -> str:
        return next((name for name, each in self._names.items() if each is self._chosen), _NONE)

    def _filter(self, *, by_hand: bool) -> None:
        if by_hand:
            with self._page.client.atomic():
                self._list_findings(self._page.session)

    def _step(self, button: str) -> None:
        if self._names:
            self._go(step_around(list(self._names), self._name, 1 if button == _ON else -1), by_hand=True)

    def _go(self, name: str, *, by_hand: bool) -> None:
        """Fly to where a finding is and select what it is about."""
        if not by_hand:
            return
        session = self._page.session
        self._chosen = self._names.get(name)
        with self._page.client.atomic():
            self._list_findings(session)
            if self._chosen is not None:
                self._look_at(self._chosen, session)

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
