"""Downloads: program, pictures, reports, and a playback that opens without a server."""

from reports.tables.wording import amount
from webui.downloads.downloads import KINDS, Download, forbidding, make_download
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import AllowedRules
from webui.scene.scene import Scene
from webui.theme.html import box_html, quiet_html
from webui.threads.worker import Worker

_RATES = ("1", "2", "5", "10", "20", "50")


class OutputPanel:
    """Downloads: program, pictures, reports, and a playback that opens without a server."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        self._worker: Worker[Download] = Worker(self._show_progress)
        page.on_close(self._worker.close)
        gui = page.client.gui
        self._state = gui.add_html("")
        self._kind = gui.add_dropdown("File", tuple(KINDS), hint="What to download.")
        self._hint = gui.add_html(quiet_html(next(iter(KINDS.values()))[1]))
        self._rate = gui.add_dropdown(
            "Speed (x)", _RATES, initial_value="10", visible=False, hint="How many times faster than the robot."
        )
        self._button = gui.add_button("Download", hint="The same bytes as the command line writes.")
        self._allowed = AllowedRules(gui)
        self._kind.on_update(lambda event: self._choose(event.target.value))
        self._button.on_click(lambda _: self._make())

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.run is not before.run:
            rules = forbidding(() if session.run is None else session.run.findings)
            violated = ", ".join(f"{rule} ({count})" for rule, count in rules.items())
            errors = amount(sum(rules.values()), "error").capitalize()
            hint = "Correct them, or tick the rule below to write the program in spite of it."
            self._state.content = box_html(f"{errors} forbid the program: {violated}. {hint}") if rules else ""
            self._allowed.offer(rules)

    def _choose(self, kind: str) -> None:
        self._hint.content = quiet_html(KINDS[kind][1])
        self._rate.visible = kind.startswith("Playback")

    def _make(self) -> None:
        session, kind, rate = self._page.session, self._kind.value, float(self._rate.value)
        allowed, client = self._allowed.rules, self._page.client

        def rest() -> None:
            self._button.label, self._button.disabled = "Download", False

        def send(download: Download) -> None:
            rest()
            client.send_file_download(download.name, download.content, save_immediately=True)

        def fail(error: Exception) -> None:
            rest()
            self._page.report(error)

        self._button.disabled = True
        self._worker.start(lambda progress: make_download(kind, session, allowed, rate, progress), send, fail)

    def _show_progress(self, what: str, done: float) -> None:
        if what == "recording":
            self._button.label = f"Recording\N{HORIZONTAL ELLIPSIS} {done:.0%}"
