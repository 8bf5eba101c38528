"""The workpiece, a board or a part, and its components or faces: import, parts table, cards, colours and views."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import viser

from boards.board import Board, Side, Workpiece
from boards.load import load_board
from boards.workpiece import is_read_otherwise, load_workpiece
from recipes.recipe import Recipe
from specs.progress import Progress
from webui.cards.workpiece_card import list_places, place_html, workpiece_html
from webui.layers.surface.ground import ColourBy
from webui.page.page import Page
from webui.page.project import Project, ProjectError, uploaded_table
from webui.page.session import Session
from webui.panels.widgets.choices import PlaceStepper, buttons, dropdown, folder, html, offer, show_while, upload
from webui.panels.widgets.job import Job
from webui.scene.scene import Scene
from webui.theme.html import legend_html

_COLOURS: dict[str, ColourBy] = {"Nothing": "nothing", "Class": "class", "Height": "height", "Package": "package"}
_SIDES: dict[str, Side] = {"Top side": "top", "Bottom side": "bottom"}
_LIBRARY_HALF = ".emp"
"""An IDF board comes in two files; this one holds the heights and is no board."""
_TABLES = (".csv", ".tsv", ".txt", ".pos", ".xlsx")
_HINTS = (
    "Zooms in and shows the card; a click in the picture does too.",
    "Go through the list, those with findings first.",
)


@dataclass(frozen=True, slots=True, eq=False)
class Loaded:
    """A board or part, and its name in the project's list."""

    name: str
    workpiece: Workpiece


def import_workpiece(project: Project, name: str, content: bytes, recipe: Recipe, progress: Progress) -> Loaded:
    """Store an uploaded board or part in the project folder and read it for a recipe.

    If reading fails or is cancelled, it is removed.

    Raises:
        ProjectError: its name, kind or size cannot be used.
        OutputError: it cannot be written.
        BoardError: it cannot be read.
    """
    stored = project.store(name, content)
    try:
        return Loaded(
            stored.name, load_workpiece(project.locate(stored.name), None, progress, over_faces=recipe.over_faces)
        )
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
    with uploaded_table(name, content, f"parts{suffix}", "a parts table") as table:
        return read(table)


def is_board(session: Session) -> bool:
    """Whether the workpiece of a session is a board."""
    return session.board is not None


class BoardPanel:
    """The workpiece: import, parts table, card, colours and views."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._first = (page.session.workpiece_name, page.session.workpiece)
        gui = page.client.gui
        names, hint = self._names(page.session), "A board or a part: samples, then your folder."
        chosen = page.session.workpiece_name
        self._choice = dropdown(gui, "Workpiece", names, hint, self._choose, initial_value=chosen)
        hint = (
            "STEP, KiCad, Eagle, IPC-2581, IDF, GLB, STL, OBJ, PLY or .tri; ODB++, Gerber and orders as .tgz or .zip; "
            "for parts meshes, and clouds .xyz."
        )
        upload(gui, "Import CAD", self._import, hint)
        with folder(page, None, is_board):  # viser does not hide upload buttons themselves
            hint = "CSV, TSV, Excel or KiCad .pos with packages, pins, heights or standoffs."
            upload(gui, "Join parts table", self._join, hint)
        self._job: Job[Loaded] = Job(page, refuse=page.refuse, cancelled=self._keep)
        self._card = html(page, lambda now: workpiece_html(now.workpiece), lambda now: now.workpiece)
        self._by = dropdown(gui, "Colour by", _COLOURS, "Meaning of the colours of the parts.", self._recolour)
        self._legend = html(page, self._legend_html, lambda now: (now.run, now.workpiece))
        looks = "All of it, from above or from below."
        buttons(gui, "Look at", _SIDES, lambda side: scene.look_at_board(_SIDES[side]), looks)
        show_while(page, is_board, self._by)
        page.follow(lambda _: self._keep(), lambda now: now.workpiece)
        page.follow(self._read_otherwise, lambda now: now.recipe)

    def _names(self, session: Session) -> tuple[str, ...]:
        return tuple(dict.fromkeys([*self._page.project.workpieces(), self._first[0], session.workpiece_name]))

    def _choose(self, name: str) -> None:
        if name != self._page.session.workpiece_name:
            self._start(lambda progress: Loaded(name, self._read(name, progress)))

    def _read_otherwise(self, session: Session) -> None:
        """Read the workpiece again for a recipe that is for another kind of it."""
        name, over_faces = session.workpiece_name, session.recipe.over_faces
        if session.shown is None and is_read_otherwise(name, session.workpiece, over_faces=over_faces):
            self._start(lambda progress: Loaded(name, self._read(name, progress)))

    def _read(self, name: str, progress: Progress) -> Workpiece:
        """Read a board or part by its name, for the recipe as it is now."""
        workpiece, over_faces = self._first[1], self._page.session.recipe.over_faces
        if self._is_outside(name) and not is_read_otherwise(name, workpiece, over_faces=over_faces):
            return workpiece
        return load_workpiece(self._source(name), None, progress, over_faces=over_faces)

    def _source(self, name: str) -> str | Path:
        return name if self._is_outside(name) else self._page.project.workpiece_source(name)

    def _is_outside(self, name: str) -> bool:
        """Whether it is the first workpiece of the page, which may lie outside the folder."""
        return name == self._first[0] and name not in self._page.project.workpieces()

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
            self._start(
                lambda progress: import_workpiece(project, file.name, file.content, self._page.session.recipe, progress)
            )

    def _join(self, file: viser.UploadedFile) -> None:
        name = self._page.session.workpiece_name

        def work(progress: Progress) -> Loaded:
            path = Path(self._source(name))
            return Loaded(name, join_table(file.name, file.content, lambda table: load_board(path, table, progress)))

        self._start(work)

    def _start(self, work: Callable[[Progress], Loaded]) -> None:
        def take(loaded: Loaded) -> None:
            self._page.attempt(lambda session: session.with_workpiece(loaded.name, loaded.workpiece))

        self._job.start(work, take, lambda _: self._keep())

    def _keep(self) -> None:
        """Keep the board that is shown."""
        offer(self._choice, self._names(self._page.session), self._page.session.workpiece_name)

    def _legend_html(self, _session: Session) -> str:
        return legend_html(self._scene.legends.get("components", {}).items())

    def _recolour(self, by: str) -> None:
        with self._page.client.atomic():
            self._scene.change_view(replace(self._scene.view, components_by=_COLOURS[by]))
            self._legend.content = self._legend_html(self._page.session)


class ComponentsPanel:
    """The list of components or faces, and the card of the selected one."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        gui = page.client.gui
        hint = "Part of a name; of components, also of a package or class, or a pattern such as C1*."
        sought = gui.add_text("Filter", "", hint=hint)
        self._steps = PlaceStepper(page, scene, ("Go to", "Step"), _HINTS)
        self._list = gui.add_html("")

        def show(session: Session) -> None:
            listing = list_places(session, sought.value)
            with page.client.atomic():
                self._list.content = listing.html
                self._steps.offer(listing.names, session.selection.component)

        def shown(session: Session) -> object:
            return session.workpiece, session.run, session.selection

        with gui.add_folder("Selected"):
            self._card = html(page, lambda now: place_html(now, scene.strokes), shown)
        page.follow(show, shown)
        sought.on_update(lambda _: show(page.session))
