"""The board: import, parts table, card, colours and views."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import viser

from boards.board import Board, Side
from boards.load import board_library, load_board
from specs.progress import Progress
from webui.cards.component_card import board_html
from webui.layers.surface.ground import ColourBy
from webui.page.imports import Loaded, import_board, join_table
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import offer, on_choice
from webui.panels.widgets.job import Job
from webui.scene.scene import Scene
from webui.theme.html import legend_html

_COLOURS: dict[str, ColourBy] = {"Nothing": "nothing", "Class": "class", "Height": "height", "Package": "package"}
_SIDES: dict[str, Side] = {"Top side": "top", "Bottom side": "bottom"}
_LIBRARY_HALF = ".emp"
"""An IDF board comes in two files; this one holds the heights and is no board."""


class BoardPanel:
    """The board: import, parts table, card, colours and views."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._first = (page.session.board_name, page.session.board)
        gui = page.client.gui
        self._choice = gui.add_dropdown(
            "Board", self._names(page.session), initial_value=page.session.board_name, hint="Samples, then your folder."
        )
        self._upload = gui.add_upload_button(
            "Import CAD", color="gray", hint="STEP, KiCad, IDF, GLB, STL, OBJ, PLY or .tri, kept in the project folder."
        )
        self._sheet = gui.add_upload_button(
            "Join parts table", color="gray", hint="CSV, TSV or KiCad .pos with packages, pins, heights or standoffs."
        )
        self._job: Job[Loaded] = Job(page, refuse=page.refuse)
        self._cancel = gui.add_button("Cancel", visible=False, color="gray", hint="Keep the board that is shown.")
        self._card = gui.add_html("")
        self._by = gui.add_dropdown("Colour by", tuple(_COLOURS), hint="Meaning of the colours of the parts.")
        self._legend = gui.add_html("")
        whole = gui.add_button_group("Look at", tuple(_SIDES), hint="The whole board, from above or from below.")
        on_choice(self._choice, self._choose)
        self._upload.on_upload(lambda event: self._import(event.target.value))
        self._sheet.on_upload(lambda event: self._join(event.target.value))
        self._cancel.on_click(lambda _: self._stop())
        self._by.on_update(lambda _: self._recolour())
        whole.on_click(lambda event: scene.look_at_board(_SIDES[event.target.value]))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.board is not before.board:
            self._card.content = board_html(session.board)
            offer(self._choice, self._names(session), session.board_name)
        if before is None or session.run is not before.run or session.board is not before.board:
            self._legend.content = legend_html(self._scene.legends.get("components", {}).items())

    def _names(self, session: Session) -> tuple[str, ...]:
        return tuple(dict.fromkeys([*self._page.project.boards(), self._first[0], session.board_name]))

    def _choose(self, name: str) -> None:
        if name != self._page.session.board_name:
            self._start(lambda progress: Loaded(name, self._read(name, progress)))

    def _read(self, name: str, progress: Progress, table: Path | None = None) -> Board:
        """Read a board by its name; the first board of the page may lie outside the folder."""
        first, board = self._first
        known = name == first and name not in self._page.project.boards()
        if known and table is None:
            return board
        path = Path(name) if known or name in board_library() else self._page.project.locate(name)
        return load_board(path, table, progress)

    def _import(self, file: viser.UploadedFile) -> None:
        project = self._page.project

        def keep(session: Session) -> Session:
            name = project.store(file.name, file.content).name
            self._page.notify(
                f"{name} is kept", "It goes with a board file .emn of the same name: import that one now."
            )
            return session

        if file.name.lower().endswith(_LIBRARY_HALF):
            self._page.attempt(keep)
        else:
            self._start(lambda progress: import_board(project, file.name, file.content, progress))

    def _join(self, file: viser.UploadedFile) -> None:
        name = self._page.session.board_name

        def work(progress: Progress) -> Loaded:
            return Loaded(name, join_table(file.name, file.content, lambda table: self._read(name, progress, table)))

        self._start(work)

    def _start(self, work: Callable[[Progress], Loaded]) -> None:
        self._cancel.visible = True
        self._job.start(work, self._take, lambda _: self._stop())

    def _take(self, loaded: Loaded) -> None:
        self._cancel.visible = False
        self._page.attempt(lambda session: session.with_board(loaded.name, loaded.board))

    def _stop(self) -> None:
        """Keep the board that is shown."""
        self._job.stop()
        self._cancel.visible = False
        offer(self._choice, self._names(self._page.session), self._page.session.board_name)

    def _recolour(self) -> None:
        with self._page.client.atomic():
            self._scene.change_view(replace(self._scene.view, components_by=_COLOURS[self._by.value]))
            self._legend.content = legend_html(self._scene.legends.get("components", {}).items())
