"""The robot's program: its text, linked with the motions in the scene, its download; programs that are read."""

from collections.abc import Callable
from dataclasses import replace
from html import escape

import viser

from programs.export import Variant
from programs.posts.dialects import DIALECTS
from programs.program import MoveTo
from reports.tables.wording import clock
from specs.errors import JobError
from specs.progress import Progress
from specs.source import NO_SOURCE, Source
from webui.cards.findings import mistakes_html
from webui.downloads.downloads import RobotProgram, download_program, forbidding, judge_program, make_program
from webui.downloads.program_text import PAGE_LINES, TextFile, find_text, next_move, page_html
from webui.glb.glb import line_width_mm, size_mm
from webui.layers.paths.nozzle import motion_glb
from webui.page.evaluations import Judged
from webui.page.page import Page
from webui.page.read_back import read_project_program, read_uploaded_program
from webui.page.session import ReadBack, Session
from webui.panels.widgets.choices import (
    AllowedRules,
    button,
    buttons,
    checkbox,
    dropdown,
    offer,
    on_choice,
    show_while,
    upload,
)
from webui.panels.widgets.job import Dialog, Job, RunButton
from webui.scene.scene import Scene
from webui.theme.html import box_html, card_html, facts_html, quiet_html

_STEPS = {"Previous": -1, "Next": 1}
_NOTHING: tuple[str, ...] = ("",)
_LAYER = "/motion"


class TextPreview:
    """A program's text page by page: the chosen line is marked in the scene, the selected stroke in the text."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; nothing is visible before there is a text."""
        self._page, self._scene = page, scene
        self._files: tuple[TextFile, ...] = ()
        self._number = 1
        gui = page.client.gui

        def step_move(step: str) -> None:
            self._go_and_select(next_move(self._shown, self._number, _STEPS[step]))

        def step_page(step: str) -> None:
            self._go_and_select(self._number + _STEPS[step] * PAGE_LINES)

        self._folder = gui.add_folder("Text", visible=False)
        with self._folder:
            hint = "The first one starts the program."
            self._file = dropdown(gui, "File", _NOTHING, hint, lambda _: self._go_and_select(1), visible=False)
            self._line = gui.add_number("Line", 1, min=1, step=1, hint="Where it moves to is marked in the picture.")
            buttons(gui, "Motion", _STEPS, step_move, "The motion before this line, or after it.")
            buttons(gui, "Page", _STEPS, step_page, f"Of {PAGE_LINES} lines.")
            self._text = gui.add_html("")
        on_choice(self._line, lambda number: self._go_and_select(round(number)))

    def open(self, files: tuple[TextFile, ...], made_by: Source) -> None:
        """Show a text at a stroke, from its beginning if it does not contain it.

        Args:
            files: The text; none to show nothing.
            made_by: The stroke; empty for none.
        """
        self._files, self._number = files, 1
        self._folder.visible = bool(files)
        if not files:
            self._scene.draw_over(_LAYER, b"")
            return
        names = tuple(file.name for file in files)
        offer(self._file, names, names[0])
        self._file.visible = len(names) > 1
        if not self.find(made_by):
            self._go(1)

    def find(self, made_by: Source) -> bool:
        """Go to the line of a stroke, unless the present line is part of it; whether there is such a line."""
        if not self._files:
            return False
        if made_by and self._shown.makers[self._number - 1] == made_by:
            self._go(self._number)
            return True
        place = find_text(self._files, made_by)
        if place is None:
            self._show_text()
            return False
        self._file.value = self._files[place[0]].name
        self._go(place[1])
        return True

    @property
    def _shown(self) -> TextFile:
        return next((file for file in self._files if file.name == self._file.value), self._files[0])

    def _go_and_select(self, number: int) -> None:
        """Go to a line and select its stroke."""
        with self._page.client.atomic():
            self._go(number)
        maker = self._shown.makers[self._number - 1]
        if any(stroke.made_by == maker for stroke in self._scene.strokes):
            self._page.select(made_by=maker)

    def _go(self, number: int) -> None:
        file = self._shown
        self._number = min(max(number, 1), len(file.lines))
        self._line.max = float(len(file.lines))
        self._line.value = self._number
        self._show_text()
        width = line_width_mm(size_mm(self._page.session.workpiece))
        self._scene.draw_over(_LAYER, motion_glb(file.moves[self._number - 1], width))

    def _show_text(self) -> None:
        self._text.content = page_html(self._shown, self._number, self._page.session.selection.made_by)


OPEN, UPLOAD, CLOSE = "Open a program\N{HORIZONTAL ELLIPSIS}", "Upload a program", "Close the program"
_NOTE = "Shows a program in a robot's language as it is written: its paths, timed by the speeds that it states."


class ReadBackCard:
    """Programs in robots' languages: opened, shown and closed."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        gui = page.client.gui

        def take(file: viser.UploadedFile) -> None:
            project, session = page.project, page.session
            self._start(lambda progress: read_uploaded_program(project, file.name, file.content, session, progress))

        with gui.add_folder("Read a program"):
            hint = "A file of the project folder, or a folder of files."
            opens = button(gui, OPEN, self._choose, hint)
            upload(gui, UPLOAD, take, "One file, or a zip of several; not kept.")
            self._job: Job[ReadBack] = Job(page, refuse=page.refuse, cancelled=lambda: None)
            hint = "Goes back to the recipe and its program."
            closes = button(gui, CLOSE, page.close_program, hint, visible=False)
        show_while(page, lambda now: now.shown is None, opens)
        show_while(page, lambda now: now.shown is not None, closes)
        page.follow(
            lambda now: self._job.show(quiet_html(_NOTE) if now.shown is None else shown_html(now.shown)),
            lambda now: now.shown,
        )

    def _choose(self) -> None:
        project = self._page.project
        names = project.programs()
        if not names:
            self._page.refuse(f"There is no program in a robot's language in {project.folder}; upload one.")
            return
        dialog = Dialog(self._page, "Open a program", "The recipe stays as it is, and goes on when it is closed.")
        dialog.choice("Program", names, "A file, or a folder of files, which ends with /.")

        def begin(name: str) -> None:
            session = self._page.session
            self._start(lambda progress: read_project_program(project, name, session, progress))

        dialog.button("Open", begin)

    def _start(self, work: Callable[[Progress], ReadBack]) -> None:
        self._job.start(work, self._page.open_program)


def shown_html(shown: ReadBack) -> str:
    """Language, board, cell, time and size of a program that was read."""
    program = shown.run.program
    origin, moves = program.origin, sum(isinstance(item, MoveTo) for item in program.instructions)
    facts = {
        "Program": shown.name,
        "Language": shown.language,
        "Cell": shown.cell,
        "Board": origin.board,
        "Recipe": origin.recipe,
        "Time": f"{clock(program.totals.duration_s)}, {clock(program.totals.spray_s)} sprayed",
        "Way": f"{program.totals.travel_mm / 1000:.2f} m, {moves:,} poses",
    }
    return box_html(facts_html(facts) + (quiet_html(escape(shown.note)) if shown.note else ""))


_NO_CELL = "Choose a cell in the tab Robot first: its robot, tools and channels are what a program is written for."


class ProgramPanel:
    """The robot's program: its text, linked with the motions in the scene, and its download."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        self._made: RobotProgram | None = None
        gui = page.client.gui
        self._names = {language.title: name for name, language in DIALECTS.items()}
        self._language = dropdown(gui, "Language", self._names, "Of the robot's controller.", lambda _: self._choose())
        self._notes = gui.add_html("")
        hint = "No valve opens, it is slow, and stops before each step; under another name."
        self._first = checkbox(gui, "First run", False, hint, lambda _: self._write_again())
        hint = "The program is checked in the cell first, if that was not done."
        self._run: RunButton[RobotProgram] = RunButton(page, "Write", self._begin, hint)
        hint = "What comes out clean as the controller drives the program, by its model, beside the plan."
        self._judge: RunButton[Judged] = RunButton(page, "Judge as driven", self._begin_judging, hint)
        self._preview = TextPreview(page, scene)
        self._allowed = AllowedRules(gui)
        hint = "The same bytes as the command line writes; several files as a zip."
        self._download = button(gui, "Download", self._send, hint, visible=False)
        ReadBackCard(page)

        def propose_language(session: Session) -> None:
            """Choose the language that was chosen before, else that of the robot's maker."""
            maker = None if session.cell is None else session.cell.cell.robot.maker
            own = (title for title, name in self._names.items() if maker is not None and DIALECTS[name].maker == maker)
            chosen = (title for title, name in self._names.items() if name == session.language)
            offer(self._language, tuple(self._names), next(chosen, None) or next(own, None))
            self._notes.content = quiet_html(DIALECTS[self._names[self._language.value]].notes)

        def forget(session: Session) -> None:
            if session.check is None:
                self._run.stop()
            self._forget(session)

        def find_selected(session: Session) -> None:
            if self._made is not None:
                self._preview.find(session.selection.made_by)

        def show_driven(session: Session) -> None:
            self._judge.show("" if session.judged_now is None else card_html(session.judged_now.verdict.card()))

        page.follow(propose_language, lambda now: now.cell_name)
        page.follow(forget, lambda now: (now.check, now.cell))
        page.follow(find_selected, lambda now: now.selection)
        page.follow(show_driven, lambda now: now.judged_now)

    def _choose(self) -> None:
        language = self._names[self._language.value]
        self._notes.content = quiet_html(DIALECTS[language].notes)
        self._page.remember(lambda session: replace(session, language=language))
        self._write_again()

    def _write_again(self) -> None:
        if self._made is not None:
            self._begin()

    def _begin(self) -> None:
        session, dialect = self._page.session, self._names[self._language.value]
        variant = Variant(first_run=self._first.value)
        self._run.start(
            lambda progress: make_program(session, dialect, progress, variant),
            self._take,
            lambda _: self._forget(self._page.session),
        )

    def _begin_judging(self) -> None:
        session, project, made = self._page.session, self._page.project, self._made
        if made is not None:
            self._judge.start(
                lambda progress: judge_program(
                    made, session, project.open_parameters(session.parameters_name), progress
                ),
                lambda judged: self._page.remember(lambda now: replace(now, judged=judged)),
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
            self._download.visible = self._judge.handle.visible = True

    def _forget(self, session: Session) -> None:
        """Show no text: there is none of the program as it is now."""
        older, self._made = self._made is not None, None
        self._run.handle.visible = session.cell is not None
        changed = "The program or the cell changed since it was written." if older else ""
        self._run.show(quiet_html(_NO_CELL if session.cell is None else changed))
        self._preview.open((), NO_SOURCE)
        self._allowed.offer(())
        self._download.visible = self._judge.handle.visible = False
        self._judge.stop()

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
