"""A robot cell, as it stands: the robot, the board's place, tools, fixtures. Metres, radians.

Frames: ``cell`` is the room's own frame, z up; ``base`` the robot's; ``board`` the board's, which is in metres in here.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from programs.motion.installation import ToolPointMachine
from robotcell.cell.spec import HeldBy
from robotcell.robot.robot import Body, Joints, Poses, Robot


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
