"""The best place of the workpiece: what is maximised, what was found, its worst point, and the cell with it there."""

from typing import Literal

import numpy as np
import viser

from reports.cards.placement import details_blocks
from reports.tables.table import Card
from robotcell.cell.cell_edits import board_edit
from robotcell.cell.load import LoadedCell
from robotcell.placement.evaluate import Criterion, PlacementGoal
from robotcell.placement.placement_map import MapGrid, reach_bounds
from robotcell.placement.reachability import Metric
from robotcell.search_placement import Relocation, find_place
from rulesengine.planning.pipeline import Run
from specs.progress import Progress
from webui.cards.drawings import boxes_html, map_html
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import button, checkbox, dropdown, folder
from webui.panels.widgets.job import RunButton
from webui.scene.scene import Scene
from webui.theme.html import card_html
from webui.theme.palette import COLLIDING

_METRICS: dict[str, Metric] = {
    "Manipulability": "manipulability",
    "Inverse condition": "condition",
    "Joint limits": "limits",
    "Clearance": "clearance",
}
_CRITERIA: dict[str, Criterion] = {"Worst point": "least", "5th percentile": "p5", "Mean": "mean"}
_MARK = "/placement/worst"
_M, _MARK_M, _AROUND_MM = 1e-3, 0.003, 60.0
_SAME = 1e-6


class PlacementCard:
    """A search for the best place of the workpiece, and what was found."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are visible where there is a cell."""
        self._page, self._scene = page, scene
        self._found: Relocation | None = None
        self._of: tuple[Run, LoadedCell] | None = None
        self._marker: viser.IcosphereHandle | None = None
        gui = page.client.gui
        with folder(page, "Best place", lambda now: now.cell is not None, expanded=False):
            self._metric = dropdown(gui, "Maximise", _METRICS, "Of the points of the program.")
            self._criterion = dropdown(gui, "Of the", _CRITERIA, "The mean may hide a bad point.")
            self._map = checkbox(gui, "Map", False, "40 x 40 places by 12 turns; takes up to a minute.")
            hint = "Searches distance and turn, then checks the program there."
            self._run: RunButton[Relocation] = RunButton(page, "Find the best place", self._search, hint)
            self._facts = gui.add_html("")
            hint = "It is marked in the scene."
            self._worst = button(gui, "Go to the worst point", self._go_to_worst, hint, visible=False)
            hint = "Writes the cell, then checks; Undo takes it back."
            self._move = button(gui, "Hold it there", self._hold_there, hint, visible=False)
            self._boxes = gui.add_html("")
            self._mapped = gui.add_html("")
            hint = "Cell, robot at the worst point, points, map; in metres."
            self._scene_file = button(gui, "Download the scene (GLB)", self._send_scene, hint, visible=False)
        page.follow(self._forget_others, lambda now: (now.run, now.cell))

    def _forget_others(self, session: Session) -> None:
        """Forget what was found for another program or cell; the cell may hold the workpiece where that was found."""
        if self._of is None:
            return
        run, searched = self._of
        cell = session.cell
        same = cell is not None and cell.spec.model_copy(update={"board": searched.spec.board}) == searched.spec
        there = self._found is not None and cell is not None and _holds_there(cell, self._found)
        if session.run is not run or not same or not ((cell is not None and cell.spec == searched.spec) or there):
            self._run.stop()
            self._put(None)

    def _search(self) -> None:
        session = self._page.session
        run, cell, mapped = session.planned_run, session.cell, self._map.value
        goal = PlacementGoal(_METRICS[self._metric.value], _CRITERIA[self._criterion.value])
        if cell is None:
            return
        self._put(None)
        self._of = run, cell
        self._run.start(lambda progress: search_place(run, cell, goal, progress, mapped=mapped), self._put)

    def _put(self, found: Relocation | None) -> None:
        """Show what was found; ``None`` shows nothing."""
        with self._page.client.atomic():
            self._found = found
            if found is None:
                self._of = None
            self._facts.content = "" if found is None else found_html(found)
            self._boxes.content = "" if found is None else boxes_html(found.details)
            mapped = None if found is None else found.mapped
            self._mapped.content = "" if found is None or mapped is None else map_html(found.details, mapped)
            self._worst.visible = self._scene_file.visible = found is not None
            self._move.visible = found is not None and found.moved_to is not None
            self._mark(found)

    def _mark(self, found: Relocation | None) -> None:
        """Mark the worst point in the scene; a click on it is a click on the button."""
        if self._marker is not None:
            self._marker.remove()
            self._marker = None
        if found is not None:
            at, _ = found.details.place_of(found.details.worst)
            self._marker = self._page.client.scene.add_icosphere(
                _MARK, radius=_MARK_M, color=COLLIDING, position=at, cast_shadow=False
            )
            self._marker.on_click(lambda _: self._go_to_worst())

    def _go_to_worst(self) -> None:
        if self._found is None:
            return
        details, cell = self._found.details, self._page.session.cell
        worst = details.worst
        if cell is not None and _holds_there(cell, self._found) and np.isfinite(details.joints[worst]).all():
            tool = cell.cell.tools[int(details.targets.tool[worst])].number
            self._scene.robot.stand(details.joints[worst], tool)
        x, y, z = (details.place_of(worst)[0] / _M).tolist()
        self._scene.look_at_place((x, y, z), _AROUND_MM)

    def _hold_there(self) -> None:
        """Write the place into the cell, and check the program there."""
        session, found = self._page.session, self._found
        if found is None or found.moved_to is None or session.cell is None:
            return
        edit = board_edit(session.cell.spec.board, found.moved_to)
        if self._page.attempt(lambda now: now.edit_cell([edit], self._page.project)):
            self._move.visible = False
            self._page.notify(
                "Held there", f"{self._page.session.cell_name} is written and checked. Undo takes it back."
            )
            self._page.check()

    def _send_scene(self) -> None:
        from reports.pictures.placement_picture import placement_glb

        if self._found is not None:
            content = placement_glb(self._found.details, self._found.workpiece, self._found.mapped)
            self._page.client.send_file_download("placement.glb", content, save_immediately=True)


def search_place(run: Run, cell: LoadedCell, goal: PlacementGoal, progress: Progress, *, mapped: bool) -> Relocation:
    """Search the best place of a program's workpiece, as ``washboard cell place`` does.

    Args:
        run: The program and its workpiece.
        cell: The cell.
        goal: What is maximised.
        progress: Receives the stage and the share done.
        mapped: Whether a map over all that the robot reaches is made too.

    Raises:
        JobError: the cell cannot be used with this program.
    """
    grid = MapGrid(reach_bounds(cell.cell)) if mapped else None
    return find_place(run.program, cell, run.workpiece, goal, grid, progress)


def found_html(found: Relocation) -> str:
    """What was found, the worst point, and what fails; whether the robot can do the program there."""
    words: dict[Literal["better", "same", "refused"], str] = {
        "better": "A better place was found, and the program checked there.",
        "same": "No better place was found: it stays where it is.",
        "refused": "No place was found where the robot can do the program.",
    }
    outcome = "refused" if found.refused else "same" if found.best is None else "better"
    evaluated = f"{found.evaluated} places looked at."
    return card_html(Card(words[outcome], (*details_blocks(found.details, found.mapped), evaluated)))


def _holds_there(cell: LoadedCell, found: Relocation) -> bool:
    return bool(np.allclose(cell.cell.T_cell_board, found.details.cell.T_cell_board, atol=_SAME))
