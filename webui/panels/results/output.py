"""Downloads: program, pictures, reports, a playback that opens without a server, or all of them as a zip."""

from reports.tables.wording import amount
from rulesengine.planning.pipeline import Run
from specs.finding import Finding
from webui.downloads.downloads import KINDS, Download, forbidding, make_download
from webui.page.evaluations import Checked
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import AllowedRules, dropdown, html
from webui.panels.widgets.job import RunButton
from webui.scene.scene import Scene
from webui.theme.html import box_html, quiet_html

_RATES = ("1", "2", "5", "10", "20", "50")


class OutputPanel:
    """Downloads: program, pictures, reports, a playback that opens without a server, or all of them as a zip."""

    def __init__(self, page: Page, _scene: Scene) -> None:
        """Build the elements in the container that is open."""
        gui = page.client.gui
        html(page, forbidden_html, _found_in)

        def choose(kind: str) -> None:
            about.content = quiet_html(KINDS[kind][1])
            rate.visible = kind.startswith("Playback")

        def begin() -> None:
            session, chosen, times, allowed = page.session, kind.value, float(rate.value), rules.rules
            run.start(
                lambda progress: make_download(chosen, session, allowed, times, progress),
                lambda made: page.client.send_file_download(made.name, made.content, save_immediately=True),
            )

        kind = dropdown(gui, "File", KINDS, "What to download.", choose)
        about = gui.add_html(quiet_html(next(iter(KINDS.values()))[1]))
        hint = "How many times faster than the robot."
        rate = dropdown(gui, "Speed (x)", _RATES, hint, initial_value="10", visible=False)
        run: RunButton[Download] = RunButton(page, "Download", begin, "The same bytes as the command line writes.")
        rules = AllowedRules(gui)
        page.follow(lambda now: rules.offer(forbidding(_findings_of(now))), _found_in)


def forbidden_html(session: Session) -> str:
    """Rules whose errors forbid the program of a session; nothing where none does."""
    rules = forbidding(_findings_of(session))
    violated = ", ".join(f"{rule} ({count})" for rule, count in rules.items())
    errors = amount(sum(rules.values()), "error").capitalize()
    of_plan = session.run is not None and forbidding(session.run.findings)
    whose = "the program" if of_plan else "the robot's program"
    hint = "Correct them, or tick the rule below to write the program in spite of it."
    return box_html(f"{errors} forbid {whose}: {violated}. {hint}") if rules else ""


def _findings_of(session: Session) -> tuple[Finding, ...]:
    """Findings of the plan, then of the check."""
    return tuple(each for found in _found_in(session) if found is not None for each in found.findings)


def _found_in(session: Session) -> tuple[Run | None, Checked | None]:
    return session.run, session.check
