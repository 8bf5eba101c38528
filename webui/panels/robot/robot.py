"""The robot: which cell, where its frames are, and how it is looked at."""

from html import escape

from robotcell.cell.load import LoadedCell
from robotcell.diagnosis.frame_table import frame_card
from robotcell.diagnosis.plausibility import check_cell
from webui.cards.frame_card import frames_html, mistakes_html
from webui.forms.dropdown import offer
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.robot.check import CheckCard
from webui.panels.robot.joints import JointsCard
from webui.panels.robot.reach import ReachCard
from webui.scene.scene import Scene
from webui.theme.palette import INK, QUIET, to_hex

_NONE: str = "none"
_CELL, _BOARD = "Whole cell", "Board"


class RobotPanel:
    """The robot: which cell, where its frames are, and how it is looked at."""

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
        self._look = gui.add_button_group("Look at", (_CELL, _BOARD), visible=False, hint="Where the camera stands.")
        self._seen = gui.add_checkbox("Show the robot", True, visible=False, hint="It stays where it is when hidden.")
        self._cards = (CheckCard(page, scene), ReachCard(page, scene), JointsCard(page, scene))
        self._folder = gui.add_folder("Frames", visible=False, expand_by_default=False)
        with self._folder:
            self._frames = gui.add_html("")
        self._choice.on_update(lambda event: self._choose(event.target.value, by_hand=event.client is not None))
        self._look.on_click(lambda event: self._fly(event.target.value))
        self._seen.on_update(lambda event: self._hide_or_show(seen=event.target.value))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        for card in self._cards:
            card.show(session, before)
        if before is None or session.cell is not before.cell or session.board is not before.board:
            self._show_frames(session)
        if before is not None and session.cell is before.cell:
            return
        offer(self._choice, self._names(session), session.cell_name or _NONE)
        self._about.content = about_html(session.cell)
        self._look.visible = self._seen.visible = session.cell is not None
        if session.cell is not None:
            self._hide_or_show(seen=self._seen.value)

    def _show_frames(self, session: Session) -> None:
        self._folder.visible = session.cell is not None
        self._mistakes.content = ""
        if session.cell is not None:
            cell, board, io = session.cell.cell, session.board, session.cell.spec.io
            self._frames.content = frames_html(frame_card(cell, board))
            self._mistakes.content = mistakes_html(check_cell(cell, board, io))

    def _names(self, session: Session) -> tuple[str, ...]:
        return tuple(dict.fromkeys([_NONE, *self._page.project.cells(), session.cell_name or _NONE]))

    def _choose(self, name: str, *, by_hand: bool) -> None:
        if not by_hand or name == (self._page.session.cell_name or _NONE):
            return
        done = self._page.attempt(lambda session: self._with_cell(session, name))
        if not done:
            self._choice.value = self._page.session.cell_name or _NONE
        elif name == _NONE:
            self._scene.look_at_board()
        else:
            self._scene.look_at_cell()

    def _with_cell(self, session: Session, name: str) -> Session:
        """Take up a cell.

        Raises:
            JobError: it cannot be read.
        """
        if name == _NONE:
            return session.with_cell("", None)
        return session.with_cell(name, self._page.project.open_cell(name))

    def _fly(self, where: str) -> None:
        if where == _CELL:
            self._scene.look_at_cell()
        else:
            self._scene.look_at_board()

    def _hide_or_show(self, *, seen: bool) -> None:
        if seen:
            self._scene.robot.show()
        else:
            self._scene.robot.hide()


def about_html(loaded: LoadedCell | None) -> str:
    """Say what a cell is: its robot, tools and what stands around."""
    if loaded is None:
        return _lines_html("Choose a cell to see whether its robot can run the program.")
    cell = loaded.cell
    tools = ", ".join(f"{tool.number} {tool.name}" for tool in cell.tools)
    around = ", ".join(dict.fromkeys(body.name for body in cell.fixtures))
    rows = {
        "Robot": f"{cell.robot.name}, {cell.robot.dof} joints",
        "Tools": tools,
        "Around": around or "nothing",
        "Margin": f"{1000 * cell.margin:g} mm",
    }
    table = "".join(
        f'<tr><td style="color:{to_hex(QUIET)};padding:1px 12px 1px 0;vertical-align:top">{name}</td>'
        f"<td>{escape(text)}</td></tr>"
        for name, text in rows.items()
    )
    return (
        f'{_lines_html(loaded.spec.description)}<table style="margin:2px 12px;font-size:12px;color:{to_hex(INK)};'
        f'border-collapse:collapse">{table}</table>'
    )


def _lines_html(text: str) -> str:
    return f'<div style="margin:4px 12px;font-size:12px;color:{to_hex(INK)}">{escape(text)}</div>' if text else ""
