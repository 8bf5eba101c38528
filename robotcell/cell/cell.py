"""A robot cell, as it stands: the robot, the board's place, tools, fixtures, and where there is room. Metres, radians.

Frames: ``cell`` is the room's own frame, z up; ``base`` the robot's; ``board`` the board's, which is in metres in here.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise, product
from pathlib import Path
from typing import NamedTuple, TypeAlias, assert_never

import numpy as np

from boards.board import Workpiece
from geometry.arrays import Points, Triangles
from programs.motion.installation import ToolPointMachine
from robotcell.cell.spec import BodySpec, BoxSpec, CapsuleSpec, CylinderSpec, HeldBy, HoseSpec, MeshSpec, Place, Point
from robotcell.errors import CellError, error_at, errors_at
from robotcell.robot.meshes import STEP_ENDINGS, cylinder_triangles, read_mesh, read_step_solids
from robotcell.robot.robot import (
    Body,
    Box,
    Capsule,
    Joints,
    Mesh,
    Poses,
    Robot,
    flange_poses,
    inverse,
    link_poses,
    pose,
)
from specs.yaml.located import Located, YamlPath

_MM, _MM_PER_M = 1e-3, 1e3
MACHINE_UNITS = np.array([_MM_PER_M, _MM_PER_M, _MM_PER_M, 1.0, 1.0])
"""Of a machine with tool points, in a metre or radian of its joints."""
_NEAR_MM, _NEAR = 0.01, 1e-4
"""mm and, of unit vectors, by how much such a machine may differ from the formulas of ``5axiskins``."""
_NAMES = ("X", "Y", "Z", "B", "C")
_SLACK = 1e-9
HasRoom: TypeAlias = Callable[[Poses], bool]
"""Whether a workpiece has room at a T_cell_board (4, 4)."""


@dataclass(frozen=True, slots=True, eq=False)
class Tool:
    """The tool on the flange while a nozzle is used."""

    number: int
    """As in the program's ``NOZZLE name TOOL n``."""
    name: str
    T_flange_tcp: Poses
    """(4, 4) the orifice: +Z along the jet, +X the nozzle's reference azimuth."""
    bodies: tuple[Body, ...]
    """Nozzle body, holder, hose: carried by the flange."""


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """The robot and all that its motion depends on."""

    name: str
    robot: Robot
    T_cell_base: Poses
    """(4, 4)"""
    T_cell_board: Poses
    """(4, 4) the frame of the board's file; that of the held point as long as the cell holds no board."""
    home: Joints
    """(dof,) where a program begins and ends."""
    tools: tuple[Tool, ...]
    fixtures: tuple[Body, ...]
    """What stands in the cell; carried by the cell frame."""
    margin: float
    """m that every body of robot and tool keeps from board and fixtures."""
    held_by: HeldBy = "origin"
    """The point of a board whose pose the cell's file gives."""
    T_board_held: Poses = field(default_factory=lambda: np.eye(4))
    """(4, 4) that point of the board it holds, with the board's axes."""
    tool_change: Joints | None = None
    """(dof,) where the tool is changed; ``None`` for at home."""
    tool_point: ToolPointMachine | None = None
    """Where the controller takes tool points, mm and rad: then joint moves go straight in those."""

    @property
    def change_place(self) -> Joints:
        """(dof,) where the tool is changed."""
        return self.home if self.tool_change is None else self.tool_change

    @property
    def held_pose(self) -> Poses:
        """(4, 4) T_cell_held: pose of the held point, as in the cell's file."""
        return self.T_cell_board @ self.T_board_held

    def with_held_at(self, T_cell_held: Poses) -> "Cell":
        """Give the cell with the held point elsewhere."""
        return replace(self, T_cell_board=T_cell_held @ np.linalg.inv(self.T_board_held))


def longest_reach(cell: Cell) -> float:
    """Give a bound on how far any orifice comes from the first joint, m: all lengths and travels in one line."""
    lengths = [float(np.linalg.norm(joint.T_parent_joint[:3, 3])) for joint in cell.robot.joints[1:]]
    travels = [max(abs(each.lowest), abs(each.highest)) for each in cell.robot.joints if each.kind == "prismatic"]
    tools = [float(np.linalg.norm(tool.T_flange_tcp[:3, 3])) for tool in cell.tools]
    return sum(lengths) + sum(travels) + float(np.linalg.norm(cell.robot.T_link_flange[:3, 3])) + max(tools)


def tool_point_machine(cell: Cell) -> ToolPointMachine:
    """Give a cell's machine in the terms of ``5axiskins``.

    Raises:
        CellError: it is another machine, a tool is not straight, or the tools differ in length.
    """
    robot = cell.robot
    names = [joint.name.upper() for joint in robot.joints]
    if sorted(names) != sorted(_NAMES) or names[:3] != ["X", "Y", "Z"]:
        found = ", ".join(joint.name for joint in robot.joints)
        raise CellError(f"5axiskins has joints X, Y, Z, then B and C; robot {robot.name} has {found}. Use trivial.")
    machines = [_machine(cell, tool, names.index("C")) for tool in cell.tools]
    for tool, machine in zip(cell.tools, machines, strict=True):
        _prove(cell, tool, machine)
        if abs(machine.pivot_mm - machines[0].pivot_mm) > _NEAR_MM:
            lengths = f"{machines[0].pivot_mm:g} and {machine.pivot_mm:g} mm"
            raise CellError(
                f"tools {cell.tools[0].number} and {tool.number} end {lengths} from the axis of B, and 5axiskins has "
                "one pivot length: mount tools of one length, or use trivial."
            )
    return machines[0]


def _machine(cell: Cell, tool: Tool, swing: int) -> ToolPointMachine:
    robot, tilt = cell.robot, 7 - swing
    rest = np.zeros((1, robot.dof))
    links = link_poses(robot, rest)[0, 1:]
    about_c, about_b = (links[at][:3, :3] @ robot.joints[at].axis for at in (swing, tilt))
    tip = (flange_poses(robot, rest) @ tool.T_flange_tcp)[0]
    pivot = links[tilt][:3, 3] + about_b * (about_b @ (tip[:3, 3] - links[tilt][:3, 3]))
    away = (tip[:3, 3] - pivot) * _MM_PER_M
    jet, length = tip[:3, 2], float(np.linalg.norm(away))
    side = np.cross(about_b, [0.0, 0.0, -1.0])
    zero, sign = math.atan2(side[1], side[0]), 1.0
    if not -0.5 * math.pi < zero <= 0.5 * math.pi + _NEAR:
        zero, sign, side = math.atan2(-side[1], -side[0]), -1.0, -side
    x, y, z = (float(value) for value in -pivot * _MM_PER_M)
    return ToolPointMachine(
        pivot_mm=length,
        base=(x, y, z + length),
        swing=swing,
        swing_zero=round(zero, 12) + 0.0,
        signs=(float(np.sign(about_c[2])), sign),
        tilt_zero=round(math.atan2(float(jet @ side), float(-jet[2])), 12) + 0.0,
    )


def _prove(cell: Cell, tool: Tool, machine: ToolPointMachine) -> None:
    """Compare the formulas of the module with the forward kinematics of the cell."""
    robot = cell.robot
    some = np.array(
        [[0, 0, 0, 0, 0], [0.1, 0, 0, 0.5, 0], [0, 0.1, 0, 0, 0.4], [0, 0, 0.1, 2.0, -0.7]], dtype=np.float64
    )
    tips = flange_poses(robot, some) @ tool.T_flange_tcp
    axes = machine.axes(some * MACHINE_UNITS)
    off = tips[:, :3, 3] * _MM_PER_M + machine.base - axes[:, :3]
    c, b = axes[:, machine.swing], axes[:, 7 - machine.swing]
    jets = np.stack((np.sin(b) * np.cos(c), np.sin(b) * np.sin(c), -np.cos(b)), axis=1)
    turned = np.abs(tips[:, :3, 2] - jets).max()
    if np.abs(off).max() > _NEAR_MM or turned > _NEAR:
        raise CellError(
            f"robot {robot.name} with tool {tool.number} ({tool.name}) is no machine of 5axiskins: X, Y and Z along "
            "the base's axes, C about z, B across C through one point, the jet on a line from there. Use trivial."
        )


def place_pose(place: Place) -> Poses:
    """Convert a pose as written to (4, 4), metres."""
    return pose([_MM * value for value in place.xyz_mm], np.radians(place.rpy_deg).tolist())


def build_bodies(specs: dict[str, BodySpec], root: Located, path: YamlPath) -> tuple[Body, ...]:
    """Build the bodies of a tool or of the cell's fixtures.

    A hose becomes one rod for each of its pieces, a STEP file one mesh for each of its solids.

    Args:
        specs: By name.
        root: The file they stand in; the path of a mesh begins at the folder of the file that names it.
        path: Where in that file.

    Raises:
        CellError: a mesh cannot be read, or a rod has no length.
    """
    bodies: list[Body] = []
    for name, spec in specs.items():
        match spec:
            case BoxSpec():
                x, y, z = (_MM * value for value in spec.size_mm)
                bodies.append(Body(name, Box((x, y, z)), place_pose(spec.at)))
            case CapsuleSpec():
                length, middle = _along(spec.from_mm, spec.to_mm, root, (*path, name))
                bodies.append(Body(name, Capsule(_MM * spec.radius_mm, length), middle))
            case CylinderSpec():
                length, middle = _along(spec.from_mm, spec.to_mm, root, (*path, name))
                bodies.append(Body(name, Mesh(cylinder_triangles(_MM * spec.radius_mm, length)), middle))
            case HoseSpec():
                for start, end in pairwise(spec.along_mm):
                    length, middle = _along(start, end, root, (*path, name))
                    bodies.append(Body(name, Capsule(_MM * spec.radius_mm, length), middle))
            case MeshSpec():
                solids = _read_solids(spec, root, (*path, name))
                bodies += [Body(name, Mesh(triangles), place_pose(spec.at)) for triangles in solids]
            case _:
                assert_never(spec)
    return tuple(bodies)


def _read_solids(spec: MeshSpec, root: Located, path: YamlPath) -> tuple[Triangles, ...]:
    """Read the triangles (n, 3, 3) of each solid that a file has: one but for STEP, metres."""
    file = Path(root.at((*path, "file")).mark.file).parent / spec.file
    is_step = file.suffix.lower() in STEP_ENDINGS
    if is_step and spec.mm_per_unit != 1.0:
        raise error_at(root, (*path, "mm_per_unit"), "a STEP file states its unit; leave it out")
    with errors_at(root, (*path, "file")):
        return read_step_solids(file) if is_step else (_MM * spec.mm_per_unit * read_mesh(file),)


def _along(start_mm: Point, end_mm: Point, root: Located, path: YamlPath) -> tuple[float, Poses]:
    """Give the length of a rod and the (4, 4) pose of its middle, z along it; its x is level with the x-y plane."""
    start, end = np.array(start_mm), np.array(end_mm)
    length = float(np.linalg.norm(end - start))
    if length < 1e-6:
        raise error_at(root, path, "begins where it ends; a rod has a length")
    x, y, z = (end - start) / length
    pitch, yaw = float(np.arctan2(np.hypot(x, y), z)), float(np.arctan2(y, x))
    return _MM * length, pose((0.5 * _MM * (start + end)).tolist(), (0.0, pitch, yaw))


class TableBounds(NamedTuple):
    """A rectangle of the cell's x and y, m, in which the whole workpiece has to be."""

    x: tuple[float, float]
    y: tuple[float, float]


def room_on_table(bounds: TableBounds, points: Points) -> HasRoom:
    """Give the check whether points (n, 3) of the board's frame, m, are all above a rectangle of the cell."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = points[ConvexHull(points).vertices]
    except QhullError:
        hull = points  # they lie in a plane
    low, high = np.array([bounds.x[0], bounds.y[0]]) - _SLACK, np.array([bounds.x[1], bounds.y[1]]) + _SLACK

    def has_room(T_cell_board: Poses) -> bool:
        seen = hull @ T_cell_board[:2, :3].T + T_cell_board[:2, 3]
        return bool(np.all((seen >= low) & (seen <= high)))

    return has_room


def all_rooms(*rooms: HasRoom | None) -> HasRoom | None:
    """Join checks: there is room where all of them find some; ``None`` where there is no check."""
    known = [room for room in rooms if room is not None]
    return (lambda T_cell_board: all(room(T_cell_board) for room in known)) if known else None


def room_of(cell: Cell, board: Workpiece) -> HasRoom:
    """Give the check whether the box around a board keeps clear of fixtures and of the robot's base.

    What the box meets at the present place is left out: that is intended.
    """
    low, high = board_box(board)
    around = [corners_of(body) for body in cell.fixtures]
    base = [corners_of(body) for body in cell.robot.bodies[0]]
    around += [corners @ cell.T_cell_base[:3, :3].T + cell.T_cell_base[:3, 3] for corners in base]
    kept = [corners for corners in around if not meets_box(corners, low, high, cell.T_cell_board)]
    return lambda T_cell_board: not any(meets_box(corners, low, high, T_cell_board) for corners in kept)


def board_box(board: Workpiece) -> tuple[Points, Points]:
    """Give the lowest and the highest corner (3,) of the box around a board and its components, board frame, m."""
    low = np.min([body.patches.min(axis=(0, 1)) for body in board.bodies], axis=0) / _MM_PER_M
    return low, np.max([body.patches.max(axis=(0, 1)) for body in board.bodies], axis=0) / _MM_PER_M


def meets_box(corners: Points, low: Points, high: Points, T_cell_board: Poses) -> bool:
    """Whether the extent of points (n, 3) of the cell reaches into a box of the board's frame."""
    T_board_cell = inverse(T_cell_board)
    seen = corners @ T_board_cell[:3, :3].T + T_board_cell[:3, 3]
    return bool(np.all(seen.min(axis=0) < high) and np.all(seen.max(axis=0) > low))


def corners_of(body: Body) -> Points:
    """Give points (n, 3) that a body's convex hull is made of, in the frame of what carries it, m."""
    signs = np.array(list(product((-1.0, 1.0), repeat=3)))
    match body.shape:
        case Box(size):
            points = signs * np.array(size) / 2.0
        case Capsule(radius, length):
            points = signs * np.array([radius, radius, length / 2.0 + radius])
        case Mesh(triangles):
            points = triangles.reshape(-1, 3)
    return points @ body.T_carrier_shape[:3, :3].T + body.T_carrier_shape[:3, 3]
