"""The board and its components: import, parts table, cards, colours and views."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import viser

from boards.board import Board, Side
from boards.load import board_library, load_board
from specs.confinement import admit
from specs.progress import Progress
from specs.temporary import temporary_folder
from webui.cards.component_card import board_html, component_html, list_rows, rows_html
from webui.layers.surface.ground import ColourBy
from webui.page.page import Page
from webui.page.project import Project, ProjectError
from webui.page.session import Session
from webui.panels.widgets.choices import ComponentStepper, offer, on_choice
from webui.panels.widgets.job import Job
from webui.scene.scene import Scene
from webui.theme.html import legend_html

_COLOURS: dict[str, ColourBy] = {"Nothing": "nothing", "Class": "class", "Height": "height", "Package": "package"}
_SIDES: dict[str, Side] = {"Top side": "top", "Bottom side": "bottom"}
_LIBRARY_HALF = ".emp"
"""An IDF board comes in two files; this one holds the heights and is no board."""
_TABLES = (".csv", ".tsv", ".txt", ".pos")
_LARGEST_TABLE = 20_000_000
_HINTS = (
    "Zooms in and shows the card; a click on a part in the picture does too.",
    "Go through the list, those with findings first.",
)


@dataclass(frozen=True, slots=True, eq=False)
class Loaded:
    """A board, and its name in the project's list."""

    name: str
    board: Board


def import_board(project: Project, name: str, content: bytes, progress: Progress) -> Loaded:
    """Store an uploaded board in the project folder and read it; if reading fails or is cancelled, it is removed.

    Raises:
        ProjectError: its name, kind or size cannot be used.
        OutputError: it cannot be written.
        BoardError: it cannot be read.
    """
    stored = project.store(name, content)
    try:
        return Loaded(stored.name, load_board(project.locate(stored.name), None, progress))
    except BaseException:
        if stored.fresh:
            project.discard(stored.name)
        raise


def join_table(name: str, content: bytes, read: Callable[[Path], Board]) -> Board:
    """Read a board again with an uploaded parts table, which is not stored.

    Args:
        name: Of the table, whose suffix is its kind.
        content: Of the table.
        read: Reads the board with the table in this file.

    Raises:
        ProjectError: the table's kind or size cannot be used.
        BoardError: the table or the board cannot be read.
    """
    suffix = next((each for each in _TABLES if name.lower().endswith(each)), None)
    if suffix is None:
        raise ProjectError(f"{name[:40]!r} is no parts table. Known are {', '.join(_TABLES)}.")
    if len(content) > _LARGEST_TABLE:
        raise ProjectError(f"{name[:40]!r}: {len(content) / 1e6:.0f} MB are too many for a parts table.")
    with temporary_folder() as folder:
        table = folder / f"parts{suffix}"
        table.write_bytes(content)
        with admit(table):
            return read(table)


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
            "Import CAD",
            hint="STEP, KiCad, Eagle, IDF, GLB, STL, OBJ, PLY or .tri; kept in the project.",
        )
        self._sheet = gui.add_upload_button(
            "Join parts table", hint="CSV, TSV or KiCad .pos with packages, pins, heights or standoffs."
        )
        self._job: Job[Loaded] = Job(page, refuse=page.refuse, cancelled=self._keep)
        self._card = gui.add_html("")
        self._by = gui.add_dropdown("Colour by", tuple(_COLOURS), hint="Meaning of the colours of the parts.")
        self._legend = gui.add_html("")
        whole = gui.add_button_group("Look at", tuple(_SIDES), hint="The whole board, from above or from below.")
        on_choice(self._choice, self._choose)
        self._upload.on_upload(lambda event: self._import(event.target.value))
        self._sheet.on_upload(lambda event: self._join(event.target.value))
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
        self._job.start(work, self._take, lambda _: self._keep())

    def _take(self, loaded: Loaded) -> None:
        self._page.attempt(lambda session: session.with_board(loaded.name, loaded.board))

    def _keep(self) -> None:
        """Keep the board that is shown."""
        offer(self._choice, self._names(self._page.session), self._page.session.board_name)

    def _recolour(self) -> None:
        with self._page.client.atomic():
            self._scene.change_view(replace(self._scene.view, components_by=_COLOURS[self._by.value]))
            self._legend.content = legend_html(self._scene.legends.get("components", {}).items())


class ComponentsPanel:
    """The list of components, and the card of the selected one."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui
        self._filter = gui.add_text("Filter", "", hint="Part of a name, package or class, or a pattern such as C1*.")
        self._steps = ComponentStepper(page, scene, ("Go to", "Step"), _HINTS)
        self._list = gui.add_html("")
        with gui.add_folder("Selected part"):
            self._card = gui.add_html("")
        self._filter.on_update(lambda _: self._list_components(page.session))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        same = before is not None and session.board is before.board and session.run is before.run
        if before is None or not same or session.selection != before.selection:
            self._card.content = component_html(session, self._scene.strokes)
            self._list_components(session)

    def _list_components(self, session: Session) -> None:
        rows, selected = list_rows(session, self._filter.value), session.selection.component
        with self._page.client.atomic():
            self._list.content = rows_html(rows, selected)
            self._steps.offer([row.component.name for row in rows], selected)
