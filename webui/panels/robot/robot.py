"""The robot cell: its choice, its frames, its views and its cards."""

from collections.abc import Sequence
from html import escape

from robotcell.cell.hold import describe_held
from robotcell.cell.load import LoadedCell
from robotcell.diagnosis.plausibility import Frame, check_cell, frame_card
from webui.cards.finding_list import mistakes_html
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.robot.cell_form import CellForm
from webui.panels.robot.check import CheckCard
from webui.panels.robot.pace import PaceCard
from webui.panels.robot.placement import PlacementCard
from webui.panels.robot.reach import JointsCard, ReachCard
from webui.panels.widgets.choices import offer, on_choice
from webui.scene.scene import Scene
from webui.theme.html import box_html, facts_html, grey_html, small_html

_NONE: str = "none"
_CELL, _WORKPIECE = "Whole cell", "Workpiece"
_CHOOSE = "Choose a cell to see whether its robot can run the program."


class RobotPanel:
    """The robot cell: its choice, its frames, its views and its cards."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        gui = page.client.gui
        self._choice = gui.add_dropdown(
            "Cell",
            self._names(page.session),
            initial_value=page.session.cell_name or _NONE,
            hint="Robot, tools and what stands around: samples, then your folder.",
        )
        self._about = gui.add_html("")
        self._mistakes = gui.add_html("")
        self._look = gui.add_button_group("Look at", (_CELL, _WORKPIECE), visible=False, hint="View of the camera.")
        self._seen = gui.add_checkbox("Show the robot", True, visible=False, hint="It stays where it is when hidden.")
        pace = PaceCard(page)  # its folder comes first
        self._cards = (
            CheckCard(page, scene), CellForm(page), PlacementCard(page, scene), ReachCard(page, scene),
            JointsCard(page, scene), pace,
        )  # fmt: skip
        self._folder = gui.add_folder("Frames", visible=False, expand_by_default=False)
        with self._folder:
            self._frames = gui.add_html("")
        on_choice(self._choice, self._choose)
        self._look.on_click(lambda event: self._look_at(cell=event.target.value == _CELL))
        self._seen.on_update(lambda event: scene.robot.show(visible=event.target.value))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        for card in self._cards:
            card.show(session, before)
        if before is None or session.cell is not before.cell or session.workpiece is not before.workpiece:
            self._folder.visible = session.cell is not None
            self._mistakes.content = ""
            if session.cell is not None:
                cell, workpiece, io = session.cell.cell, session.workpiece, session.cell.spec.io
                self._frames.content = frames_html(frame_card(cell, workpiece))
                self._mistakes.content = mistakes_html(check_cell(cell, workpiece, io))
        if before is not None and session.cell is before.cell:
            return
        offer(self._choice, self._names(session), session.cell_name or _NONE)
        self._about.content = about_html(session.cell)
        self._look.visible = self._seen.visible = session.cell is not None
        if session.cell is not None:
            self._scene.robot.show(visible=self._seen.value)

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


def frames_html(frames: Sequence[Frame]) -> str:
    """Places and directions of frames, to be compared with the real cell."""
    rows = ""
    for frame in frames:
        numbers = [f"{value:.1f}".replace("-0.0", "0.0").replace("-", "\N{MINUS SIGN}") for value in frame.place_mm]
        cells = "".join(f'<td style="text-align:right;padding:1px 0 1px 8px">{number}</td>' for number in numbers)
        rows += f'<tr style="white-space:nowrap"><td>{escape(frame.what.capitalize())}</td>{cells}</tr>'
        if frame.looks:
            rows += f'<tr><td colspan="4">{small_html(escape(frame.looks))}</td></tr>'
    table = f'<table style="width:100%;border-collapse:collapse;font-variant-numeric:tabular-nums">{rows}</table>'
    return box_html(grey_html("x, y, z (mm) in the cell; its z is up.", "margin-bottom:4px") + table)
