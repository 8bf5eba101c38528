"""Fix this: single changes for the selected part, each with its predicted effect, each one edit."""

from dataclasses import dataclass
from functools import partial

import viser

from cleaning.verdicts.results import Part
from specs.progress import Progress
from webui.cards.boxes import quiet_html
from webui.page.analysed import Analysed
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.job import RunButton
from webui.tuning.proposal_html import fix_html
from webui.tuning.quick_fix import Fix, apply_fix

SUGGEST, CANCEL, APPLY = "Suggest changes", "Cancel suggesting", "Apply this change"
_MOST = 3
_NOTE = "Tries single changes of the recipe, each with an analysis of its own."
_NOTHING = "No single change was found that helps this part. Tune changes several."


@dataclass(frozen=True, slots=True)
class _Slot:
    """Where one suggestion stands."""

    text: viser.GuiHtmlHandle
    button: viser.GuiButtonHandle


class FixCard:
    """Fix this: single changes for the selected part, each with its predicted effect."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; visible where the selected part is not clean."""
        self._page = page
        self._found: dict[str, tuple[Fix, ...]] = {}
        """By part; of the analysis that is shown."""
        gui = page.client.gui
        self._folder = gui.add_folder("Fix this", visible=False)
        with self._folder:
            self._run: RunButton[tuple[Fix, ...]] = RunButton(page, SUGGEST, self._begin, _NOTE, CANCEL)
            self._slots = tuple(self._add_slot(number) for number in range(_MOST))

    def _add_slot(self, number: int) -> _Slot:
        gui = self._page.client.gui
        slot = _Slot(gui.add_html("", visible=False), gui.add_button(APPLY, visible=False))
        slot.button.on_click(lambda _: self._apply(number))
        return slot

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        same = before is not None and session.analysis is before.analysis
        if same and before is not None and session.selection.component == before.selection.component:
            return
        if not same:
            self._found = {}
        self._run.stop()
        part = failing_part(session)
        self._folder.visible = part is not None
        self._show_found(part)

    def _show_found(self, part: Part | None) -> None:
        found = None if part is None else self._found.get(part.component)
        self._run.show(quiet_html(_NOTE if found is None else _note(found)))
        fixes = found or ()
        for number, slot in enumerate(self._slots):
            there = number < len(fixes)
            slot.text.visible = slot.button.visible = there
            slot.text.content = fix_html(fixes[number]) if there else ""

    def _begin(self) -> None:
        session, project = self._page.session, self._page.project
        part = failing_part(session)
        run, analysis, component = session.run, session.analysis, "" if part is None else part.component
        if run is None or analysis is None or not component:
            return

        def work(progress: Progress) -> tuple[Fix, ...]:
            from webui.tuning.suggestions import Failing, suggest_fixes

            parameters = project.open_parameters(analysis.parameters_name)
            return suggest_fixes(Failing(component, session.document, run, parameters, analysis), progress)

        self._run.start(work, partial(self._take, component, analysis))

    def _take(self, component: str, of: Analysed, found: tuple[Fix, ...]) -> None:
        session = self._page.session
        if session.analysis is of:
            self._found[component] = found
        with self._page.client.atomic():
            self._show_found(failing_part(session))

    def _apply(self, number: int) -> None:
        part = failing_part(self._page.session)
        fixes = self._found.get(part.component, ()) if part is not None else ()
        if number < len(fixes) and self._page.attempt(apply_fix(fixes[number])):
            self._page.say("Changed", f"{fixes[number].what}. Analyse again to see its effect; Undo takes it back.")


def failing_part(session: Session) -> Part | None:
    """The selected part, or the bare board where none is selected, if it is not clean."""
    if session.analysis is None:
        return None
    report = session.analysis.report
    part = next((each for each in report.parts if each.component == session.selection.component), report.bare)
    return part if any(each.verdict in ("dirty", "marginal") for each in part.judgements) else None


def _note(found: tuple[Fix, ...]) -> str:
    return "Tested one at a time, best first." if found else _NOTHING
