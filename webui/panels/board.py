"""What is loaded, where it came from, how it is coloured."""

from dataclasses import replace
from pathlib import Path

import viser

from boards.board import Board
from boards.load import board_library, load_board
from geometry.errors import JobError
from geometry.progress import Progress
from webui.component_card import board_html
from webui.layers.ground import ColourBy
from webui.page import Page
from webui.scene import Scene
from webui.session import Session
from webui.stroke_card import legend_html
from webui.work import Worker

_COLOURS: dict[str, ColourBy] = {"Nothing": "nothing", "Class": "class", "Height": "height", "Package": "package"}


class BoardPanel:
    """What is loaded, where it came from, how it is coloured."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._loader: Worker[Board] = Worker(self._tell)
        gui = page.client.gui
        self._choice = gui.add_dropdown("Board", self._names(page.session), initial_value=page.session.board_name)
        self._upload = gui.add_upload_button(
            "Import CAD", hint="STEP, KiCad, IDF, GLB, STL, OBJ, PLY or .tri; it is kept in the project folder."
        )
        self._bar = gui.add_progress_bar(0.0, visible=False, animated=True)
        self._what = gui.add_markdown("", visible=False)
        self._cancel = gui.add_button("Cancel", visible=False)
        self._card = gui.add_html("")
        self._by = gui.add_dropdown("Colour by", tuple(_COLOURS), hint="What the colours of the parts tell apart.")
        self._legend = gui.add_html("")
        self._reset = gui.add_button("Whole board in view")
        self._choice.on_update(lambda event: self._choose(event.target.value, by_hand=event.client is not None))
        self._upload.on_upload(lambda event: self._import(event.target.value))
        self._cancel.on_click(lambda _: self._stop())
        self._by.on_update(lambda event: self._colour(event.target.value))
        self._reset.on_click(lambda _: scene.look_at_board())
        page.on_close(self._loader.close)

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.board is not before.board:
            self._card.content = board_html(session.board)
            self._offer(session)
        if before is None or session.run is not before.run:
            self._legend.content = legend_html(self._scene.legends.get("components", {}))

    def _names(self, session: Session) -> tuple[str, ...]:
        return tuple(dict.fromkeys([*self._page.project.boards(), session.board_name]))

    def _offer(self, session: Session) -> None:
        names = self._names(session)
        if tuple(self._choice.options) != names:
            self._choice.options = names
        if self._choice.value != session.board_name:
            self._choice.value = session.board_name

    def _choose(self, name: str, *, by_hand: bool) -> None:
        if by_hand and name != self._page.session.board_name:
            self._load(name)

    def _import(self, file: viser.UploadedFile) -> None:
        try:
            name = self._page.project.store(file.name, file.content)
        except JobError as error:
            self._page.refuse(str(error))
            return
        self._load(name)

    def _load(self, name: str) -> None:
        self._show_progress(visible=True)
        self._loader.start(lambda tell: self._read(name, tell), lambda board: self._loaded(name, board), self._failed)

    def _read(self, name: str, tell: Progress) -> Board:
        path = Path(name) if name in board_library() else self._page.project.locate(name)
        return load_board(path, None, tell)

    def _loaded(self, name: str, board: Board) -> None:
        self._show_progress(visible=False)
        self._page.attempt(lambda session: session.with_board(name, board))

    def _failed(self, error: Exception) -> None:
        self._show_progress(visible=False)
        self._page.report(error)
        self._offer(self._page.session)

    def _stop(self) -> None:
        self._loader.cancel()
        self._show_progress(visible=False)
        self._offer(self._page.session)

    def _tell(self, what: str, done: float) -> None:
        with self._page.client.atomic():
            self._bar.value = 100.0 * done
            self._what.content = what

    def _show_progress(self, *, visible: bool) -> None:
        with self._page.client.atomic():
            self._bar.visible = self._what.visible = self._cancel.visible = visible

    def _colour(self, name: str) -> None:
        with self._page.client.atomic():
            self._scene.change_view(replace(self._scene.view, components_by=_COLOURS[name]))
            self._legend.content = legend_html(self._scene.legends.get("components", {}))
