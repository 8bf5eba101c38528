"""The robot cell: its choice, its frames, its form, its views and cards; the program at the pace of its robot."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape

from reports.tables.wording import clock
from robotcell.cell.cell_edits import CellEdit
from robotcell.cell.hold import describe_held
from robotcell.cell.load import LoadedCell, cell_sha256
from robotcell.cell.spec import CellSpec, Hold, Place, ToolSpec
from robotcell.diagnosis.plausibility import Frame, check_cell, frame_card
from rulesengine.planning.pipeline import Run
from specs.spec import Spec
from specs.yaml.located import YamlPath
from specs.yaml.tree import Tree
from webui.cards.findings import mistakes_html
from webui.forms.entries import stated_at
from webui.forms.fields import Field, describe
from webui.forms.spec_form import SpecForm
from webui.page.evaluations import plan_at_pace
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.robot.check import CheckCard, JointsCard, ReachCard
from webui.panels.robot.placement import PlacementCard
from webui.panels.widgets.choices import buttons, checkbox, dropdown, folder, html, offer, show_while
from webui.panels.widgets.job import RunButton
from webui.scene.scene import Scene
from webui.theme.html import box_html, facts_html, grey_html, quiet_html, small_html


class PaceCard:
    """The planning for the robot, and its price."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; they are visible where there is a cell."""
        self._page = page

        def begin() -> None:
            now, cell = page.session.planned_run, page.session.cell
            if cell is not None:
                run.start(lambda progress: plan_at_pace(now, cell, progress), lambda done: self.take(now, done))

        with folder(page, "Plan for this robot", lambda now: now.cell is not None):
            hint = "Times the program so that the robot takes as long as planned."
            run: RunButton[Run] = RunButton(page, "Plan for this robot", begin, hint)
        page.follow(lambda now: run.show(price_html(now)), lambda now: (now.cell, now.run))

    def take(self, run: Run, done: Run) -> None:
        """Show a program that was planned for a run, unless another was planned meanwhile."""
        self._page.remember(lambda session: replace(session, run=done) if session.run is run else session)


def price_html(session: Session) -> str:
    """What the limits of the robot cost, or that the program does not know them."""
    run = session.run
    timing = None if run is None else run.robot
    if run is None or timing is None:
        return quiet_html("The times are those of the recipe's limits.")
    price = {kind[:1].upper() + kind[1:]: clock(seconds) for kind, seconds in timing.price_s}
    facts = {
        "Price": f"{clock(timing.planned_s - timing.free_s)} longer than the recipe's limits allow",
        **price,
        "Robot": f"takes {timing.robot_s / timing.planned_s:.3f} times the planned time",
    }
    same = session.cell is not None and cell_sha256(session.cell) == run.program.origin.cell_sha256
    older = "" if same else quiet_html(f"Another cell than this, {timing.cell}, gave the program its pace.")
    return older + box_html(facts_html(facts))


_NOTHING: tuple[str, ...] = ("",)
_SAVED = "Apply writes the cell's file; Undo takes it back."
_COPIED = "Apply writes a copy of this cell into the project folder, which is used from then on; Undo takes it back."


@dataclass(frozen=True, slots=True)
class Editable:
    """Something of a cell that a form edits."""

    label: str
    path: YamlPath
    spec: type[Spec]
    keys: tuple[str, ...] = ()
    """Keys of the specification that the form has; all of them if none is named."""


def places_of(cell: LoadedCell) -> tuple[Editable, ...]:
    """What the forms of a cell are about; a board that is held by measured points has none."""
    spec = cell.spec
    board = () if spec.board.pose is None else (Editable("Board", ("board",), Hold, ("hold", "pose")),)
    tools = (
        Editable(f"Tool {number}: {tool.name}", ("tools", str(number)), ToolSpec, ("tcp", "mass_kg"))
        for number, tool in sorted(spec.tools.items())
    )
    fixtures = (Editable(f"Fixture: {name}", ("fixtures", name), type(body)) for name, body in spec.fixtures.items())
    base = Editable("Base of the robot", ("base",), Place)
    return (*board, base, *tools, *fixtures, Editable("Margin", (), CellSpec, ("margin_mm",)))


def fields_of(cell: LoadedCell, place: Editable) -> tuple[tuple[Field, ...], Mapping[str, Tree]]:
    """Inputs for something of a cell, and the values that its file states there."""
    stated = stated_at(cell.root, place.path)
    return describe(place.spec, stated, {}, place.keys), stated


class CellForm:
    """A form for what stands in the cell."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; they are visible where there is a cell."""
        self._page = page
        self._places: tuple[Editable, ...] = ()
        self._cell: LoadedCell | None = None
        gui = page.client.gui
        with folder(page, "Edit the cell", lambda now: now.cell is not None, expanded=False):
            hint = "What stands in the cell, and where."
            self._choice = dropdown(gui, "Edit", _NOTHING, hint, lambda _: self._show_form())
            self._form = SpecForm(gui, self._apply)
            self._note = gui.add_html("")
        page.follow(self._show, lambda now: now.cell)

    def _show(self, session: Session) -> None:
        cell = self._cell = session.cell
        if cell is None:
            return
        self._places = places_of(cell)
        labels = tuple(each.label for each in self._places)
        offer(self._choice, labels, self._choice.value if self._choice.value in labels else labels[0])
        own = self._page.project.owns_cell(cell)
        self._note.content = quiet_html(_SAVED if own else _COPIED)
        self._show_form()

    @property
    def _place(self) -> Editable:
        return next(each for each in self._places if each.label == self._choice.value)

    def _show_form(self) -> None:
        if self._cell is not None:
            self._form.show(*fields_of(self._cell, self._place))
            self._form.reset()

    def _apply(self, changes: dict[YamlPath, Tree]) -> None:
        """Write the changes of the form, or show at its field why they are refused."""
        path, project = self._place.path, self._page.project
        edits = [CellEdit((*path, *key), value) for key, value in changes.items()]
        if edits and self._page.attempt(
            lambda session: session.edit_cell(edits, project), lambda error: self._form.refuse(error, path)
        ):
            self._form.accept()
            self._page.notify("Cell saved", f"{self._page.session.cell_name} is written. Undo takes it back.")


_NONE: str = "none"
_CELL, _WORKPIECE = "Whole cell", "Workpiece"
_CHOOSE = "Choose a cell to see whether its robot can run the program."


class RobotPanel:
    """The robot cell: its choice, its frames, its views and its cards."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui

        def held(session: Session) -> object:
            return session.cell, session.workpiece

        names, chosen = self._names(page.session), page.session.cell_name or _NONE
        hint = "Robot, tools and what stands around: samples, then your folder."
        self._choice = dropdown(gui, "Cell", names, hint, self._choose, initial_value=chosen)
        html(page, lambda now: about_html(now.cell), lambda now: now.cell)
        html(page, cell_mistakes_html, held)

        def look_at(what: str) -> None:
            self._look_at(cell=what == _CELL)

        look = buttons(gui, "Look at", (_CELL, _WORKPIECE), look_at, "View of the camera.")
        hint = "It stays where it is when hidden."
        seen = checkbox(gui, "Show the robot", True, hint, lambda shown: scene.robot.show(visible=shown))
        PaceCard(page)  # its folder comes first
        self.check = CheckCard(page, scene)
        CellForm(page)
        for card in (PlacementCard, ReachCard, JointsCard):
            card(page, scene)
        with folder(page, "Frames", lambda now: now.cell is not None, expanded=False):
            html(page, cell_frames_html, held)
        show_while(page, lambda now: now.cell is not None, look, seen)

        def show(session: Session) -> None:
            offer(self._choice, self._names(session), session.cell_name or _NONE)
            if session.cell is not None:
                scene.robot.show(visible=seen.value)

        page.follow(show, lambda now: now.cell)

    def _names(self, session: Session) -> tuple[str, ...]:
        return tuple(dict.fromkeys([_NONE, *self._page.project.cells(), session.cell_name or _NONE]))

    def _choose(self, name: str) -> None:
        if name == (self._page.session.cell_name or _NONE):
            return

        def change(session: Session) -> Session:
            if name == _NONE:
                return session.with_cell("", None)
            return session.with_cell(name, self._page.project.open_cell(name))

        if self._page.attempt(change):
            self._look_at(cell=name != _NONE)
        else:
            self._choice.value = self._page.session.cell_name or _NONE

    def _look_at(self, *, cell: bool) -> None:
        if cell:
            self._scene.look_at_cell()
        else:
            self._scene.look_at_board()


def about_html(loaded: LoadedCell | None) -> str:
    """Robot, tools and fixtures of a cell."""
    if loaded is None:
        return box_html(_CHOOSE)
    cell = loaded.cell
    facts = {
        "Robot": f"{cell.robot.name}, {cell.robot.dof} joints",
        "Tools": ", ".join(f"{tool.number} {tool.name}" for tool in cell.tools),
        "Around": ", ".join(dict.fromkeys(body.name for body in cell.fixtures)) or "nothing",
        "Workpiece": f"held by the {describe_held(cell.held_by)}",
        "Margin": f"{1000 * cell.margin:g} mm",
    }
    return box_html(escape(loaded.spec.description) + facts_html(facts))


def cell_mistakes_html(session: Session) -> str:
    """Probable mistakes in the cell of a session."""
    if session.cell is None:
        return ""
    return mistakes_html(check_cell(session.cell.cell, session.workpiece, session.cell.spec.io))


def cell_frames_html(session: Session) -> str:
    """Frames of the cell of a session."""
    return "" if session.cell is None else frames_html(frame_card(session.cell.cell, session.workpiece))


def frames_html(frames: Sequence[Frame]) -> str:
    """Places and directions of frames, to be compared with the real cell."""
    rows = ""
    for frame in frames:
        numbers = [f"{value:z.1f}".replace("-", "\N{MINUS SIGN}") for value in frame.place_mm]
        cells = "".join(f'<td style="text-align:right;padding:1px 0 1px 8px">{number}</td>' for number in numbers)
        rows += f'<tr style="white-space:nowrap"><td>{escape(frame.what.capitalize())}</td>{cells}</tr>'
        if frame.looks:
            rows += f'<tr><td colspan="4">{small_html(escape(frame.looks))}</td></tr>'
    table = f'<table style="width:100%;border-collapse:collapse;font-variant-numeric:tabular-nums">{rows}</table>'
    return box_html(grey_html("x, y, z (mm) in the cell; its z is up.", "margin-bottom:4px") + table)
