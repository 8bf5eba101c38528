"""A robot cell, as it stands: the robot, the board's place, tools, fixtures. Metres, radians.

Frames: ``cell`` is the room's own frame, z up; ``base`` the robot's; ``board`` the board's, which is in metres in here.
"""

from dataclasses import dataclass

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
    """(4, 4)"""
    home: Joints
    """(dof,) where a program begins and ends."""
    tools: tuple[Tool, ...]
    fixtures: tuple[Body, ...]
    """What stands in the cell; carried by the cell frame."""
    margin: float
    """m that every body of robot and tool keeps from board and fixtures."""
