"""The workpiece, a board or a part, and its components or faces: import, parts table, cards, colours and views."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import viser

from boards.board import Board, Side, Workpiece
from boards.load import load_board
from boards.workpiece import is_read_otherwise, load_workpiece
from recipes.recipe import Recipe
from specs.confinement import admit
from specs.progress import Progress
from specs.temporary import temporary_folder
from webui.cards.workpiece_card import list_places, place_html, workpiece_html
from webui.layers.surface.ground import ColourBy
from webui.page.page import Page
from webui.page.project import Project, ProjectError
from webui.page.session import Session
from webui.panels.widgets.choices import PlaceStepper, offer, on_choice
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
    if len(content) > _LARGEST_TABLE:
        raise ProjectError(f"{name[:40]!r}: {len(content) / 1e6:.0f} MB are too many for a parts table.")
    with temporary_folder() as folder:
        table = folder / f"parts{suffix}"
        table.write_bytes(content)
        with admit(table):
            return read(table)


class BoardPanel:
    """The workpiece: import, parts table, card, colours and views."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._first = (page.session.workpiece_name, page.session.workpiece)
        gui = page.client.gui
        self._choice = gui.add_dropdown(
            "Workpiece",
            self._names(page.session),
            initial_value=page.session.workpiece_name,
            hint="A board or a part: samples, then your folder.",
        )
        self._upload = gui.add_upload_button(
            "Import CAD",
            hint="STEP, KiCad, Eagle, IPC-2581, IDF, GLB, STL, OBJ, PLY or .tri; ODB++ and Gerber as .tgz or .zip; "
            "for parts meshes, and clouds .xyz.",
        )
        self._tables = gui.add_folder(None)  # viser does not hide upload buttons themselves
        with self._tables:
            self._sheet = gui.add_upload_button(
                "Join parts table", hint="CSV, TSV or KiCad .pos with packages, pins, heights or standoffs."
            )
        self._job: Job[Loaded] = Job(page, refuse=page.refuse, cancelled=self._keep)
        self._card = gui.add_html("")
        self._by = gui.add_dropdown("Colour by", tuple(_COLOURS), hint="Meaning of the colours of the parts.")
        self._legend = gui.add_html("")
        whole = gui.add_button_group("Look at", tuple(_SIDES), hint="All of it, from above or from below.")
        on_choice(self._choice, self._choose)
        self._upload.on_upload(lambda event: self._import(event.target.value))
        self._sheet.on_upload(lambda event: self._join(event.target.value))
        self._by.on_update(lambda _: self._recolour())
        whole.on_click(lambda event: scene.look_at_board(_SIDES[event.target.value]))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.workpiece is not before.workpiece:
            self._card.content = workpiece_html(session.workpiece)
            self._tables.visible = self._by.visible = session.board is not None
            offer(self._choice, self._names(session), session.workpiece_name)
        if before is None or session.run is not before.run or session.workpiece is not before.workpiece:
            self._legend.content = legend_html(self._scene.legends.get("components", {}).items())
        recipe_is_new = before is not None and session.recipe is not before.recipe and session.shown is None
        source = session.workpiece_name
        if recipe_is_new and is_read_otherwise(source, session.workpiece, over_faces=session.recipe.over_faces):
            self._start(lambda progress: Loaded(source, self._read(source, progress)))

    def _names(self, session: Session) -> tuple[str, ...]:
        return tuple(dict.fromkeys([*self._page.project.workpieces(), self._first[0], session.workpiece_name]))

    def _choose(self, name: str) -> None:
        if name != self._page.session.workpiece_name:
            self._start(lambda progress: Loaded(name, self._read(name, progress)))

    def _read(self, name: str, progress: Progress) -> Workpiece:
        """Read a board or part by its name, for the recipe as it is now."""
        first, workpiece = self._first
        recipe = self._page.session.recipe
        if (
            name == first
            and self._is_outside(name)
            and not is_read_otherwise(name, workpiece, over_faces=recipe.over_faces)
        ):
            return workpiece
        return load_workpiece(self._source(name), None, progress, over_faces=recipe.over_faces)

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
        self._job.start(work, self._take, lambda _: self._keep())

    def _take(self, loaded: Loaded) -> None:
        self._page.attempt(lambda session: session.with_workpiece(loaded.name, loaded.workpiece))

    def _keep(self) -> None:
        """Keep the board that is shown."""
        offer(self._choice, self._names(self._page.session), self._page.session.workpiece_name)

    def _recolour(self) -> None:
        with self._page.client.atomic():
            self._scene.change_view(replace(self._scene.view, components_by=_COLOURS[self._by.value]))
            self._legend.content = legend_html(self._scene.legends.get("components", {}).items())


class ComponentsPanel:
    """The list of components or faces, and the card of the selected one."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui
        self._filter = gui.add_text(
            "Filter", "", hint="Part of a name; of components, also of a package or class, or a pattern such as C1*."
        )
        self._steps = PlaceStepper(page, scene, ("Go to", "Step"), _HINTS)
        self._list = gui.add_html("")
        with gui.add_folder("Selected"):
            self._card = gui.add_html("")
        self._filter.on_update(lambda _: self._list_components(page.session))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        same = before is not None and session.workpiece is before.workpiece and session.run is before.run
        if before is None or not same or session.selection != before.selection:
            self._card.content = place_html(session, self._scene.strokes)
            self._list_components(session)

    def _list_components(self, session: Session) -> None:
        listing = list_places(session, self._filter.value)
        with self._page.client.atomic():
            self._list.content = listing.html
            self._steps.offer(listing.names, session.selection.component)
