"""The robot, its tools and what stands around it in a scene, moved from posture to posture."""

from collections.abc import Collection, Sequence

import numpy as np
import viser

from geometry.arrays import Points, Scalars
from robotcell.cell.cell import Cell
from robotcell.robot.poses import inverse
from robotcell.robot.robot import Body, Poses, link_poses
from webui.layers.paths.strokes import Tint
from webui.layers.robot.robot import bodies_glb, placed_triangles
from webui.theme.palette import COLLIDING, ROBOT, STAND, TOOL

_MM = 1000.0
_NOBODY: frozenset[str] = frozenset()


class RobotView:
    """Draws one cell around the board, which stays where it is; used by a page and by a recording alike."""

    def __init__(self, api: viser.SceneApi) -> None:
        """Show nothing yet.

        Args:
            api: Where to draw; its unit is the metre and its frame the board's.
        """
        self._api = api
        self._cell: Cell | None = None
        self._root: viser.FrameHandle | None = None
        self._links: list[viser.FrameHandle] = []
        self._tools: dict[int, viser.FrameHandle] = {}
        self._marked: frozenset[str] = _NOBODY
        self._bodies: dict[str, viser.GlbHandle] = {}
        self._posture: tuple[Scalars, int] | None = None

    @property
    def cell(self) -> Cell | None:
        """What is drawn."""
        return self._cell

    def show_cell(self, cell: Cell | None) -> None:
        """Draw another cell, its robot at home with its first tool; none takes it away."""
        if self._root is not None:
            self._root.remove()
            self._root = None
        self._cell, self._marked = cell, _NOBODY
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
        """Move the robot to a posture.

        Args:
            joints: (dof,) rad or m.
            tool: Number of the tool that it carries; others are not seen.
        """
        if self._cell is None:
            return
        self._posture = (joints, tool)
        for frame, pose in zip(self._links, link_poses(self._cell.robot, joints[None])[0], strict=True):
            _place(frame, pose)
        for number, frame in self._tools.items():
            if frame.visible != (number == tool):
                frame.visible = number == tool

    def mark(self, names: Collection[str]) -> None:
        """Draw the bodies of these names as ones that touch, and no others."""
        before, self._marked = self._marked, frozenset(names)
        if self._cell is not None and before != self._marked:
            self._draw_bodies(self._cell, before)

    def show(self) -> None:
        """Let it be seen."""
        if self._root is not None:
            self._root.visible = True

    def hide(self) -> None:
        """Let it not be seen; it stays where it is."""
        if self._root is not None:
            self._root.visible = False

    def bounds_mm(self) -> tuple[Points, Points] | None:
        """Lowest and highest corner, mm, board frame, of robot and tool as they stand; nothing without a cell."""
        if self._cell is None or self._posture is None:
            return None
        return robot_bounds_mm(self._cell, *self._posture)

    def _draw_bodies(self, cell: Cell, marked_before: frozenset[str] | None) -> None:
        """Draw all bodies, or those that are marked in another way than before."""
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
    """Lowest and highest corner, (3,) mm in the board frame, of robot and tool in a posture."""
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
