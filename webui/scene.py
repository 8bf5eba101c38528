"""The scene: board, paths and what is selected, redrawn where the session changed."""

from dataclasses import dataclass

import numpy as np
import viser

from boards.board import Board, Component
from webui.layers import ground, strokes
from webui.page import Page
from webui.palette import ACCENT
from webui.session import Session

_M = 0.001
"""The scene is in metres: a browser clips scenes of hundreds of units."""


@dataclass(frozen=True, slots=True)
class View:
    """What of a session is shown, and how; it stays when the session changes."""

    components_by: ground.ColourBy = "nothing"
    strokes_by: strokes.ColourBy = "function"
    hidden: frozenset[str] = frozenset()
    """Templates in their steps whose strokes are not shown, such as ``"sequence[0]/sweep"``."""
    transfers: bool = True


class Scene:
    """Draws a session for one browser."""

    def __init__(self, page: Page) -> None:
        """Set up light and camera."""
        self._page = page
        self._api = page.client.scene
        self._api.set_up_direction("+z")
        self._api.configure_default_lights(cast_shadow=False)
        self.view = View()
        self.strokes: list[strokes.StrokeLine] = []
        self.legends: dict[str, ground.Tints] = {}
        self._handles: dict[str, viser.GlbHandle] = {}

    def show(self, session: Session, before: Session | None) -> None:
        """Redraw what changed."""
        if before is None or session.board is not before.board:
            self.look_at_board(session.board)
            self._draw_ground(session)
        elif self.view.components_by == "class" and session.run is not before.run:
            self._draw_ground(session)
        if before is None or session.run is not before.run:
            self.strokes = [] if session.run is None else strokes.stroke_lines(session.run.plan)
            self._draw_strokes(session)
        if before is None or session.selection != before.selection or session.run is not before.run:
            self._draw_selection(session)

    def change_view(self, view: View) -> None:
        """Show the same session in another way."""
        before, self.view = self.view, view
        session = self._page.session
        if view.components_by != before.components_by:
            self._draw_ground(session)
        self._draw_strokes(session)

    def look_at_board(self, board: Board) -> None:
        """Look at the whole board from the front, from above."""
        low, high = (np.array(bound) for bound in (board.outline.bounds[:2], board.outline.bounds[2:]))
        centre = np.append((low + high) / 2, board.top_z_mm) * _M
        size = float(np.linalg.norm(high - low)) * _M
        self._fly(centre, centre + size * np.array([0.0, -0.75, 0.95]))

    def look_at(self, component: Component, board: Board) -> None:
        """Fly to a component."""
        place = component.outline.centroid
        centre = np.array([place.x, place.y, board.surface_z_mm(component.side)]) * _M
        size = max(0.03, 6 * float(np.sqrt(component.area_mm2)) * _M)
        up = 1.0 if component.side == "top" else -1.0
        self._fly(centre, centre + size * np.array([0.0, -0.7, 0.8 * up]))

    def _fly(self, centre: np.ndarray, eye: np.ndarray) -> None:
        camera = self._page.client.camera
        with self._page.client.atomic():
            camera.near = 0.001
            camera.up_direction = (0.0, 0.0, 1.0)
            camera.position = eye
            camera.look_at = centre

    def _draw_ground(self, session: Session) -> None:
        classified = () if session.run is None else session.run.classified
        tints, self.legends["components"] = ground.tint_components(session.board, classified, self.view.components_by)
        self._put("/board", ground.ground_glb(session.board, tints))

    def _draw_strokes(self, session: Session) -> None:
        shown = [line for line in self.strokes if line.place not in self.view.hidden]
        tints, self.legends["strokes"] = strokes.tint_strokes(shown, self.view.strokes_by)
        self._put("/strokes", strokes.strokes_glb(shown, tints))
        transfers = self.view.transfers and session.run is not None
        self._put("/transfers", strokes.transfers_glb(session.run.plan) if transfers and session.run else b"")

    def _draw_selection(self, session: Session) -> None:
        component = session.selection.component
        self._put("/selection", ground.component_glb(session.board, component, ACCENT))
        chosen = [line for line in self.strokes if line.made_by == session.selection.made_by]
        segments = np.concatenate(
            [np.empty((0, 2, 3)), *(np.stack([line.points[:-1], line.points[1:]], axis=1) for line in chosen)]
        )
        self._api.add_line_segments(
            "/chosen", points=segments * _M, colors=np.array(ACCENT), thickness=4.0, visible=len(segments) > 0
        )

    def _put(self, name: str, glb: bytes) -> None:
        """Show what is there under a name, in place of what was shown before."""
        handle = self._handles.pop(name, None)
        if handle is not None:
            handle.remove()
        if glb:
            self._handles[name] = self._api.add_glb(name, glb, scale=_M)
