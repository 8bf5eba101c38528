"""A robot cell, as it stands: the robot, the board's place, tools, fixtures. Metres, radians.

Frames: ``cell`` is the room's own frame, z up; ``base`` the robot's; ``board`` the board's, which is in metres in here.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from programs.motion.installation import ToolPointMachine
from robotcell.cell.spec import HeldBy
from robotcell.errors import CellError
from robotcell.robot.robot import Body, Joints, Poses, Robot, flange_poses, link_poses


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


_MM = 1e3
_NEAR_MM, _NEAR = 0.01, 1e-4
"""mm and, of unit vectors, by how much the machine may differ from the module's formulas."""
_NAMES = ("X", "Y", "Z", "B", "C")


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
    away = (tip[:3, 3] - pivot) * _MM
    jet, length = tip[:3, 2], float(np.linalg.norm(away))
    side = np.cross(about_b, [0.0, 0.0, -1.0])
    zero, sign = math.atan2(side[1], side[0]), 1.0
    if not -0.5 * math.pi < zero <= 0.5 * math.pi + _NEAR:
        zero, sign, side = math.atan2(-side[1], -side[0]), -1.0, -side
    x, y, z = (float(value) for value in -pivot * _MM)
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
    axes = machine.axes(_in_mm(some))
    off = tips[:, :3, 3] * _MM + machine.base - axes[:, :3]
    c, b = axes[:, machine.swing], axes[:, 7 - machine.swing]
    jets = np.stack((np.sin(b) * np.cos(c), np.sin(b) * np.sin(c), -np.cos(b)), axis=1)
    turned = np.abs(tips[:, :3, 2] - jets).max()
    if np.abs(off).max() > _NEAR_MM or turned > _NEAR:
        raise CellError(
            f"robot {robot.name} with tool {tool.number} ({tool.name}) is no machine of 5axiskins: X, Y and Z along "
            "the base's axes, C about z, B across C through one point, the jet on a line from there. Use trivial."
        )


def _in_mm(joints: Joints) -> NDArray[np.float64]:
    return joints * np.array([_MM, _MM, _MM, 1.0, 1.0])
