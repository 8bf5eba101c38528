"""Programs in robots' languages, opened from the project folder or uploaded, shown in place of the job."""

from collections.abc import Callable
from html import escape

import viser

from programs.program import MoveTo
from reports.tables.wording import clock
from specs.progress import Progress
from webui.page.page import Page
from webui.page.read_back import Around, ReadBack, read_project_program, read_uploaded_program
from webui.page.session import Change, Session
from webui.panels.widgets.dialog import Dialog
from webui.panels.widgets.job import Job
from webui.theme.html import box_html, facts_html, quiet_html

OPEN, UPLOAD, CLOSE = "Open a program\N{HORIZONTAL ELLIPSIS}", "Upload a program", "Close the program"
_NOTE = "Shows a program in a robot's language as it is written: its paths, timed by the speeds that it states."


class ReadBackCard:
    """Programs in robots' languages: opened, shown and closed."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        gui = page.client.gui
        with gui.add_folder("Read a program"):
            self._open = gui.add_button(OPEN, hint="A file of the project folder, or a folder of files.")
            self._upload = gui.add_upload_button(UPLOAD, hint="One file, or a zip of several; not kept.")
            self._job: Job[ReadBack] = Job(page, refuse=page.refuse, cancelled=lambda: None)
            self._close = gui.add_button(CLOSE, visible=False, hint="Goes back to the recipe and its program.")
        self._open.on_click(lambda _: self._choose())
        self._upload.on_upload(lambda event: self._take_upload(event.target.value))
        self._close.on_click(lambda _: page.close_program())

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is not None and session.shown is before.shown:
            return
        shown = session.shown
        self._open.visible = shown is None
        self._close.visible = shown is not None
        self._job.show(quiet_html(_NOTE) if shown is None else shown_html(shown))

    def _choose(self) -> None:
        project = self._page.project
        names = project.programs()
        if not names:
            self._page.refuse(f"There is no program in a robot's language in {project.folder}; upload one.")
            return
        dialog = Dialog(self._page, "Open a program", "The recipe stays as it is, and goes on when it is closed.")
        dialog.choice("Program", names, "A file, or a folder of files, which ends with /.")

        def begin(_: str, name: str) -> Change:
            def change(session: Session) -> Session:
                around = around_of(session)
                self._start(lambda progress: read_project_program(project, name, around, progress))
                return session

            return change

        dialog.buttons({"Open": begin})

    def _take_upload(self, file: viser.UploadedFile) -> None:
        project, around = self._page.project, around_of(self._page.session)
        self._start(lambda progress: read_uploaded_program(project, file.name, file.content, around, progress))

    def _start(self, work: Callable[[Progress], ReadBack]) -> None:
        self._job.start(work, self._page.open_program)


def around_of(session: Session) -> Around:
    """What is open while a program is read."""
    job = session.resumed()
    return Around(job.workpiece_name, job.workpiece, job.cell, job.recipe)


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
