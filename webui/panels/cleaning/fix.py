"""Fix this: single changes for the selected part, each with its predicted effect, each one edit."""

from cleaning.verdicts.results import Part
from specs.progress import Progress
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.job import RunButton
from webui.theme.html import quiet_html
from webui.tuning.accept import Fix, apply_fix
from webui.tuning.proposal_html import fix_html

SUGGEST, CANCEL, APPLY = "Suggest changes", "Cancel suggesting", "Apply this change"
_MOST = 3
_NOTE = "Tries single changes of the recipe, each with an analysis of its own."
_NOTHING = "No single change was found that helps this part. Tune changes several."
_TRIED = "Tested one at a time, best first."


class FixCard:
    """Fix this: single changes for the selected part, each with its predicted effect."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; they are visible where the selected part is not clean."""
        self._page = page
        self._found: dict[str, tuple[Fix, ...]] = {}
        """By part; of the analysis that is shown."""
        gui = page.client.gui
        self._folder = gui.add_folder("Fix this", visible=False)
        with self._folder:
            self._run: RunButton[tuple[Fix, ...]] = RunButton(page, SUGGEST, self._begin, _NOTE, CANCEL)
            self._slots = [
                (gui.add_html("", visible=False), gui.add_button(APPLY, visible=False)) for _ in range(_MOST)
            ]
        for number, (_, button) in enumerate(self._slots):
            button.on_click(lambda _, number=number: self._apply(number))

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
        self._run.show(quiet_html(_NOTE if found is None else _TRIED if found else _NOTHING))
        for (text, button), fix in zip(self._slots, [*(found or ())[:_MOST], *[None] * _MOST], strict=False):
            text.visible = button.visible = fix is not None
            text.content = fix_html(fix) if fix is not None else ""

    def _begin(self) -> None:
        session, project = self._page.session, self._page.project
        part, run, analysis = failing_part(session), session.run, session.analysis
        if run is None or analysis is None or part is None:
            return
        component = part.component

        def work(progress: Progress) -> tuple[Fix, ...]:
            from webui.tuning.background import Failing, suggest_fixes

            parameters = project.open_parameters(analysis.parameters_name)
            return suggest_fixes(Failing(component, session.document, run, parameters, analysis), progress)

        def take(found: tuple[Fix, ...]) -> None:
            now = self._page.session
            if now.analysis is analysis:
                self._found[component] = found
            with self._page.client.atomic():
                self._show_found(failing_part(now))

        self._run.start(work, take)

    def _apply(self, number: int) -> None:
        part = failing_part(self._page.session)
        fixes = self._found.get(part.component, ()) if part is not None else ()
        if number < len(fixes) and self._page.attempt(apply_fix(fixes[number])):
            what = f"{fixes[number].what}. Analyse again to see the effect; Undo takes it back."
            self._page.notify("Changed", what)


def failing_part(session: Session) -> Part | None:
    """The selected part, or the bare board where none is selected, if it is not clean."""
    if session.analysis is None:
        return None
    part = session.analysis.part(session.selection.component) or session.analysis.report.bare
    return part if any(each.verdict in ("dirty", "marginal") for each in part.judgements) else None
