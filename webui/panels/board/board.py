"""What is loaded, where it came from, how it is coloured."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import viser

from boards.board import Board, Side
from boards.load import board_library, load_board
from specs.progress import Progress
from webui.cards.component_card import board_html
from webui.cards.stroke_card import legend_html
from webui.forms.dropdown import offer
from webui.layers.surface.ground import ColourBy
from webui.page.imports import Loaded, import_board, join_table, progress_html
from webui.page.page import Page
from webui.page.session import Session
from webui.scene.scene import Scene
from webui.threads.worker import Worker

_COLOURS: dict[str, ColourBy] = {"Nothing": "nothing", "Class": "class", "Height": "height", "Package": "package"}
_SIDES: dict[str, Side] = {"Top side": "top", "Bottom side": "bottom"}
_LIBRARY_HALF = ".emp"
"""An IDF board comes in two files; this one holds the heights and is no board."""


class BoardPanel:
    """What is loaded, where it came from, how it is coloured."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._loader: Worker[Loaded] = Worker(self._show_progress)
        self._told = 0
        self._given = (page.session.board_name, page.session.board)
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
        self._what = gui.add_html("", visible=False)
        self._bar = gui.add_progress_bar(0.0, visible=False, animated=True)
        self._cancel = gui.add_button("Cancel", visible=False, color="gray", hint="Keep the board that is shown.")
        self._card = gui.add_html("")
        self._by = gui.add_dropdown("Colour by", tuple(_COLOURS), hint="What the colours of the parts tell apart.")
        self._legend = gui.add_html("")
        self._whole = gui.add_button_group("Look at", tuple(_SIDES), hint="The whole board, from above or from below.")
        self._choice.on_update(lambda event: self._choose(event.target.value, by_hand=event.client is not None))
        self._upload.on_upload(lambda event: self._import(event.target.value))
        self._sheet.on_upload(lambda event: self._join(event.target.value))
        self._cancel.on_click(lambda _: self._stop())
        self._by.on_update(lambda event: self._colour(event.target.value))
        self._whole.on_click(lambda event: scene.look_at_board(_SIDES[event.target.value]))
        page.on_close(self._loader.close)

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.board is not before.board:
            self._card.content = board_html(session.board)
            self._offer(session)
        if before is None or session.run is not before.run or session.board is not before.board:
            self._legend.content = legend_html(self._scene.legends.get("components", {}))

    def _names(self, session: Session) -> tuple[str, ...]:
        return tuple(dict.fromkeys([*self._page.project.boards(), self._given[0], session.board_name]))

    def _offer(self, session: Session) -> None:
        offer(self._choice, self._names(session), session.board_name)

    def _choose(self, name: str, *, by_hand: bool) -> None:
        if by_hand and name != self._page.session.board_name:
            self._start(lambda progress: Loaded(name, self._read(name, progress)))

    def _read(self, name: str, progress: Progress, table: Path | None = None) -> Board:
        """Read a board by its name; the one that the page began with may lie outside the folder."""
        given, board = self._given
        known = name == given and name not in self._page.project.boards()
        if known and table is None:
            return board
        path = Path(name) if known or name in board_library() else self._page.project.locate(name)
        return load_board(path, table, progress)

    def _import(self, file: viser.UploadedFile) -> None:
        project = self._page.project
        if file.name.lower().endswith(_LIBRARY_HALF):
            self._page.attempt(lambda session: self._keep(file, session))
        else:
            self._start(lambda progress: import_board(project, file.name, file.content, progress))

    def _keep(self, file: viser.UploadedFile, session: Session) -> Session:
        name = self._page.project.store(file.name, file.content).name
        self._page.say(f"{name} is kept", "It goes with a board file .emn of the same name: import that one now.")
        return session

    def _join(self, file: viser.UploadedFile) -> None:
        name = self._page.session.board_name
        self._start(
            lambda progress: Loaded(
                name, join_table(file.name, file.content, lambda table: self._read(name, progress, table))
            )
        )

    def _start(self, work: Callable[[Progress], Loaded]) -> None:
        self._told = 0
        self._show_bar(visible=True)
        self._loader.start(work, self._loaded, self._failed)

    def _loaded(self, loaded: Loaded) -> None:
        self._show_bar(visible=False)
        self._page.attempt(lambda session: session.with_board(loaded.name, loaded.board))

    def _failed(self, error: Exception) -> None:
        self._show_bar(visible=False)
        self._page.report(error)
        self._offer(self._page.session)

    def _stop(self) -> None:
        self._loader.cancel()
        self._show_bar(visible=False)
        self._offer(self._page.session)

    def _show_progress(self, what: str, done: float) -> None:
        percent = round(100 * done)
        if percent != self._told or percent == 0:  # a line for each of a million records would choke the connection
            self._told = percent
            with self._page.client.atomic():
                self._bar.value = float(percent)
                self._what.content = progress_html(what, percent)

    def _show_bar(self, *, visible: bool) -> None:
        with self._page.client.atomic():
            self._bar.visible = self._what.visible = self._cancel.visible = visible

    def _colour(self, name: str) -> None:
        with self._page.client.atomic():
            self._scene.change_view(replace(self._scene.view, components_by=_COLOURS[name]))
            self._legend.content = legend_html(self._scene.legends.get("components", {}))
