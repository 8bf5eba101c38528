"""Downloads: program, pictures, reports, a playback that opens without a server, or all of them as a zip."""

from reports.tables.wording import amount
from webui.downloads.downloads import KINDS, Download, forbidding, make_download
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import AllowedRules
from webui.panels.widgets.job import RunButton
from webui.scene.scene import Scene
from webui.theme.html import box_html, quiet_html

_RATES = ("1", "2", "5", "10", "20", "50")


class OutputPanel:
    """Downloads: program, pictures, reports, a playback that opens without a server, or all of them as a zip."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        del scene
        self._page = page
        gui = page.client.gui
        self._state = gui.add_html("")
        self._kind = gui.add_dropdown("File", tuple(KINDS), hint="What to download.")
        self._hint = gui.add_html(quiet_html(next(iter(KINDS.values()))[1]))
        self._rate = gui.add_dropdown(
            "Speed (x)", _RATES, initial_value="10", visible=False, hint="How many times faster than the robot."
        )
        self._run: RunButton[Download] = RunButton(
            page, "Download", self._begin, "The same bytes as the command line writes."
        )
        self._allowed = AllowedRules(gui)
        self._kind.on_update(lambda event: self._choose(event.target.value))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.run is not before.run or session.check is not before.check:
            of_plan = () if session.run is None else session.run.findings
            of_robot = () if session.check is None else session.check.findings
            rules = forbidding((*of_plan, *of_robot))
            violated = ", ".join(f"{rule} ({count})" for rule, count in rules.items())
            errors = amount(sum(rules.values()), "error").capitalize()
            whose = "the program" if forbidding(of_plan) else "the robot's program"
            hint = "Correct them, or tick the rule below to write the program in spite of it."
            self._state.content = box_html(f"{errors} forbid {whose}: {violated}. {hint}") if rules else ""
            self._allowed.offer(rules)

    def _choose(self, kind: str) -> None:
        self._hint.content = quiet_html(KINDS[kind][1])
        self._rate.visible = kind.startswith("Playback")

    def _begin(self) -> None:
        session, kind, rate = self._page.session, self._kind.value, float(self._rate.value)
        allowed, client = self._allowed.rules, self._page.client
        self._run.start(
            lambda progress: make_download(kind, session, allowed, rate, progress),
            lambda made: client.send_file_download(made.name, made.content, save_immediately=True),
        )
