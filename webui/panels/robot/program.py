"""The robot's program: its text, linked with the motions in the scene, and its download."""

from dataclasses import replace

from programs.posts.dialects import DIALECTS
from specs.errors import JobError
from specs.source import NO_SOURCE
from webui.cards.finding_list import mistakes_html
from webui.downloads.downloads import RobotProgram, download_program, forbidding, make_program
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.robot.read_back import ReadBackCard
from webui.panels.robot.text_preview import TextPreview
from webui.panels.widgets.choices import AllowedRules, offer, on_choice
from webui.panels.widgets.job import RunButton
from webui.scene.scene import Scene
from webui.theme.html import box_html, facts_html, quiet_html

_NO_CELL = "Choose a cell in the tab Robot first: its robot, tools and channels are what a program is written for."


class ProgramPanel:
    """The robot's program: its text, linked with the motions in the scene, and its download."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        self._made: RobotProgram | None = None
        gui = page.client.gui
        self._names = {language.title: name for name, language in DIALECTS.items()}
        self._language = gui.add_dropdown("Language", tuple(self._names), hint="Of the robot's controller.")
        self._notes = gui.add_html("")
        self._run: RunButton[RobotProgram] = RunButton(
            page, "Write", self._begin, "The program is checked in the cell first, if that was not done."
        )
        self._preview = TextPreview(page, scene)
        self._allowed = AllowedRules(gui)
        self._download = gui.add_button(
            "Download",
            visible=False,
            hint="The same bytes as the command line writes; several files as a zip.",
        )
        self._read = ReadBackCard(page)
        on_choice(self._language, lambda _: self._choose())
        self._download.on_click(lambda _: self._send())
        self._notes.content = quiet_html(DIALECTS[self._names[self._language.value]].notes)

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        self._read.show(session, before)
        if before is None or session.cell_name != before.cell_name:
            self._propose_language(session)
        if before is None or session.check is not before.check or session.cell is not before.cell:
            if session.check is None:
                self._run.stop()
            self._forget(session)
        elif session.selection != before.selection and self._made is not None:
            self._preview.find(session.selection.made_by)

    def _propose_language(self, session: Session) -> None:
        """Choose the language that was chosen before, else that of the robot's maker."""
        maker = None if session.cell is None else session.cell.cell.robot.maker
        own = (title for title, name in self._names.items() if maker is not None and DIALECTS[name].maker == maker)
        chosen = (title for title, name in self._names.items() if name == session.language)
        offer(self._language, tuple(self._names), next(chosen, None) or next(own, None))
        self._notes.content = quiet_html(DIALECTS[self._names[self._language.value]].notes)

    def _choose(self) -> None:
        language = self._names[self._language.value]
        self._notes.content = quiet_html(DIALECTS[language].notes)
        self._page.remember(lambda session: replace(session, language=language))
        if self._made is not None:
            self._begin()

    def _begin(self) -> None:
        session, dialect = self._page.session, self._names[self._language.value]
        self._run.start(
            lambda progress: make_program(session, dialect, progress),
            self._take,
            lambda _: self._forget(self._page.session),
        )

    def _take(self, made: RobotProgram) -> None:
        if made.checked is not self._page.session.checked:
            self._page.remember(lambda session: replace(session, checked=made.checked))
        session = self._page.session
        with self._page.client.atomic():
            if made.checked is not session.check:  # the program has changed meanwhile
                self._forget(session)
                return
            self._made = made
            self._run.show(written_html(made))
            self._preview.open(made.written.files, session.selection.made_by)
            self._allowed.offer(forbidding(made.findings))
            self._download.visible = True

    def _forget(self, session: Session) -> None:
        """Show no text: there is none of the program as it is now."""
        older, self._made = self._made is not None, None
        self._run.handle.visible = session.cell is not None
        changed = "The program or the cell changed since it was written." if older else ""
        self._run.show(quiet_html(_NO_CELL if session.cell is None else changed))
        self._preview.open((), NO_SOURCE)
        self._allowed.offer(())
        self._download.visible = False

    def _send(self) -> None:
        made = self._made
        if made is None:
            return
        try:
            download = download_program(made, self._allowed.rules)
        except JobError as error:
            self._page.report(error)
            return
        self._page.client.send_file_download(download.name, download.content, save_immediately=True)


def written_html(made: RobotProgram) -> str:
    """Files, timing errors of the jet, and findings of a written program."""
    written, exported = made.written, made.written.exported
    language, error = DIALECTS[written.dialect], exported.error
    lines = sum(len(file.lines) for file in written.files)
    facts = {
        "Files": f"{len(written.files)}, {lines:,} lines",
        **({"Time": forecast.describe()} if (forecast := exported.forecast) is not None else {}),
        "Events": f"at worst {error.distance_mm:.2f} mm, {1000 * error.time_s:.0f} ms off",
        "Read back": exported.agreement.describe(),
        "Controller": f"class {language.capability.controller_class}",
    }
    return box_html(facts_html(facts)) + mistakes_html(exported.findings)
