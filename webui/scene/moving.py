"""What changes in a scene: the nozzle with its jet, the robot in its cell, the heat map."""

import threading
from collections.abc import Collection, Mapping, Sequence

import numpy as np
import viser

from cleaning.surface.facets import Facets
from geometry.arrays import Points, Scalars
from robotcell.cell.cell import Cell
from robotcell.robot.meshes import placed_triangles
from robotcell.robot.robot import Body, Poses, inverse, link_poses
from webui.glb.glb import Colours, as_seen
from webui.layers.paths.nozzle import Moment, cone_of, nozzle_body, outlines_of
from webui.layers.robot.robot import bodies_glb
from webui.layers.surface.heat import HeatPiece, has_changed, heat_pieces, paint_piece, shade
from webui.theme.palette import COLLIDING, QUIET, ROBOT, SELECTED, STAND, TOOL, Tint
from webui.threads.threads import start_timer

_M, _MM = 0.001, 1000.0
_STEEL = (124, 136, 146)
_SAME_MM = 0.02
"""A rim that moved less against the orifice is not sent again."""
_NONE: frozenset[str] = frozenset()


class NozzleView:
    """Draws one nozzle; for pages and recordings."""

    def __init__(self, api: viser.SceneApi, tints: Mapping[str, Tint]) -> None:
        """Create the nodes, hidden.

        Args:
            api: The scene.
            tints: Colour of each function's jet.
        """
        self._tints = dict(tints)
        corners, faces = nozzle_body()
        rim, faces_of_cone = cone_of(np.zeros((96, 3)))
        self._frame = api.add_frame("/tool", show_axes=False, visible=False)
        api.add_mesh_simple("/tool/body", corners * _M, faces, color=_STEEL, cast_shadow=False)
        self._cone = api.add_mesh_simple(
            "/jet", rim, faces_of_cone, color=QUIET, opacity=0.28, side="double", visible=False, cast_shadow=False
        )
        self._front = api.add_line_segments(
            "/front", np.zeros((1, 2, 3)), SELECTED, thickness=2.5, thickness_units="screen", visible=False
        )
        self._rim: Points = np.empty((0, 3))
        self._function = ""

    def show(self, moment: Moment) -> None:
        """Show the nozzle at a time of the program."""
        place = moment.tcp * _M
        self._frame.position, self._frame.wxyz = place, moment.quaternion
        if not self._frame.visible:
            self._frame.visible = True
        sprays = len(moment.rim) > 0
        if sprays:
            self._cone.position = self._front.position = place
            self._shape(moment)
        self._switch(sprays)

    def hide(self) -> None:
        """Hide the nozzle."""
        self._frame.visible = False
        self._switch(False)

    def recolour(self, tints: Mapping[str, Tint]) -> None:
        """Set the colours of functions."""
        self._tints, self._function = dict(tints), ""

    def _switch(self, spraying: bool) -> None:
        if self._cone.visible != spraying:
            self._cone.visible = self._front.visible = spraying

    def _shape(self, moment: Moment) -> None:
        if moment.function != self._function:
            self._function = moment.function
            self._cone.color = self._tints.get(moment.function, QUIET)
        if self._rim.shape == moment.rim.shape and np.abs(self._rim - moment.rim).max() < _SAME_MM:
            return
        self._rim = moment.rim
        self._cone.vertices = (cone_of(moment.rim)[0] * _M).astype(np.float32)
        self._front.points = (outlines_of(moment.rim, moment.core) * _M).astype(np.float32)


class RobotView:
    """Draws one cell around the board, which is fixed; for pages and recordings."""

    def __init__(self, api: viser.SceneApi) -> None:
        """Show nothing yet.

        Args:
            api: The scene, in metres and in the board's frame.
        """
        self._api = api
        self._cell: Cell | None = None
        self._root: viser.FrameHandle | None = None
        self._links: list[viser.FrameHandle] = []
        self._tools: dict[int, viser.FrameHandle] = {}
        self._marked: frozenset[str] = _NONE
        self._bodies: dict[str, viser.GlbHandle] = {}
        self._pose: tuple[Scalars, int] | None = None

    @property
    def cell(self) -> Cell | None:
        """The cell that is drawn."""
        return self._cell

    def show_cell(self, cell: Cell | None) -> None:
        """Draw another cell, its robot at home with its first tool; ``None`` removes it."""
        if self._root is not None:
            self._root.remove()
            self._root = None
        self._cell, self._marked = cell, _NONE
        self._links, self._tools, self._bodies = [], {}, {}
        if cell is None:
            return
        self._root = self._frame("/cell", inverse(cell.T_cell_board))
        self._frame("/cell/robot", cell.T_cell_base)
        self._links = [self._frame(_link_name(link), np.eye(4)) for link in range(cell.robot.dof + 1)]
        flange = _link_name(cell.robot.dof)
        self._tools = {
            tool.number: self._frame(f"{flange}/tool_{tool.number}", cell.robot.T_link_flange) for tool in cell.tools
        }
        self._draw_bodies(cell, None)
        self.stand(cell.home, min(self._tools, default=0))

    def stand(self, joints: Scalars, tool: int) -> None:
        """Move the robot.

        Args:
            joints: (dof,) rad or m.
            tool: Number of the mounted tool; others are hidden.
        """
        if self._cell is None:
            return
        self._pose = (joints, tool)
        for frame, pose in zip(self._links, link_poses(self._cell.robot, joints[None])[0], strict=True):
            _place(frame, pose)
        for number, frame in self._tools.items():
            if frame.visible != (number == tool):
                frame.visible = number == tool

    def mark(self, names: Collection[str]) -> None:
        """Draw the bodies of these names as colliding, and no others."""
        before, self._marked = self._marked, frozenset(names)
        if self._cell is not None and before != self._marked:
            self._draw_bodies(self._cell, before)

    def show(self, *, visible: bool) -> None:
        """Show or hide the cell; the robot keeps its pose."""
        if self._root is not None:
            self._root.visible = visible

    def bounds_mm(self) -> tuple[Points, Points] | None:
        """Lowest and highest corner, mm, board frame, of robot and tool at present; ``None`` without a cell."""
        if self._cell is None or self._pose is None:
            return None
        return robot_bounds_mm(self._cell, *self._pose)

    def _draw_bodies(self, cell: Cell, marked_before: frozenset[str] | None) -> None:
        """Draw all bodies, or those whose mark changed."""
        flange = _link_name(cell.robot.dof)
        groups: dict[str, tuple[Sequence[Body], Tint]] = {"/cell/fixtures": (cell.fixtures, STAND)}
        groups |= {f"{_link_name(link)}/body": (bodies, ROBOT) for link, bodies in enumerate(cell.robot.bodies)}
        groups |= {f"{flange}/tool_{tool.number}/body": (tool.bodies, TOOL) for tool in cell.tools}
        for name, (bodies, tint) in groups.items():
            names = {body.name for body in bodies}
            if marked_before is not None and names & marked_before == names & self._marked:
                continue
            old = self._bodies.pop(name, None)
            if old is not None:
                old.remove()
            glb = bodies_glb(bodies, tint, self._marked, COLLIDING)
            if glb:
                self._bodies[name] = self._api.add_glb(name, glb, cast_shadow=False)

    def _frame(self, name: str, pose: Poses) -> viser.FrameHandle:
        frame = self._api.add_frame(name, show_axes=False)
        _place(frame, pose)
        return frame


def robot_bounds_mm(cell: Cell, joints: Scalars, tool: int) -> tuple[Points, Points]:
    """Lowest and highest corner, (3,) mm in the board frame, of robot and tool."""
    robot, onto = cell.robot, inverse(cell.T_cell_board) @ cell.T_cell_base
    links = onto @ link_poses(robot, joints[None])[0]
    carried = [(body, pose) for bodies, pose in zip(robot.bodies, links, strict=True) for body in bodies]
    flange = links[-1] @ robot.T_link_flange
    carried += [(body, flange) for each in cell.tools if each.number == tool for body in each.bodies]
    corners = [placed_triangles(body).reshape(-1, 3) @ pose[:3, :3].T + pose[:3, 3] for body, pose in carried]
    points = np.concatenate([flange[None, :3, 3], *corners]) * _MM
    return points.min(axis=0), points.max(axis=0)


def _link_name(link: int) -> str:
    return f"/cell/robot/link_{link}"


def _place(frame: viser.FrameHandle, pose: Poses) -> None:
    from scipy.spatial.transform import Rotation

    frame.position = pose[:3, 3]
    frame.wxyz = Rotation.from_matrix(pose[:3, :3]).as_quat(scalar_first=True)


_FADE_S = 0.4
"""A browser needs some time to load a piece; the one that it replaces stays so long beneath it."""


class HeatView:
    """Draws the surface of one board in colours; other colours send only the pieces in which they differ."""

    def __init__(self, api: viser.SceneApi) -> None:
        """Show nothing yet.

        Args:
            api: The scene, in metres and in the board's frame.
        """
        self._api = api
        self._lock = threading.Lock()
        self._facets: Facets | None = None
        self._pieces: tuple[HeatPiece, ...] = ()
        self._colours: Colours | None = None
        self._shown: dict[int, viser.GlbHandle] = {}
        self._old: list[viser.GlbHandle] = []
        """Replaced, and still beneath what replaced them."""
        self._sent = 0

    def show(self, facets: Facets, colours: Colours) -> int:
        """Show a surface in colours.

        Args:
            facets: The surface.
            colours: (c, 3) of its cells.

        Returns:
            Number of bytes sent.
        """
        with self._lock:
            if facets is not self._facets:
                self._clear()
                self._facets, self._pieces = facets, heat_pieces(facets)
            changed = [at for at, piece in enumerate(self._pieces) if has_changed(piece, colours, self._colours)]
            old = [self._shown.pop(at) for at in changed if at in self._shown]
            shaded = as_seen(shade(colours, facets.cell_normals))
            sent = sum(self._add(at, paint_piece(self._pieces[at], shaded)) for at in changed)
            self._colours = colours
            self._old += old
        if old:
            start_timer(_FADE_S, self._sweep, old)
        return sent

    def hide(self) -> None:
        """Hide the map; its pieces are kept for the next time."""
        with self._lock:
            self._clear()

    def _clear(self) -> None:
        for handle in (*self._shown.values(), *self._old):
            handle.remove()
        self._shown, self._old, self._colours = {}, [], None

    def _sweep(self, replaced: list[viser.GlbHandle]) -> None:
        with self._lock:
            for handle in replaced:
                if handle in self._old:  # else it went with the rest
                    self._old.remove(handle)
                    handle.remove()

    def _add(self, number: int, glb: bytes) -> int:
        """Draw a piece under a new name: the replaced one is removed later, so that nothing flickers."""
        self._sent += 1
        self._shown[number] = self._api.add_glb(f"/heat/{number}_{self._sent}", glb, scale=_M, cast_shadow=False)
        return len(glb)
