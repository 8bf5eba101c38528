"""Downloads: program, picture, a playback that opens without a server."""

from reports.tables.wording import amount
from webui.cards.boxes import box_html, quiet_html
from webui.downloads.downloads import KINDS, Download, forbidding, make_download
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.allowance import Allowance
from webui.scene.scene import Scene
from webui.threads.worker import Worker

_RATES = ("1", "2", "5", "10", "20", "50")
_FIRST = next(iter(KINDS))
_HINTS = {
    "Program (.wash)": "The timed program; washboard show reads it.",
    "Picture (PNG)": "Board, paths and heights on one sheet.",
    "Picture (SVG)": "The same, to be enlarged or edited.",
    "Report (JSON)": "Totals, classes, components and findings as data.",
    "Playback (HTML)": "One file that plays in any browser, without Washboard.",
    "Recipe (YAML)": "The recipe as it is edited now.",
    "Cleaning report (HTML)": "What the program is predicted to clean, to look at and print.",
    "Cleaning report (JSON)": "The same as data.",
}


class OutputPanel:
    """Downloads: program, picture, a playback that opens without a server."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._worker: Worker[Download] = Worker(self._show_progress)
        page.on_close(self._worker.close)
        gui = page.client.gui
        self._state = gui.add_html("")
        self._kind = gui.add_dropdown("File", tuple(KINDS), hint="What to download.")
        self._hint = gui.add_html(quiet_html(_HINTS[_FIRST]))
        self._rate = gui.add_dropdown(
            "Speed (x)", _RATES, initial_value="10", visible=False, hint="How many times faster than the robot."
        )
        self._button = gui.add_button("Download", hint="The same bytes as the command line writes.")
        self._allowance = Allowance(gui)
        self._kind.on_update(lambda event: self._choose(event.target.value))
        self._button.on_click(lambda _: self._make())

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is not None and session.run is before.run:
            return
        rules = forbidding(session.run)
        self._state.content = _state_html(rules)
        self._allowance.offer(rules)

    def _choose(self, kind: str) -> None:
        self._hint.content = quiet_html(_HINTS[kind])
        self._rate.visible = kind.startswith("Playback")

    def _make(self) -> None:
        session, kind, rate = self._page.session, self._kind.value, float(self._rate.value)
        allowed = self._allowance.rules
        self._button.disabled = True
        self._worker.start(
            lambda progress: make_download(kind, session, allowed, rate, progress), self._send, self._fail
        )

    def _send(self, download: Download) -> None:
        self._rest()
        self._page.client.send_file_download(download.name, download.content, save_immediately=True)

    def _fail(self, error: Exception) -> None:
        self._rest()
        self._page.report(error)

    def _rest(self) -> None:
        self._button.label, self._button.disabled = "Download", False

    def _show_progress(self, what: str, done: float) -> None:
        if what == "recording":
            self._button.label = f"Recording\N{HORIZONTAL ELLIPSIS} {done:.0%}"


def _state_html(rules: dict[str, int]) -> str:
    if not rules:
        return ""
    broken = ", ".join(f"{rule} ({count})" for rule, count in rules.items())
    return box_html(
        f"{amount(sum(rules.values()), 'error').capitalize()} forbid the program: {broken}. Mend what the findings "
        "say, or tick the rule below to write the program in spite of it."
    )
