"""Pivot length, zeros and signs of a gantry as LinuxCNC's ``5axiskins`` has them, proved by forward kinematics."""

import math

import numpy as np
from numpy.typing import NDArray

from programs.motion.installation import ToolPointMachine
from robotcell.cell.cell import Cell, Tool
from robotcell.errors import CellError
from robotcell.robot.robot import Joints, flange_poses, link_poses

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
