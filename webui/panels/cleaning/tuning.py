"""Tuning the recipe: the job in the background, its window, and the decision on its proposal."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import viser

from rulesengine.tuning.variables import ChangeKind
from specs.progress import Progress
from webui.forms.spec_form import reason_of
from webui.page.evaluations import GOALS, KIND_WORDS, Proposal, TuningError, TuningSettings
from webui.page.page import Page
from webui.page.session import Change, Session
from webui.panels.widgets.choices import button, dropdown, offer, show_while
from webui.panels.widgets.job import Job
from webui.theme.html import progress_html, quiet_html, remark_html
from webui.theme.palette import QUIET
from webui.tuning.proposal_html import (
    apply_proposal,
    changes_html,
    diff_html,
    front_html,
    front_labels,
    headline_of,
    reasons_html,
    save_proposal,
    totals_html,
)

CHOOSE = "Choose from the Pareto front"
_NOTHING: tuple[str, ...] = ("",)
START, CANCEL, APPLY, SAVE, DISCARD, CLOSE = (
    "Start", "Cancel tuning", "Apply these changes", "Save as a new recipe", "Discard", "Close",
)  # fmt: skip
_MARK = "washboard-tuning"
_STYLE = f"""<style>
.mantine-Modal-content:has(.{_MARK}) {{ flex: 0 0 min(820px, 94vw) !important; max-height: 94vh !important; }}
</style><div class="{_MARK}"></div>"""
"""Recipes are wider than the usual window."""

_NOTE = (
    "Changes what is ticked until all that can be cleaned is predicted clean, then shortens the recipe. "
    "The recipe stays as it is until you apply that."
)

Actions = Mapping[str, Callable[[], None]]
"""Actions by the label of their button."""


class TuningWindow:
    """Window of tuning: it shows one of its three parts at a time."""

    def __init__(self, page: Page, settings: TuningSettings, actions: Actions) -> None:
        """Open it with settings filled in."""
        self._gui, self._actions, self._has_cell = page.client.gui, actions, page.session.cell is not None
        self._window = self._gui.add_modal("Tune the recipe")
        with self._window:
            self._form = self._gui.add_folder(None)
            with self._form:
                self._gui.add_html(quiet_html(_NOTE))
                self._add_inputs(settings)
                self._remark = self._gui.add_html("")
                self._add_button(START)
            self._working = self._gui.add_html("", visible=False)
            self._proposing = self._gui.add_folder(None, visible=False)
            with self._proposing:
                self._gui.add_html(_STYLE)
                self._proposal = self._gui.add_html("")
                self._texts: dict[str, str] = {}
                hint = "Another recipe that was analysed: quicker, or with more margin."
                self._front = dropdown(self._gui, CHOOSE, _NOTHING, hint, lambda _: self._actions[CHOOSE]())
                self._rest = self._gui.add_html("")
                self._name = self._gui.add_text("New recipe", "", hint="A file in the project folder.")
                self._refusal = self._gui.add_html("")
                self._takes = tuple(self._add_button(label) for label in (APPLY, SAVE, DISCARD))
            self._cancel = self._add_button(CANCEL)
            self._cancel.visible = False
            self._add_button(CLOSE)

    def _add_inputs(self, settings: TuningSettings) -> None:
        gui, hint = self._gui, "Of the program; 0 is no limit."
        self._kinds: dict[ChangeKind, viser.GuiCheckboxHandle] = {
            kind: gui.add_checkbox(label, kind in settings.kinds, hint=hint)
            for kind, (label, hint) in KIND_WORDS.items()
        }
        goal = next(label for label, goal in GOALS.items() if goal == settings.goal)
        goals = "Whether water left under parts counts too."
        self._goal = dropdown(gui, "For", GOALS, goals, initial_value=goal)
        self._seconds = gui.add_number("Time at most (s), 0: any", settings.seconds, min=0.0, hint=hint)
        self._litres = gui.add_number("Liquid at most (l), 0: any", settings.litres, min=0.0, hint=hint)
        hint = "Share of time and liquid: tuning ends where no change is expected to save more."
        self._saving = gui.add_number("Worth an analysis (%)", settings.saving, min=0.0, max=99.0, hint=hint)
        hint = "More of them find a better recipe."
        self._analyses = gui.add_number("Analyses at most", settings.analyses, min=2.0, step=1.0, hint=hint)
        hint = "Times are those that the robot of the cell takes; what it cannot do is left out. Takes longer."
        ticked = settings.for_robot and self._has_cell
        self._for_robot = gui.add_checkbox("For this robot", ticked, visible=self._has_cell, hint=hint)

    def _add_button(self, label: str) -> viser.GuiButtonHandle:
        return button(
            self._gui, label, lambda: self._actions[label](), color=None if label in (START, APPLY) else QUIET
        )

    def settings(self) -> TuningSettings:
        """Settings that are filled in."""
        ticked = frozenset[ChangeKind](kind for kind, box in self._kinds.items() if box.value)
        limits = self._seconds.value, self._litres.value, self._analyses.value, self._saving.value
        return TuningSettings(ticked, GOALS[self._goal.value], *limits, for_robot=self._for_robot.value)

    @property
    def name(self) -> str:
        """Name for a new recipe."""
        return self._name.value.strip()

    def show_form(self, remark: str = "") -> None:
        """Show the inputs, and why tuning did not begin or failed."""
        self._remark.content = remark_html(remark)
        self._show(self._form)

    def show_progress(self, what: str, done: float) -> None:
        """Show the progress."""
        self._working.content = progress_html(what, done)
        self._show(self._working)

    def propose(self, proposal: Proposal) -> None:
        """Show a proposal."""
        tuned = proposal.tuned
        self._proposal.content = totals_html(proposal) + front_html(proposal)
        self._texts = front_labels(tuned)
        own = next((label for label, text in self._texts.items() if text == proposal.text), None)
        if own is None:  # what tuning found may be beaten by a recipe that its limits or verdicts forbid
            own = "as tuned"
            self._texts = {own: tuned.last.text} | self._texts
        offer(self._front, tuple(self._texts), own)
        self._rest.content = (
            ("" if proposal.chosen else changes_html(tuned.changes))
            + diff_html(proposal.document.text, proposal.text)
            + ("" if proposal.chosen or proposal.interrupted else reasons_html(tuned))
        )
        self._name.value = f"{proposal.document.file.stem}-tuned.yaml"
        self._refusal.content = ""
        for take in self._takes[:2]:
            take.visible = proposal.changes
        self._name.visible = proposal.changes
        self._show(self._proposing)

    @property
    def chosen(self) -> str:
        """Text of the recipe that is chosen of the Pareto front; empty where none is shown."""
        return self._texts.get(self._front.value, "")

    def refuse(self, reason: str) -> None:
        """Show why the proposal was not applied."""
        self._refusal.content = remark_html(reason)

    def _show(self, part: viser.GuiFolderHandle | viser.GuiHtmlHandle) -> None:
        for each in (self._form, self._working, self._proposing):
            each.visible = each is part
        self._cancel.visible = part is self._working

    def close(self) -> None:
        """Close it; what is under way goes on."""
        if not self._window.closed:
            self._window.close()


class TuneCard:
    """Tuning the recipe: the button that opens its window, the job in the background, and the decision."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        self._settings = TuningSettings()
        self._window: TuningWindow | None = None
        self._best: Proposal | None = None
        """Of the tuning that is under way."""
        hint = "Changes the recipe until all that it can clean is predicted clean."
        tune = button(page.client.gui, "Tune\N{HORIZONTAL ELLIPSIS}", self._open, hint)

        def show_progress(what: str, done: float) -> None:
            if self._window is not None:
                self._window.show_progress(what, done)

        def leave(_: Session) -> None:
            if self._job.running:
                self._cancel()

        self._job: Job[Proposal] = Job(page, show_progress)
        show_while(page, lambda now: now.board is not None, tune)
        page.follow(leave, lambda now: now.workpiece)
        page.follow(lambda now: self._job.show(state_html(now)), lambda now: (now.proposal, now.document))

    def _open(self) -> None:
        def discard() -> None:
            self._page.remember(lambda session: replace(session, proposal=None))
            window.show_form()

        def choose() -> None:
            proposal, text = self._page.session.proposal, window.chosen
            if proposal is not None and text and text != proposal.text:
                chosen = replace(proposal, chosen="" if text == proposal.tuned.last.text else text)
                self._page.remember(lambda session: replace(session, proposal=chosen))
                with self._page.client.atomic():
                    window.propose(chosen)

        def accept(change: Change) -> None:
            if self._page.attempt(change, lambda error: window.refuse(reason_of(error))):
                self._close()

        self._close()
        actions: Actions = {
            START: lambda: self._start(window),
            CANCEL: self._cancel,
            APPLY: lambda: accept(apply_proposal),
            SAVE: lambda: accept(save_proposal(self._page.project, window.name)),
            DISCARD: discard,
            CLOSE: self._close,
            CHOOSE: choose,
        }
        checked = self._page.session.check is not None
        settings = replace(self._settings, for_robot=self._settings.for_robot or checked)
        self._window = window = TuningWindow(self._page, settings, actions)
        proposal = self._page.session.proposal
        if self._job.running:
            window.show_progress("tuning", 0.0)
        elif proposal is not None:
            window.propose(proposal)

    def _close(self) -> None:
        window, self._window = self._window, None
        if window is not None:
            window.close()

    def _start(self, window: TuningWindow) -> None:
        """Begin with the recipe as it is edited now; it need not be planned."""
        self._settings = window.settings()
        try:
            request = self._settings.request()
        except TuningError as error:
            window.show_form(str(error))
            return
        session, project, board = self._page.session, self._page.project, self._page.session.board
        if board is None:  # pressed before the browser heard of the part
            return
        name, cell = session.parameters_name, session.cell if self._settings.for_robot else None

        def note_best(proposal: Proposal) -> None:
            self._best = proposal

        def work(progress: Progress) -> Proposal:
            from webui.tuning.background import Task, propose

            parameters, folder = project.open_parameters(name), project.folder
            task = Task(session.document, board, name, parameters, request, cell, folder, note_best)
            return propose(task, session.analysed_board, progress)

        def take(proposal: Proposal) -> None:
            self._best = None
            if proposal.board is self._page.session.workpiece:  # else another one was chosen just now
                self._page.remember(lambda session: replace(session, proposal=proposal))
                if self._window is not None:
                    with self._page.client.atomic():
                        self._window.propose(proposal)

        self._best = None
        self._job.start(work, take, self._show_form)

    def _cancel(self) -> None:
        """Stop, and offer the best recipe until then, if that is another one and for this board."""
        best, self._best = self._best, None
        with self._page.client.atomic():
            self._job.stop()
            if best is None or not best.changes or best.board is not self._page.session.workpiece:
                self._show_form("")
                return
            self._page.remember(lambda session: replace(session, proposal=best))
            if self._window is not None:
                self._window.propose(best)

    def _show_form(self, remark: str) -> None:
        if self._window is not None:
            self._window.show_form(remark)


def state_html(session: Session) -> str:
    """Whether a tuned recipe waits for a decision, and whether it is of the present text."""
    proposal = session.proposal
    if proposal is None:
        return ""
    older = "" if proposal.fits(session.document) else " The recipe was edited since."
    return quiet_html(f"Tuned, not applied: {headline_of(proposal.tuned).lower()}{older}")
